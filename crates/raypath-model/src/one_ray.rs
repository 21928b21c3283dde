//! One ray against four boxes or four triangles, a lane each.

use crate::kernels::{Baseline, FourLanes, HAS_SIMD, baseline, sort_keys};
use crate::lanes::{Lanes, Register};
use crate::{SimdKernels, transposed};
use fearless_simd::prelude::*;
use fearless_simd::{f32x4, u8x16};
use raypath_ops::{
    Aabb, Binary32, Bit, Circuit, LaneMap, Num, Operation, Ray, RayTriangle, RayTriangleExtended,
    RayTriangleExtendedInput, RayTriangleInput, Rules, Slab, Slabs, Triangle, Vec3, Word, array_of,
};

/// A ray in four lanes, in the SIMD instructions that every machine of the architecture has. Its results are those of
/// the operations over [`Binary32`], bit for bit except for the signs and payloads of NaNs.
#[derive(Debug, Clone, Copy)]
pub struct OneRay {
    lanes: FourLanes,
    origin: Vec3<FourLanes>,
    inv: Vec3<FourLanes>,
    extent: Num<FourLanes>,
    shear: Vec3<FourLanes>,
    /// The axes that become x, y and z for triangles, whose vertices are turned as they are read.
    axes: [usize; 3],
    turned_origin: Vec3<FourLanes>,
    kz: Word<FourLanes, 2>,
}

/// The outcomes of four boxes, in their order.
#[derive(Debug, Clone, Copy)]
pub struct FourBoxes {
    /// Bit i: the ray hits box i.
    pub hits: u32,
    /// The distances at which the ray enters; +∞ for a miss.
    pub tmin: [f32; 4],
}

/// The boxes that are hit, the nearest first, of equal ones that of the lowest index.
#[derive(Debug, Clone, Copy)]
pub struct NearestFirst {
    /// Their number; entries from there on are arbitrary.
    pub count: u32,
    /// The index of the box.
    pub index: [u32; 4],
    /// The distance at which the ray enters.
    pub tmin: [f32; 4],
}

impl FourBoxes {
    /// The boxes in the order of their distance.
    #[inline(always)]
    pub fn nearest_first(&self) -> NearestFirst {
        let count = self.hits.count_ones();
        if count <= 1 {
            let index = self.hits.trailing_zeros() & 3;
            return NearestFirst { count, index: [index; 4], tmin: [self.tmin[index as usize]; 4] };
        }
        // Numbers that are not negative have the order of their bits.
        let mut keys: [u64; 4] = array_of!(i => {
            let key = u64::from(self.tmin[i].to_bits()) << 2 | i as u64;
            if self.hits >> i & 1 == 1 { key } else { u64::MAX }
        });
        sort_keys(&mut keys);
        NearestFirst {
            count,
            index: array_of!(i => (keys[i] & 3) as u32),
            tmin: array_of!(i => f32::from_bits((keys[i] >> 2) as u32)),
        }
    }
}

/// The outcomes of four triangles, in their order. The numbers of misses are arbitrary but for the denominators, which
/// are negative for back faces.
#[derive(Debug, Clone, Copy)]
pub struct FourTriangles {
    /// Bit i: the ray hits triangle i.
    pub hits: u32,
    /// The distances: `t_num` / `t_denom`.
    pub t: [f32; 4],
    /// The numerators.
    pub t_num: [f32; 4],
    /// The denominators.
    pub t_denom: [f32; 4],
    /// V and W; 0 without barycentrics.
    pub edges: [[f32; 4]; 2],
}

type Number = f32x4<Baseline>;

impl OneRay {
    /// The ray, if the architecture is little-endian and has SIMD instructions.
    #[inline(always)]
    pub fn new(ray: &Ray<Binary32>) -> Option<Self> {
        if !HAS_SIMD || cfg!(target_endian = "big") {
            return None;
        }
        let lanes = Lanes::new(baseline());
        let num = |x: Num<Binary32>| in_lanes(lanes, x.into());
        let vector = |v: Vec3<Binary32>| Vec3 { x: num(v.x), y: num(v.y), z: num(v.z) };
        let along = |k: Word<Binary32, 2>| num(ray.origin.along(k));
        let axis = |k: Word<Binary32, 2>| k.value.min(2) as usize;
        Some(Self {
            lanes,
            origin: vector(ray.origin),
            inv: vector(ray.inv),
            extent: num(ray.extent),
            shear: vector(ray.shear),
            axes: [axis(ray.kx), axis(ray.ky), axis(ray.kz)],
            kz: lanes.word(ray.kz.value),
            turned_origin: Vec3 { x: along(ray.kx), y: along(ray.ky), z: along(ray.kz) },
        })
    }

    /// Changes the length of the ray.
    #[inline(always)]
    pub fn set_extent(&mut self, extent: f32) {
        self.extent = in_lanes(self.lanes, extent);
    }

    /// Tests four boxes: for each min x, min y, min z, max x, max y, max z, little-endian.
    #[inline(always)]
    pub fn boxes_of_bytes(&self, rules: Rules, boxes: [&[u8; 24]; 4]) -> FourBoxes {
        let simd = self.lanes.simd();
        let row = |i: usize, from: usize| u8x16::from_slice(simd, &boxes[i][4 * from..4 * from + 16]).bitcast();
        let [x0, y0, z0, x1, y1, z1] = columns(row);
        self.test(rules, [[x0, x1], [y0, y1], [z0, z1]])
    }

