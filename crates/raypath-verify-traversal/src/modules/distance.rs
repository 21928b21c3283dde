//! The closest hits of blocks, with the host's division.

use super::{Bench, number};
use rand::RngExt;
use raypath_ops::{Binary32, Num, Word, from_words, to_canonical_words};
use raypath_traversal::state::TriangleHit;
use raypath_traversal::{HitLimits, fold};

/// A block, and the outcomes of its triangles.
struct Block {
    /// `t_min`, whether clockwise and counter-clockwise triangles are culled, and the hit after which others count:
    /// whether there is one, its distance and its index.
    limits: [u64; 6],
    geometry: u64,
    indices: [u64; 3],
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy)]
struct Triangle {
    is_hit: bool,
    is_front: bool,
    /// Numerator and denominator of the distance, and the numerators of barycentric coordinates.
    numbers: [f32; 4],
}

/// What is compared. Some units have the numerators of barycentric coordinates.
const CLOSEST: [&str; 10] =
    ["is_hit", "has_more", "t", "t_num", "t_denom", "u_num", "v_num", "is_clockwise", "primitive", "geometry"];

/// The blocks of a check.
const BLOCKS: usize = 3_000;

/// Compares the closest hits of blocks, one after another. That each triangle keeps its context and its fraction while
/// others are inside is proved.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let [valid, context, is_hit, limits, index, taken] =
        bench.inputs(["valid_i", "context_i", "is_hit_i", "limits_t_min_i", "index_0_i", "taken_i"]);
    let [ready, is_complete] = bench.outputs(["ready_o", "valid_o"]);
    let fields = ["place_i", "is_last_i", "is_front_i", "t_num_i", "t_denom_i", "u_num_i", "v_num_i"];
    let fields = fields.map(|name| bench.input(name));
    // Without candidates no hit comes after another.
    let limits_count = if bench.input("limits_after_t_i").is_some() { 6 } else { 3 };
    let geometry = bench.input("geometry_i");
    let per_block = if bench.input("index_2_i").is_some() { 3 } else { 2 };
    let closest: Vec<Option<usize>> = CLOSEST.map(|name| bench.output(&format!("closest_{name}_o"))).into();
    for number in 0..BLOCKS {
        let block = random_block(bench, per_block, limits_count);
        let mut entered = 0;
        for cycle in 0.. {
            let words = bench.words();
            words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
            (0..limits_count).for_each(|k| bench.set(limits + k, block.limits[k]));
            geometry.into_iter().for_each(|input| bench.set(input, block.geometry));
            (0..per_block).for_each(|k| bench.set(index + k, block.indices[k]));
            let triangle = block.triangles.get(entered).filter(|_| !bench.chance(4));
            bench.set(valid, triangle.is_some().into());
            if let Some(triangle) = triangle {
                let [t_num, t_denom, u, v] = triangle.numbers.map(|number| u64::from(number.to_bits()));
                let is_last = entered + 1 == block.triangles.len();
                let values = [entered as u64, is_last.into(), triangle.is_front.into(), t_num, t_denom, u, v];
                bench.set(is_hit, triangle.is_hit.into());
                fields
                    .into_iter()
                    .zip(values)
                    .for_each(|(input, value)| input.into_iter().for_each(|k| bench.set(k, value)));
            }
            bench.set(context, number as u64 % 8);
            bench.set(taken, 1);
            bench.simulator.settle();
            entered += usize::from(triangle.is_some() && bench.get(ready) == 1);
            let found: Vec<u64> = closest.iter().flatten().map(|&output| bench.get(output)).collect();
            let has_closest = bench.get(is_complete) == 1;
            bench.simulator.cycle();
            if has_closest {
                let words = block.closest().into_iter().zip(&closest);
                let words: Vec<u64> = words.filter_map(|(word, port)| port.map(|_| word)).collect();
                // Without a hit the other ports are free.
                let is_same = if words[0] == 0 { found[0] == 0 } else { words == found };
                if !is_same {
                    return Err(format!("block {number} has {found:x?}, expected {words:x?}"));
                }
                break;
            }
            if cycle > LONGEST {
                return Err(format!("block {number} has no closest hit"));
            }
        }
    }
    Ok(())
}

/// More cycles than a block takes.
const LONGEST: u32 = 200;

/// Triangles of a block are often at the same distance, or at the least.
fn random_block(bench: &mut Bench, per_block: usize, limits_count: usize) -> Block {
    let random = &mut bench.random;
    // The datapath returns no other NaN.
    let canonical = |number: f32| if number.is_nan() { f32::NAN } else { number };
    let mut triangles: Vec<Triangle> = Vec::new();
    for _ in 0..random.random_range(1..=per_block) {
        let (t_num, t_denom) = match triangles.last() {
            Some(last) if random.random_range(0..2) == 0 => {
                let factor = [1.0, -1.0, 2.0][random.random_range(0..3)];
                (last.numbers[0] * factor, last.numbers[1] * factor)
            }
            _ => (number(random), number(random)),
        };
        let (is_hit, is_front) = (random.random_range(0..4) > 0, random.random());
        let numbers = [t_num, t_denom, number(random), number(random)].map(canonical);
        triangles.push(Triangle { is_hit, is_front, numbers });
    }
    let [t_num, t_denom, ..] = triangles[random.random_range(0..triangles.len())].numbers;
    let quotient = t_num / t_denom;
    let least = [0.0, 0.0, quotient, -quotient, number(random), f32::NEG_INFINITY][random.random_range(0..6)];
    let mut culls = || u64::from(random.random_range(0..4) == 0);
    let culls = [culls(), culls()];
    let first: u64 = random.random_range(0..1 << 32);
    let mut index = || (first ^ [0, 1 << random.random_range(0..32)][random.random_range(0..2)]) & 0xffff_ffff;
    let indices = [index(), index(), index()];
    let [t_num, t_denom, ..] = triangles[random.random_range(0..triangles.len())].numbers;
    let after = [random.random_range(0..2), u64::from((t_num / t_denom).to_bits()), indices[random.random_range(0..3)]];
    let after = if limits_count == 6 { after } else { [0; 3] };
    let limits = [u64::from(least.to_bits()), culls[0], culls[1], after[0], after[1], after[2]];
    Block { limits, geometry: random.random_range(0..1 << 32), indices, triangles }
}

impl Block {
    /// The words of its closest hit.
    fn closest(&self) -> Vec<u64> {
        let limits: HitLimits<Binary32> = from_words(Binary32, &self.limits);
        let mut closest: TriangleHit<Binary32> = from_words(Binary32, &[]);
        for (place, triangle) in self.triangles.iter().enumerate() {
            let [t_num, t_denom, u, v] = triangle.numbers;
            let found = TriangleHit {
                is_hit: triangle.is_hit.into(),
                has_more: false.into(),
                t: Num::from(t_num / t_denom),
                t_num: t_num.into(),
                t_denom: t_denom.into(),
                u_num: u.into(),
                v_num: v.into(),
                is_clockwise: (!triangle.is_front).into(),
                primitive: Word::truncate(self.indices[place] as u32),
                geometry: Word::truncate(self.geometry as u32),
            };
            closest = fold(closest, (place == 0).into(), found, limits);
        }
        let mut words = Vec::new();
        to_canonical_words(&closest, &mut words);
        words
    }
}
