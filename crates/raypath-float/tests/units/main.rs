//! Tests of the units: netlists executed as they stand, and in Verilator, against oracles that share nothing with them.

mod bench;
mod binary32;
mod exact;
mod integer;
mod other_formats;
mod small_formats;
mod verilator;
