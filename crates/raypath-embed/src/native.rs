//! Arrays of jobs in native binary32 and short formats, computed in SIMD lanes.

use crate::layout::{Bounds, QuadboxResult, Ray, TriangleResult, Vertices, canonical};
use crate::transpose;
use raypath_model::{
    BLOCK, Batch, BlockValue, Level, Packed, ShortFormat, baseline, blank, dispatch, run_blocks, run_blocks_in,
};
use raypath_ops::{
    self as ops, Aabb, AngularOutput, Beat, BeatInput, Binary32, Bit, EuclideanOutput, Flags, Num, RayBoxInput,
    RayBoxOutput, RayTriangleExtended, RayTriangleExtendedInput, RayTriangleExtendedOutput, RayTriangleInput,
    RayTriangleOutput, Rounding, Rules, Slab, Vec3, Word, array_of,
};
use raypath_rtl::Semantics;

/// The blocks that are packed before they are computed: their jobs and outcomes fit into a first-level cache.
const BLOCKS: usize = 4;

/// Computes a job for each ray. All slices have as many jobs.
pub fn quadbox(semantics: Semantics, rays: &[Ray], boxes: &[[Bounds; 4]], results: &mut [QuadboxResult]) {
    let short = ShortFormat::lanes(semantics.format);
    let batch =
        Batch::<2, 1>::new(semantics.rules_in_full()).conservative(semantics.features.conservative).short(short);
    let mut jobs = [blank::<RayBoxInput<Binary32>>(); BLOCKS];
    let mut answers = [blank::<RayBoxOutput<Binary32>>(); BLOCKS];
    for first in (0..results.len()).step_by(BLOCKS * BLOCK) {
        let results = &mut results[first..];
        let used = results.len().div_ceil(BLOCK).min(BLOCKS);
        let last = first + results.len() - 1;
        for (block, job) in jobs[..used].iter_mut().enumerate() {
            let at = |i: usize| (first + block * BLOCK + i).min(last);
            let ray = packed_ray(|i| &rays[at(i)]);
            let bounds = transpose::fields(|i| numbers_of_boxes(&boxes[at(i)]));
            *job = RayBoxInput { ray, aabb: array_of!(k => packed_box(&bounds, 6 * k)) };
        }
        batch.quadbox(&jobs[..used], &mut answers[..used]);
        for (results, answer) in results.chunks_mut(BLOCK).zip(&answers[..used]) {
            unpack_boxes(answer, results);
        }
    }
}

/// Computes a job for each ray. All slices have as many jobs. With the feature `range`, rays begin at a distance of 0.
pub fn triangle(semantics: Semantics, rays: &[Ray], triangles: &[Vertices], results: &mut [TriangleResult]) {
    let short = ShortFormat::lanes(semantics.format);
    let Some(op) = semantics.extended_triangle() else {
        let batch = Batch::<2, 1>::new(semantics.rules_in_full()).rounding(semantics.rounding).short(short);
        return triangles_of(
            (rays, triangles, results),
            [blank::<RayTriangleInput<Binary32>>(); BLOCKS],
            [blank::<RayTriangleOutput<Binary32>>(); BLOCKS],
            |ray, triangle| RayTriangleInput { ray, triangle },
            |jobs, answers| batch.triangle(jobs, answers),
            |answer| (answer.t_num, answer.t_denom, answer.triangle_hit),
        );
    };
    let level = Level::new();
    triangles_of(
        (rays, triangles, results),
        [blank::<RayTriangleExtendedInput<Binary32>>(); BLOCKS],
        [blank::<RayTriangleExtendedOutput<Binary32>>(); BLOCKS],
        |ray, triangle| RayTriangleExtendedInput { ray, triangle, t_min: num(BlockValue([0.0; BLOCK])) },
        |jobs, answers| match (short, op.rounding) {
            (Some(lanes), _) => run_blocks_in(lanes, &op, jobs, answers, &mut ()),
            // A call for each, so that the rounding is a constant in each.
            (None, Rounding::Unit) => {
                let op = RayTriangleExtended { rounding: Rounding::Unit, ..op };
                dispatch!(level, simd => run_blocks(simd, &op, jobs, answers, &mut ()));
            }
            (None, Rounding::Sum) => run_blocks(baseline(), &op, jobs, answers, &mut ()),
        },
        |answer| (answer.t_num, answer.t_denom, answer.triangle_hit),
    );
}

