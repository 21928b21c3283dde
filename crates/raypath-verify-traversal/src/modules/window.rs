//! The children of eight that a step takes, compared with a sort.

use super::{Bench, CYCLES};
use rand::RngExt;
use rand::seq::SliceRandom;
use std::cmp::Ordering;

/// Compares the places of each window. Where there is no child, its words may be any.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let halves = [
        bench.inputs(["lower_hit_i", "lower_tmin_0_i", "lower_box_index_0_i"]),
        bench.inputs(["upper_hit_i", "upper_tmin_0_i", "upper_box_index_0_i"]),
    ];
    let [window] = bench.inputs(["window_i"]);
    let [hit, tmin, index, upper] =
        bench.outputs(["window_hit_o", "window_tmin_0_o", "window_box_index_0_o", "window_box_upper_o"]);
    for case in 0..CYCLES {
        let (mut words, mut all) = (bench.words(), Vec::new());
        for (half, [hit, tmin, index]) in (0..).zip(halves) {
            // In a half hits come first, near to far, and of the same distance the lower number.
            let mut numbers = [0, 1, 2, 3];
            numbers.shuffle(&mut bench.random);
            let count = bench.random.random_range(0..=4);
            let mut own: Vec<(f32, u64)> = Vec::new();
            for number in &numbers[..count] {
                let near = NEAR[bench.random.random_range(0..NEAR.len())];
                let distance = if bench.chance(4) { bench.random.random_range(-2.0..3.0) } else { near };
                own.push((distance, *number));
            }
            own.sort_unstable_by(before);
            words[hit] = (1 << count) - 1;
            for (place, (distance, number)) in own.iter().enumerate() {
                (words[tmin + place], words[index + place]) = (distance.to_bits().into(), *number);
            }
            all.extend(own.into_iter().map(|(distance, number)| (distance, (half, number))));
        }
        all.sort_unstable_by(before);
        let taken = bench.random.random_range(0..3);
        words[window] = taken as u64;
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();
        let rest = all.get(3 * taken..).unwrap_or_default();
        let expected = (1 << rest.len().min(4)) - 1;
        let mut is_right = bench.get(hit) == expected;
        for (place, &(distance, (half, number))) in rest.iter().take(4).enumerate() {
            is_right &= place == 0 || bench.get(tmin + place - 1) == u64::from(distance.to_bits());
            is_right &= bench.get(index + place) == number && bench.get(upper) >> place & 1 == half;
        }
        if !is_right {
            return Err(format!("case {case}, window {taken}: found others than {rest:?}"));
        }
    }
    Ok(())
}

/// Distances that meet.
const NEAR: [f32; 5] = [-1.0, -0.0, 0.0, 1.0, 2.0];

/// The order of distances, and of numbers at the same distance.
fn before<N: Ord>((a, m): &(f32, N), (b, n): &(f32, N)) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal).then(m.cmp(n))
}
