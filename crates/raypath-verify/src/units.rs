//! Campaigns: every case through the netlists of the floating-point units, against oracles that share nothing with them.

mod conversions;
mod small_formats;
mod softfloat;

pub use conversions::{conversions, conversions_of};
pub use small_formats::{small_formats, small_formats_of};
pub use softfloat::{testfloat, testfloat_of};