/// Computes jobs that `job` makes of a ray and a triangle.
fn triangles_of<I, O>(
    (rays, triangles, results): (&[Ray], &[Vertices], &mut [TriangleResult]),
    mut jobs: [I; BLOCKS],
    mut answers: [O; BLOCKS],
    job: impl Fn(ops::Ray<Packed>, ops::Triangle<Packed>) -> I,
    run: impl Fn(&[I], &mut [O]),
    parts: impl Fn(&O) -> (Num<Packed>, Num<Packed>, Bit<Packed>),
) {
    for first in (0..results.len()).step_by(BLOCKS * BLOCK) {
        let results = &mut results[first..];
        let used = results.len().div_ceil(BLOCK).min(BLOCKS);
        let last = first + results.len() - 1;
        for (block, packed) in jobs[..used].iter_mut().enumerate() {
            let at = |i: usize| (first + block * BLOCK + i).min(last);
            let ray = packed_ray(|i| &rays[at(i)]);
            let fields = transpose::fields(|i| numbers_of_vertices(&triangles[at(i)]));
            let vertex = |k: usize| packed_vector(&fields, 3 * k);
            *packed = job(ray, ops::Triangle { a: vertex(0), b: vertex(1), c: vertex(2) });
        }
        run(&jobs[..used], &mut answers[..used]);
        for (results, answer) in results.chunks_mut(BLOCK).zip(&answers[..used]) {
            let (t_num, t_denom, hit) = parts(answer);
            for (i, result) in results.iter_mut().enumerate() {
                *result = TriangleResult {
                    t_num: canonical(t_num.value.0[i]),
                    t_denom: canonical(t_denom.value.0[i]),
                    triangle_hit: u32::from(hit.value.0[i] != 0),
                };
            }
        }
    }
}

/// Computes the distance of each pair of vectors, with `N` dimensions per beat. `a` and `b` have `dimensions` numbers
/// for each distance, and `dimensions` is at least 1.
pub fn euclidean<const N: usize>(semantics: Semantics, a: &[f32], b: &[f32], dimensions: usize, distances: &mut [f32]) {
    let short = ShortFormat::lanes(semantics.format);
    let mut batch = Batch::<N, 1>::new(Rules::Paper).rounding(semantics.rounding).short(short);
    let mut answers = [blank::<EuclideanOutput<Binary32>>(); BLOCKS];
    for (pairs, distances) in pairs(a, b, dimensions).zip(distances.chunks_mut(BLOCK)) {
        let mut last = answers[0];
        beats::<N>(pairs, dimensions, |beats| {
            batch.euclidean(beats, &mut answers[..beats.len()]);
            last = answers[beats.len() - 1];
        });
        distances.iter_mut().zip(last.euclidean_accumulator.value.0).for_each(|(to, sum)| *to = canonical(sum));
    }
}

/// Computes the dot product of each pair of vectors and the squared norm of the second, with `N` dimensions per beat.
/// `a` and `b` have `dimensions` numbers for each pair, and `dimensions` is at least 1.
pub fn angular<const N: usize>(
    semantics: Semantics,
    a: &[f32],
    b: &[f32],
    dimensions: usize,
    dots: &mut [f32],
    norms: &mut [f32],
) {
    let short = ShortFormat::lanes(semantics.format);
    let mut batch = Batch::<2, N>::new(Rules::Paper).rounding(semantics.rounding).short(short);
    let mut answers = [blank::<AngularOutput<Binary32>>(); BLOCKS];
    for ((pairs, dots), norms) in pairs(a, b, dimensions).zip(dots.chunks_mut(BLOCK)).zip(norms.chunks_mut(BLOCK)) {
        let mut last = answers[0];
        beats::<N>(pairs, dimensions, |beats| {
            batch.angular(beats, &mut answers[..beats.len()]);
            last = answers[beats.len() - 1];
        });
        dots.iter_mut().zip(last.angular_dot_product.value.0).for_each(|(to, sum)| *to = canonical(sum));
        norms.iter_mut().zip(last.angular_norm.value.0).for_each(|(to, sum)| *to = canonical(sum));
    }
}

/// The coordinates of up to sixteen pairs of vectors.
type Pairs<'v> = (&'v [f32], &'v [f32]);

fn pairs<'v>(a: &'v [f32], b: &'v [f32], dimensions: usize) -> impl Iterator<Item = Pairs<'v>> {
    a.chunks(BLOCK * dimensions).zip(b.chunks(BLOCK * dimensions))
}