    /// Tests four boxes.
    #[inline(always)]
    pub fn boxes(&self, rules: Rules, boxes: [&Aabb<Binary32>; 4]) -> FourBoxes {
        let simd = self.lanes.simd();
        let rows: [[f32; 6]; 4] = array_of!(i => {
            let Aabb { x, y, z } = *boxes[i];
            [x.min.into(), x.max.into(), y.min.into(), y.max.into(), z.min.into(), z.max.into()]
        });
        let [x0, x1, y0, y1, z0, z1] = columns(|i, from| f32x4::from_slice(simd, &rows[i][from..from + 4]));
        self.test(rules, [[x0, x1], [y0, y1], [z0, z1]])
    }

    /// Tests four boxes: along each axis their minima, then their maxima.
    #[inline(always)]
    pub fn slabs(&self, rules: Rules, slabs: [[[f32; 4]; 2]; 3]) -> FourBoxes {
        let simd = self.lanes.simd();
        self.test(rules, array_of!(axis => array_of!(side => f32x4::from_slice(simd, &slabs[axis][side]))))
    }

    #[inline(always)]
    fn test(&self, rules: Rules, slabs: [[Number; 2]; 3]) -> FourBoxes {
        let slab = |axis: usize| Slab { min: self.num(slabs[axis][0]), max: self.num(slabs[axis][1]) };
        let aabb = Aabb { x: slab(0), y: slab(1), z: slab(2) };
        let slabs = Slabs { rules, is_conservative: true };
        let [entry] = slabs.run(self.lanes, SimdKernels, &self.ray(self.origin, self.kz), &[aabb]);
        FourBoxes { hits: bits(entry.hit), tmin: entry.tmin.value.0.to_array() }
    }

    /// Tests both faces of four triangles. `number` returns, of a triangle, one of the numbers 0 to 8: x, y, z of the
    /// vertices a, b, c.
    #[inline(always)]
    pub fn triangles(&self, op: RayTriangleExtended, number: impl Fn(usize, usize) -> f32) -> FourTriangles {
        let zero = in_lanes(self.lanes, 0.0);
        let (ray, triangle) = (self.turned_ray(), self.turn(number));
        let input = RayTriangleExtendedInput { ray, triangle, t_min: zero };
        let (outcome, ()) = op.run_with(self.lanes, SimdKernels, input, ());
        let edges = if op.barycentrics { [outcome.barycentric.v, outcome.barycentric.w] } else { [zero; 2] };
        outcomes(outcome.triangle_hit, outcome.t_num, outcome.t_denom, edges)
    }

    /// Tests the fronts of four triangles, with numbers as those of [`triangles`](Self::triangles).
    #[inline(always)]
    pub fn fronts(&self, op: RayTriangle, number: impl Fn(usize, usize) -> f32) -> FourTriangles {
        let input = RayTriangleInput { ray: self.turned_ray(), triangle: self.turn(number) };
        let (outcome, ()) = op.run_with(self.lanes, SimdKernels, input, ());
        outcomes(outcome.triangle_hit, outcome.t_num, outcome.t_denom, [in_lanes(self.lanes, 0.0); 2])
    }

    /// The ray for boxes, which read kz alone of its axes, or for vertices that are turned already. No operation here
    /// reads its direction.
    #[inline(always)]
    fn ray(&self, origin: Vec3<FourLanes>, kz: Word<FourLanes, 2>) -> Ray<FourLanes> {
        let Self { lanes, inv, extent, shear, .. } = *self;
        Ray { origin, dir: inv, inv, extent, shear, kx: lanes.word(0), ky: lanes.word(1), kz }
    }

    #[inline(always)]
    fn turned_ray(&self) -> Ray<FourLanes> {
        self.ray(self.turned_origin, self.lanes.word(2))
    }

    #[inline(always)]
    fn turn(&self, number: impl Fn(usize, usize) -> f32) -> Triangle<FourLanes> {
        let simd = self.lanes.simd();
        let coordinate = |at: usize| self.num(f32x4::simd_from(simd, array_of!(i => number(i, at))));
        let [kx, ky, kz] = self.axes;
        let vertex =
            |first: usize| Vec3 { x: coordinate(first + kx), y: coordinate(first + ky), z: coordinate(first + kz) };
        Triangle { a: vertex(0), b: vertex(3), c: vertex(6) }
    }

    #[inline(always)]
    fn num(&self, value: Number) -> Num<FourLanes> {
        Num::new(self.lanes, Register(value))
    }
}

/// The six columns of four rows, of which `row` returns four numbers from a column on.
#[inline(always)]
fn columns(row: impl Fn(usize, usize) -> Number) -> [Number; 6] {
    let four = |from: usize| transposed(array_of!(i => row(i, from)));
    let ([a, b, c, d], [_, _, e, f]) = (four(0), four(2));
    [a, b, c, d, e, f]
}

#[inline(always)]
fn outcomes(
    hit: Bit<FourLanes>,
    t_num: Num<FourLanes>,
    t_denom: Num<FourLanes>,
    edges: [Num<FourLanes>; 2],
) -> FourTriangles {
    let array = |x: Num<FourLanes>| x.value.0.to_array();
    FourTriangles {
        hits: bits(hit),
        t: (t_num.value.0 / t_denom.value.0).to_array(),
        t_num: array(t_num),
        t_denom: array(t_denom),
        edges: [array(edges[0]), array(edges[1])],
    }
}

#[inline(always)]
fn bits(bit: Bit<FourLanes>) -> u32 {
    bit.value.0.to_bitmask() as u32
}

#[inline(always)]
fn in_lanes(lanes: FourLanes, x: f32) -> Num<FourLanes> {
    Num::new(lanes, Register(f32x4::splat(lanes.simd(), x)))
}
