//! Work that threads and machines divide: [`pool`] runs numbered cases on all cores, with progress and cancellation, and
//! [`parts`] merges what several machines computed.

#[cfg(feature = "parts")]
pub mod parts;
pub mod pool;
