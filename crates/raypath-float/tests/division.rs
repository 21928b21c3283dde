//! Quotients, reciprocals and square roots in hardware, combinational, pipelined and iterative, compared with the
//! format's software, which has its own tests; and their handshakes and latencies.

#![cfg(feature = "units")]

mod driver;
mod handshake;
mod results;
