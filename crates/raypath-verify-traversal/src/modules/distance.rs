//! The closest hits of blocks, with the host's division.

use super::{Bench, CYCLES, number};
use rand::RngExt;
use raypath_ops::{Binary32, Num, Word, from_words, to_canonical_words};
use raypath_traversal::state::TriangleHit;
use raypath_traversal::{HitLimits, fold};
use std::collections::VecDeque;

/// A block, and the outcomes of its triangles.
struct Block {
    context: u64,
    /// `t_min`, `cull_back`, `cull_front`.
    limits: [u64; 3],
    indices: [u64; 3],
    triangles: Vec<Triangle>,
    /// Those that have entered.
    entered: usize,
}

#[derive(Clone, Copy)]
struct Triangle {
    is_hit: bool,
    is_front: bool,
    t_num: f32,
    t_denom: f32,
    /// The numerators of barycentric coordinates.
    uv: [f32; 2],
}

/// What is compared. Some units have the numerators of barycentric coordinates.
const CLOSEST: [&str; 8] = ["is_hit", "t", "t_num", "t_denom", "u_num", "v_num", "back_face", "triangle"];

/// Compares the closest hits of blocks that enter and are taken at random times. A triangle waits only where a
/// closest hit does.
///
/// A block of quantised nodes has one triangle and no places.
pub fn run(bench: &mut Bench, contexts: u32) -> Result<(), String> {
    let [valid, context] = bench.inputs(["valid_i", "context_i"]);
    let [place, is_last, u_num, v_num] = ["place_i", "is_last_i", "u_num_i", "v_num_i"].map(|name| bench.input(name));
    let per_block = if place.is_some() { 3 } else { 1 };
    let [is_hit, is_front, t_num, t_denom] = bench.inputs(["is_hit_i", "is_front_i", "t_num_i", "t_denom_i"]);
    let [limits, index, taken] = bench.inputs(["limits_t_min_i", "index_0_i", "taken_i"]);
    let [ready, read, read_context] = bench.outputs(["ready_o", "read_o", "read_context_o"]);
    let [is_complete, shown] = bench.outputs(["valid_o", "context_o"]);
    let closest: Vec<Option<usize>> = CLOSEST.map(|name| bench.output(&format!("closest_{name}_o"))).into();
    let mut blocks: VecDeque<Block> = VecDeque::new();
    // Each of two lists of words appears in the cycle after its context is read.
    let mut asked: Option<u64> = None;
    for cycle in 0..CYCLES {
        if blocks.back().is_none_or(|block| block.entered == block.triangles.len()) && blocks.len() < contexts as usize
        {
            let block = random_block(bench, &blocks, contexts, per_block);
            blocks.push_back(block);
        }
        let words = bench.words();
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        let offered = blocks.back().filter(|block| block.entered < block.triangles.len());
        let offered =
            offered.map(|block| (block.context, block.entered, block.triangles.len(), block.triangles[block.entered]));
        let offered = offered.filter(|_| !bench.chance(4));
        bench.set(valid, offered.is_some().into());
        if let Some((number, entered, count, triangle)) = offered {
            bench.set(context, number);
            let [u, v] = triangle.uv.map(|number| u64::from(number.to_bits()));
            let some = [(place, entered as u64), (is_last, (entered + 1 == count).into()), (u_num, u), (v_num, v)];
            some.into_iter().for_each(|(input, value)| input.into_iter().for_each(|input| bench.set(input, value)));
            let values = [triangle.is_hit.into(), triangle.is_front.into()];
            let numbers = [triangle.t_num, triangle.t_denom].map(|number| u64::from(number.to_bits()));
            [is_hit, is_front].into_iter().zip(values).for_each(|(input, value)| bench.set(input, value));
            [t_num, t_denom].into_iter().zip(numbers).for_each(|(input, value)| bench.set(input, value));
        }
        if let Some(block) = asked.and_then(|asked| blocks.iter().find(|block| block.context == asked)) {
            let (given, indices) = (block.limits, block.indices);
            (0..3).for_each(|k| bench.set(limits + k, given[k]));
            (0..per_block).for_each(|k| bench.set(index + k, indices[k]));
        }
        bench.set(taken, 0);
        bench.simulator.settle();
        let is_taken = bench.get(is_complete) == 1 && bench.chance(2);
        bench.set(taken, is_taken.into());
        bench.simulator.settle();

        if bench.get(is_complete) == 1 {
            let found: Vec<u64> = closest.iter().flatten().map(|&output| bench.get(output)).collect();
            let expected = blocks.front().filter(|block| block.entered == block.triangles.len());
            let wrong = |expected: String| {
                let context = bench.get(shown);
                Err(format!("cycle {cycle}: context {context} has {found:x?}, not {expected}"))
            };
            let Some(block) = expected else { return wrong("one of a block that is inside".to_string()) };
            let words = block.closest();
            let words: Vec<u64> =
                words.into_iter().zip(&closest).filter_map(|(word, port)| port.map(|_| word)).collect();
            let is_same = if words[0] == 0 { found[0] == 0 } else { words == found };
            if !is_same || bench.get(shown) != block.context {
                return wrong(format!("{words:x?} of context {}", block.context));
            }
        }
        let waits = bench.get(is_complete) == 1 && !is_taken;
        if bench.get(ready) == 0 && !waits {
            return Err(format!("cycle {cycle}: a triangle waits, and no closest hit does"));
        }
        if bench.get(read) == 1 {
            asked = Some(bench.get(read_context));
        }
        if is_taken {
            blocks.pop_front();
        }
        if offered.is_some()
            && bench.get(ready) == 1
            && let Some(block) = blocks.back_mut()
        {
            block.entered += 1;
        }
        bench.simulator.cycle();
    }
    Ok(())
}

