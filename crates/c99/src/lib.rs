//! The types of C's `stdint.h` that the crate `softfloat-sys` names, in place of the crate `c99` on crates.io.
//!
//! That one finds them out by building a C program with CMake, by a file for version 2.6 that CMake 4 no longer takes. The ABIs have settled
//! them: a "fast" integer of 8 bits has 8, one of 64 has 64, and one of 32 has a register's width in 64-bit glibc, 32
//! elsewhere. `Cargo.toml` of the workspace puts this crate in the other's place.
#![allow(non_camel_case_types)]

/// `uint_fast8_t`.
pub type uint_fast8_t = u8;
/// `int_fast64_t`.
pub type int_fast64_t = i64;
/// `uint_fast64_t`.
pub type uint_fast64_t = u64;

#[cfg(all(target_env = "gnu", target_os = "linux"))]
mod by_target {
    pub type int_fast32_t = isize;
    pub type uint_fast32_t = usize;
}

#[cfg(not(all(target_env = "gnu", target_os = "linux")))]
mod by_target {
    pub type int_fast32_t = i32;
    pub type uint_fast32_t = u32;
}

/// `int_fast32_t`.
pub type int_fast32_t = by_target::int_fast32_t;
/// `uint_fast32_t`.
pub type uint_fast32_t = by_target::uint_fast32_t;