/// Passes the beats of the pairs to `run`, in order, at most [`BLOCKS`] at once. The last has `reset_accum` set. A
/// block with fewer pairs repeats the last.
fn beats<const N: usize>((a, b): Pairs<'_>, dimensions: usize, mut run: impl FnMut(&[BeatInput<Packed, N>])) {
    let last = a.len() / dimensions - 1;
    let count = dimensions.div_ceil(N);
    let mut block = [blank::<BeatInput<Binary32, N>>(); BLOCKS];
    for first in (0..count).step_by(BLOCKS) {
        let used = (count - first).min(BLOCKS);
        for (i, beat) in block[..used].iter_mut().enumerate() {
            let begin = (first + i) * N;
            let lanes = (dimensions - begin).min(N);
            beat.euclidean = Beat {
                a: packed_rows(|row| &a[row.min(last) * dimensions + begin..][..lanes]),
                b: packed_rows(|row| &b[row.min(last) * dimensions + begin..][..lanes]),
                mask: Flags(array_of!(lane => bit(lane < lanes))),
                reset_accum: bit(first + i == count - 1),
            };
        }
        run(&block[..used]);
    }
}

#[inline(always)]
fn packed_rows<'v, const N: usize>(row: impl Fn(usize) -> &'v [f32]) -> [Num<Packed>; N] {
    let numbers = |i: usize| {
        let row = row(i);
        row.try_into().unwrap_or_else(|_| {
            let mut padded = [0.0; N];
            padded[..row.len()].copy_from_slice(row);
            padded
        })
    };
    let fields: [BlockValue<f32>; N] = transpose::fields(numbers);
    array_of!(lane => num(fields[lane]))
}

#[inline(always)]
fn packed_ray<'r>(ray: impl Fn(usize) -> &'r Ray) -> ops::Ray<Packed> {
    let fields = transpose::fields(|i| numbers_of_ray(ray(i)));
    let word = |k: usize| Word::new(Packed, BlockValue(fields[k].0.map(|bits| bits.to_bits() & 3)));
    ops::Ray {
        origin: packed_vector(&fields, 0),
        dir: packed_vector(&fields, 3),
        inv: packed_vector(&fields, 6),
        extent: num(fields[9]),
        shear: packed_vector(&fields, 10),
        kx: word(13),
        ky: word(14),
        kz: word(15),
    }
}

#[inline(always)]
fn packed_box(fields: &[BlockValue<f32>], first: usize) -> Aabb<Packed> {
    let slab = |axis: usize| Slab { min: num(fields[first + axis]), max: num(fields[first + 3 + axis]) };
    Aabb { x: slab(0), y: slab(1), z: slab(2) }
}

#[inline(always)]
fn packed_vector(fields: &[BlockValue<f32>], first: usize) -> Vec3<Packed> {
    Vec3 { x: num(fields[first]), y: num(fields[first + 1]), z: num(fields[first + 2]) }
}

#[inline(always)]
fn num(block: BlockValue<f32>) -> Num<Packed> {
    Num::new(Packed, block)
}

#[inline(always)]
fn bit(is_set: bool) -> Bit<Packed> {
    Bit::new(Packed, BlockValue([-i32::from(is_set); BLOCK]))
}

/// The fields of a ray in the order of the structure; the axes as bit patterns.
#[inline(always)]
fn numbers_of_ray(ray: &Ray) -> [f32; 16] {
    let Ray { origin: o, direction: d, inverse: i, extent, shear: s, kx, ky, kz } = *ray;
    let [kx, ky, kz] = [kx, ky, kz].map(f32::from_bits);
    [o[0], o[1], o[2], d[0], d[1], d[2], i[0], i[1], i[2], extent, s[0], s[1], s[2], kx, ky, kz]
}

#[inline(always)]
fn numbers_of_boxes(boxes: &[Bounds; 4]) -> [f32; 24] {
    let [a, b, c, d] = boxes.map(|Bounds { min: [x, y, z], max: [to_x, to_y, to_z] }| [x, y, z, to_x, to_y, to_z]);
    let mut numbers = [0.0; 24];
    for (to, from) in numbers.chunks_exact_mut(6).zip([a, b, c, d]) {
        to.copy_from_slice(&from);
    }
    numbers
}

#[inline(always)]
fn numbers_of_vertices(&Vertices { a, b, c }: &Vertices) -> [f32; 9] {
    [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
}

fn unpack_boxes(answer: &RayBoxOutput<Packed>, results: &mut [QuadboxResult]) {
    for (i, result) in results.iter_mut().enumerate() {
        *result = QuadboxResult {
            tmin: [0, 1, 2, 3].map(|k: usize| canonical(answer.tmin[k].value.0[i])),
            is_intersect: [0, 1, 2, 3].map(|k: usize| u8::from(answer.is_intersect.0[k].value.0[i] != 0)),
            box_index: [0, 1, 2, 3].map(|k: usize| answer.box_index[k].value.0[i] as u8),
        };
    }
}
