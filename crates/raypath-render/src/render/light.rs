//! A sun, a sky, and matt clay between them.

use crate::camera::Camera;
use crate::scene::Scene;
use crate::trace::Hit;
use crate::vector::{Vector, add, cross, dot, scale, single, subtract, unit, vector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};
use std::f64::consts::TAU;

pub(super) type Colour = [f64; 3];

const SUN: Colour = [2.7, 2.35, 1.85];
const ZENITH: Colour = [0.16, 0.34, 0.78];
const HORIZON: Colour = [0.70, 0.80, 0.95];
const GROUND: Colour = [0.36, 0.32, 0.29];
const CLAY: Colour = [0.68, 0.46, 0.34];

/// The light of a scene, as seen by a camera: the sun stands above, to the left and behind it.
pub(super) struct Light {
    sun: Vector,
    up: Vector,
    /// How far rays of ambient occlusion reach: half the longest side of the scene.
    reach: f32,
}

/// A point of a surface that is to be lit.
pub(super) struct Point {
    /// Where secondary rays begin.
    origin: [f32; 3],
    /// Towards the side that is seen.
    normal: Vector,
}

/// The random numbers of a pixel, whatever its neighbours take.
pub(super) fn random(seed: u64, pixel: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(pixel);
    random
}

pub(super) fn plus(a: Colour, b: Colour) -> Colour {
    add(a, b)
}

/// Light as bytes of sRGB; what is too bright fades to white.
pub(super) fn developed(light: Colour) -> [u8; 3] {
    light.map(|x| {
        let x = 0.72 * x;
        // Narkowicz's fit of the film curve ACES.
        let film = (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0);
        let encoded = if film <= 0.003_130_8 { 12.92 * film } else { 1.055 * film.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

impl Point {
    /// Where a ray hits.
    ///
    /// Secondary rays begin beside the surface, so that they do not hit it. As far as that triangle's computed vertices are
    /// concerned they must be farther from its plane than rounding moves things: with u = 2⁻²⁴ and M the greatest
    /// coordinate or side of the scene, vertices are at most R = 2·M away along any axis and computed to within 8·u·R
    /// across the ray, in two directions, and 4·u·R along it (docs/reference/error-bounds.md), in all 12·u·R = 24·u·M;
    /// rounding the
    /// origin adds √3·u·M. 32·u·M is more. The point is first put exactly into the triangle's plane, for t may be off by
    /// more where a face is seen edge-on.
    pub(super) fn new(scene: &Scene, ray: &Ray<Binary32>, hit: &Hit) -> Self {
        let (origin, direction) = (vector(ray.origin.into()), vector(ray.dir.into()));
        let [a, b, c] = scene.mesh().corners(hit.triangle).map(vector);
        let front = unit(cross(subtract(b, a), subtract(c, a)));
        let seen = if hit.from_behind { scale(-1.0, front) } else { front };
        // A triangle without area has no normal, and is lit as if it looked at the ray.
        let normal = if seen == [0.0; 3] { unit(scale(-1.0, direction)) } else { seen };
        let near = add(origin, scale(f64::from(hit.t), direction));
        let on_plane = subtract(near, scale(dot(subtract(near, a), normal), normal));
        let beside = 32.0 * f64::from(f32::EPSILON / 2.0) * f64::from(greatest(scene));
        Self { origin: single(add(on_plane, scale(beside, normal))), normal }
    }
}

/// The greatest coordinate or side.
fn greatest(scene: &Scene) -> f32 {
    let bounds = scene.bounds();
    let coordinates = bounds.min.iter().chain(&bounds.max).map(|x| x.abs());
    coordinates.fold(bounds.longest_side(), f32::max)
}

impl Light {
    pub(super) fn new(scene: &Scene, camera: &Camera) -> Self {
        let frame = camera.frame();
        let across = add(scale(-0.75, frame.right), scale(-0.35, frame.forward));
        let sun = unit(add(across, frame.up));
        // Above also where the camera looks up or down.
        Self { sun, up: frame.up, reach: scene.bounds().longest_side() / 2.0 }
    }

    /// The sky in a direction.
    pub(super) fn sky(&self, direction: [f32; 3]) -> Colour {
        let height = dot(unit(vector(direction)), self.up);
        if height < 0.0 {
            mixed(HORIZON, GROUND, (-height * 4.0).min(1.0))
        } else {
            mixed(HORIZON, ZENITH, height.powf(0.45))
        }
    }

    /// A ray towards the sun, if the point looks there.
    pub(super) fn sun_ray(&self, point: &Point) -> Option<Ray<Binary32>> {
        (dot(point.normal, self.sun) > 0.0).then(|| Ray::new(point.origin, single(self.sun), f32::INFINITY).ok())?
    }

    /// A ray into the half space before a point, and what light it brings if nothing is in the way. Directions are
    /// distributed by the cosine of their angle with the normal, so all count alike.
    pub(super) fn sky_ray(&self, point: &Point, random: &mut ChaCha8Rng) -> Option<(Ray<Binary32>, Colour)> {
        let (angle, square) = (TAU * random.random::<f64>(), random.random::<f64>());
        let (across, out) = (square.sqrt(), (1.0 - square).sqrt());
        // Two directions across the normal, from the axis that is least along it.
        let n = point.normal;
        let least = (0..3).min_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs())).unwrap_or(0);
        let one = unit(cross(n, std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 })));
        let other = cross(n, one);
        let aside = add(scale(angle.cos(), one), scale(angle.sin(), other));
        let direction = single(add(scale(across, aside), scale(out, n)));
        let ray = Ray::new(point.origin, direction, self.reach).ok()?;
        Some((ray, self.sky(direction)))
    }

    /// The sky that lights a point with nothing in the way.
    pub(super) fn open_sky(&self, point: &Point) -> Colour {
        let part = 0.5 + 0.5 * dot(point.normal, self.up);
        mixed(GROUND, mixed(HORIZON, ZENITH, 0.5), part)
    }

    /// What a point sends back.
    pub(super) fn reflected(&self, point: &Point, in_sun: bool, sky: Colour) -> Colour {
        let slant = if in_sun { dot(point.normal, self.sun).max(0.0) } else { 0.0 };
        // A little comes from everywhere, in place of what surfaces send each other.
        std::array::from_fn(|k| CLAY[k] * (slant * SUN[k] + 0.85 * sky[k] + 0.05))
    }
}

fn mixed(a: Colour, b: Colour, part: f64) -> Colour {
    add(scale(1.0 - part, a), scale(part, b))
}
