//! From sixteen records of numbers to blocks of sixteen equal fields.

use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use raypath_model::{BLOCK, BlockValue, baseline, transposed};

/// Field k of sixteen records, for each k. Bit patterns are kept.
#[inline(always)]
pub fn fields<const K: usize>(record: impl Fn(usize) -> [f32; K]) -> [BlockValue<f32>; K] {
    // Registers of four numbers, as every machine has them.
    let simd = baseline();
    let mut fields = [BlockValue([0.0; BLOCK]); K];
    for first in (0..BLOCK).step_by(4) {
        let records: [[f32; K]; 4] = [record(first), record(first + 1), record(first + 2), record(first + 3)];
        let whole = K / 4 * 4;
        for k in (0..whole).step_by(4) {
            let row = |i: usize| f32x4::from_slice(simd, &records[i][k..k + 4]);
            for (i, column) in transposed([row(0), row(1), row(2), row(3)]).iter().enumerate() {
                column.store_slice(&mut fields[k + i].0[first..first + 4]);
            }
        }
        for k in whole..K {
            fields[k].0[first..first + 4].copy_from_slice(&[0, 1, 2, 3].map(|i: usize| records[i][k]));
        }
    }
    fields
}
