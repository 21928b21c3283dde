//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod command_line;
mod configuration_files;
mod golden;
mod guides;
mod layout;
mod peers;
mod recorded;
mod semantics;
