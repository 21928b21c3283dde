//! Operations that the field asks for beside the paper's, each in its own file, written only against what `raypath-ops`
//! shows. A datapath has those that it is given, and none of these by default.
//!
//! `raypath operations` lists them, with what each adds to a datapath that has the paper's four.
//!
//! Beside its operation each file has what verification needs: `stimulus` draws a random job that matters, and `judge`
//! says what is wrong with an answer, by exact arithmetic or by counting, not by the operation's own equations.
//! A new operation is a new file in `src/operations`, which registers itself; nothing else names it.
//!
//! ```
//! use raypath_extra as _; // whoever links it has its operations registered
//! use raypath_lab::{Datapath, registered, rtl::Config};
//!
//! for study in registered() {
//!     let datapath = Datapath::paper(Config::DEFAULT).with_any(study.operation());
//!     let flip_flops = datapath.elaborate()?.top().register_bits();
//!     println!("with {}: {flip_flops} flip-flops", study.name());
//! }
//! # assert!(!registered().is_empty());
//! # Ok::<(), raypath_lab::rtl::Error>(())
//! ```

mod draw;
mod exact;
mod slabs;

#[cfg(test)]
mod check;

mod operations {
    automod::dir!(pub "src/operations");
}

pub use operations::*;
