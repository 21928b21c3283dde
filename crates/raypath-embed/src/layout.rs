//! Jobs and outcomes as other languages have them in memory. Each structure has the layout of the C structure
//! `raypath_…` of the same name.

use raypath_ops::{self as ops, Binary32, RayBoxOutput, RayError, RayTriangleOutput, Word};

/// A ray with the values that the hardware expects, 64 bytes. They are derived from origin, direction and extent by
/// `raypath_ray_init` (in Rust `Ray::new`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ray {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length except 0.
    pub direction: [f32; 3],
    /// 1 / direction, element by element; infinite where the direction is 0.
    pub inverse: [f32; 3],
    /// The length of the ray, in units of the direction's length. Boxes beyond it are missed.
    pub extent: f32,
    /// The direction along `kx` and along `ky`, and 1, each divided by the direction along `kz`.
    pub shear: [f32; 3],
    /// The axis that becomes x when the axes are permuted so that the ray runs along z: 0, 1 or 2.
    pub kx: u32,
    /// The axis that becomes y: 0, 1 or 2.
    pub ky: u32,
    /// The axis that becomes z: that of the direction's component of greatest magnitude.
    pub kz: u32,
}

/// An axis-aligned box, 24 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// The lesser bound along x, y and z.
    pub min: [f32; 3],
    /// The greater bound along x, y and z.
    pub max: [f32; 3],
}

/// The vertices of a triangle, counter-clockwise as seen from its front, 36 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vertices {
    /// The first vertex.
    pub a: [f32; 3],
    /// The second vertex.
    pub b: [f32; 3],
    /// The third vertex.
    pub c: [f32; 3],
}

/// The four boxes of a job sorted by distance: hits before misses, nearer before farther. 24 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct QuadboxResult {
    /// The distance at which the ray enters the box at each position of the order, in units of the direction's length;
    /// infinity for a miss.
    pub tmin: [f32; 4],
    /// Whether the box at each position is hit: 0 or 1.
    pub is_intersect: [u8; 4],
    /// The index of the box in the job: 0 to 3.
    pub box_index: [u8; 4],
}

/// The distance to a triangle as a fraction; the datapath does not divide. 12 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TriangleResult {
    /// Numerator of the distance, in units of the direction's length times `t_denom`.
    pub t_num: f32,
    /// Denominator of the distance.
    pub t_denom: f32,
    /// Whether the ray hits the triangle: 0 or 1.
    pub triangle_hit: u32,
}

/// The outcome of a beat of a Euclidean distance, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EuclideanResult {
    /// Sum of squared differences over all beats since the last reset, including this one.
    pub accumulator: f32,
    /// The beat's reset: 0 or 1.
    pub reset_accum: u32,
}

/// The outcome of a beat of an angular distance, 12 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AngularResult {
    /// Sum of a·b over all beats since the last reset, including this one.
    pub dot_product: f32,
    /// Sum of b·b over the same beats.
    pub norm: f32,
    /// The beat's reset: 0 or 1.
    pub reset_accum: u32,
}

impl Ray {
    /// The ray from `origin` along `direction` with the length `extent` times that of `direction`.
    ///
    /// # Errors
    /// Those of [`raypath_ops::Ray::new`]: a direction that is zero, not finite or too short; an origin that is not
    /// finite; an extent that is negative or NaN.
    pub fn new(origin: [f32; 3], direction: [f32; 3], extent: f32) -> Result<Self, RayError> {
        let ops::Ray { inv, shear, kx, ky, kz, .. } = ops::Ray::new(origin, direction, extent)?;
        let (inverse, shear) = (inv.into(), shear.into());
        Ok(Self { origin, direction, inverse, extent, shear, kx: kx.value, ky: ky.value, kz: kz.value })
    }
}

impl From<&Ray> for ops::Ray<Binary32> {
    #[inline]
    fn from(ray: &Ray) -> Self {
        let &Ray { origin, direction, inverse, extent, shear, kx, ky, kz } = ray;
        Self {
            origin: origin.into(),
            dir: direction.into(),
            inv: inverse.into(),
            extent: extent.into(),
            shear: shear.into(),
            kx: Word::truncate(kx),
            ky: Word::truncate(ky),
            kz: Word::truncate(kz),
        }
    }
}

impl From<&Bounds> for ops::Aabb<Binary32> {
    #[inline]
    fn from(bounds: &Bounds) -> Self {
        Self::new(bounds.min, bounds.max)
    }
}

impl From<&Vertices> for ops::Triangle<Binary32> {
    #[inline]
    fn from(&Vertices { a, b, c }: &Vertices) -> Self {
        Self::new(a, b, c)
    }
}

impl From<RayBoxOutput<Binary32>> for QuadboxResult {
    #[inline]
    fn from(output: RayBoxOutput<Binary32>) -> Self {
        Self {
            tmin: output.tmin.map(|t| canonical(t.into())),
            is_intersect: output.is_intersect.to_array().map(u8::from),
            box_index: output.box_index.map(|index| index.value as u8),
        }
    }
}

impl From<RayTriangleOutput<Binary32>> for TriangleResult {
    #[inline]
    fn from(output: RayTriangleOutput<Binary32>) -> Self {
        let RayTriangleOutput { t_num, t_denom, triangle_hit } = output;
        Self {
            t_num: canonical(t_num.into()),
            t_denom: canonical(t_denom.into()),
            triangle_hit: bool::from(triangle_hit).into(),
        }
    }
}

impl From<ops::EuclideanOutput<Binary32>> for EuclideanResult {
    #[inline]
    fn from(output: ops::EuclideanOutput<Binary32>) -> Self {
        let ops::EuclideanOutput { euclidean_accumulator, euclidean_reset_accum } = output;
        let reset_accum = bool::from(euclidean_reset_accum).into();
        Self { accumulator: canonical(euclidean_accumulator.into()), reset_accum }
    }
}

impl From<ops::AngularOutput<Binary32>> for AngularResult {
    #[inline]
    fn from(output: ops::AngularOutput<Binary32>) -> Self {
        let ops::AngularOutput { angular_dot_product, angular_norm, angular_reset_accum } = output;
        Self {
            dot_product: canonical(angular_dot_product.into()),
            norm: canonical(angular_norm.into()),
            reset_accum: bool::from(angular_reset_accum).into(),
        }
    }
}

/// The number, or the canonical NaN, which is the only NaN at the ports of the hardware.
#[inline]
pub(crate) fn canonical(number: f32) -> f32 {
    if number.is_nan() { f32::from_bits(0x7fc0_0000) } else { number }
}
