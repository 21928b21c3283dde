//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod conservative;
mod ports;
mod ray;
mod triangle_features;
mod words;