/// Triangles of a block are often at the same distance, or at the least.
fn random_block(bench: &mut Bench, inside: &VecDeque<Block>, contexts: u32, per_block: usize) -> Block {
    let free: Vec<u64> = (0..contexts.into()).filter(|&k| inside.iter().all(|block| block.context != k)).collect();
    let random = &mut bench.random;
    // The datapath returns no other NaN.
    let canonical = |number: f32| if number.is_nan() { f32::NAN } else { number };
    let mut triangles: Vec<Triangle> = Vec::new();
    for _ in 0..random.random_range(1..=per_block) {
        let (t_num, t_denom) = match triangles.last() {
            Some(last) if random.random_range(0..2) == 0 => {
                let factor = [1.0, -1.0, 2.0][random.random_range(0..3)];
                (last.t_num * factor, last.t_denom * factor)
            }
            _ => (number(random), number(random)),
        };
        let (is_hit, is_front) = (random.random_range(0..4) > 0, random.random());
        let [t_num, t_denom, u, v] = [t_num, t_denom, number(random), number(random)].map(canonical);
        triangles.push(Triangle { is_hit, is_front, t_num, t_denom, uv: [u, v] });
    }
    let Triangle { t_num, t_denom, .. } = triangles[random.random_range(0..triangles.len())];
    let least = [0.0, 0.0, t_num / t_denom, -t_num / t_denom, number(random)][random.random_range(0..5)];
    let mut culls = || u64::from(random.random_range(0..4) == 0);
    let limits = [u64::from(least.to_bits()), culls(), culls()];
    let first: u64 = random.random_range(0..1 << 32);
    let mut index = || (first ^ [0, 1 << random.random_range(0..32)][random.random_range(0..2)]) & 0xffff_ffff;
    let indices = [index(), index(), index()];
    Block { context: free[random.random_range(0..free.len())], limits, indices, triangles, entered: 0 }
}

impl Block {
    /// The words of its closest hit.
    fn closest(&self) -> Vec<u64> {
        let limits: HitLimits<Binary32> = from_words(Binary32, &self.limits);
        let mut closest: TriangleHit<Binary32> = from_words(Binary32, &[]);
        for (place, triangle) in self.triangles.iter().enumerate() {
            let found = TriangleHit {
                is_hit: triangle.is_hit.into(),
                t: Num::from(triangle.t_num / triangle.t_denom),
                t_num: triangle.t_num.into(),
                t_denom: triangle.t_denom.into(),
                u_num: triangle.uv[0].into(),
                v_num: triangle.uv[1].into(),
                back_face: (!triangle.is_front).into(),
                triangle: Word::truncate(self.indices[place] as u32),
            };
            closest = fold(closest, (place == 0).into(), found, limits);
        }
        let mut words = Vec::new();
        to_canonical_words(&closest, &mut words);
        words
    }
}
