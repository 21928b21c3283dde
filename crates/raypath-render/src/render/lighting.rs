//! Lighting and shading: a sun, a sky, and a diffuse clay material.

use crate::{Camera, Hit, Scene};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Binary32, Ray};
use raypath_scene::vector::{Vector, add, cross, dot, scale, single, subtract, unit, vector};
use std::f64::consts::TAU;

pub(super) type Colour = [f64; 3];

const SUN: Colour = [2.7, 2.35, 1.85];
const ZENITH: Colour = [0.16, 0.34, 0.78];
const HORIZON: Colour = [0.70, 0.80, 0.95];
const GROUND: Colour = [0.36, 0.32, 0.29];
const CLAY: Colour = [0.68, 0.46, 0.34];

/// The light sources of a scene. The sun is above, to the left of and behind the camera.
pub(super) struct Lighting {
    sun: Vector,
    up: Vector,
    /// The extent of ambient-occlusion rays: half the longest side of the scene.
    reach: f32,
}

pub(super) struct SurfacePoint {
    /// The origin of secondary rays.
    origin: [f32; 3],
    /// The unit normal of the visible side.
    normal: Vector,
}

/// The random generator of a pixel, independent of other pixels.
pub(super) fn random(seed: u64, pixel: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(pixel);
    random
}

/// Converts linear light to sRGB, with tone mapping of high intensities.
pub(super) fn tone_map(light: Colour) -> [u8; 3] {
    light.map(|x| {
        let x = 0.72 * x;
        // Narkowicz's fit of the ACES filmic curve.
        let film = (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0);
        let encoded = if film <= 0.003_130_8 { 12.92 * film } else { 1.055 * film.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

impl SurfacePoint {
    /// The point at which a ray hits.
    ///
    /// Secondary rays start at a distance from the surface, so that they do not hit it. The distance must exceed the
    /// rounding errors of the triangle test: with u = 2⁻²⁴ and M the greatest coordinate or side of the scene, vertices
    /// are at most R = 2·M away along any axis and computed to within 8·u·R across the ray, in two directions, and
    /// 4·u·R along it (docs/reference/error-bounds.md), in total 12·u·R = 24·u·M; rounding the origin adds √3·u·M. The
    /// distance 32·u·M exceeds the sum. In an instance, the errors of its transform are added. The point is first
    /// projected onto the plane of the triangle, because the error of t is greater for faces seen edge-on.
    pub(super) fn new(scene: &Scene, ray: &Ray<Binary32>, hit: &Hit) -> Self {
        let (origin, direction) = (vector(ray.origin.into()), vector(ray.dir.into()));
        let corners = scene.mesh().corners(hit.triangle);
        let (a, front, error) = match hit.instance.and_then(|instance| scene.placed(instance)) {
            Some((placement, pad)) => (placement.moved(corners[0]), placement.normal(corners), *pad),
            None => {
                let [a, b, c] = corners.map(vector);
                (a, cross(subtract(b, a), subtract(c, a)), 0.0)
            }
        };
        let front = unit(front);
        let seen = if hit.from_behind { scale(-1.0, front) } else { front };
        // A triangle without area has no normal; it is shaded as if it faced the ray.
        let normal = if seen == [0.0; 3] { unit(scale(-1.0, direction)) } else { seen };
        let near = add(origin, scale(f64::from(hit.t), direction));
        let on_plane = subtract(near, scale(dot(subtract(near, a), normal), normal));
        let offset = 32.0 * f64::from(f32::EPSILON / 2.0) * f64::from(greatest(scene)) + error;
        Self { origin: single(add(on_plane, scale(offset, normal))), normal }
    }
}

/// The greatest coordinate magnitude or side length of a scene.
fn greatest(scene: &Scene) -> f32 {
    let bounds = scene.bounds();
    let coordinates = bounds.min.iter().chain(&bounds.max).map(|x| x.abs());
    coordinates.fold(bounds.longest_side(), f32::max)
}

impl Lighting {
    pub(super) fn new(scene: &Scene, camera: &Camera) -> Self {
        let frame = camera.frame();
        let across = add(scale(-0.75, frame.right), scale(-0.35, frame.forward));
        let sun = unit(add(across, frame.up));
        Self { sun, up: frame.up, reach: scene.bounds().longest_side() / 2.0 }
    }

    pub(super) fn sky(&self, direction: [f32; 3]) -> Colour {
        let height = dot(unit(vector(direction)), self.up);
        if height < 0.0 {
            mix(HORIZON, GROUND, (-height * 4.0).min(1.0))
        } else {
            mix(HORIZON, ZENITH, height.powf(0.45))
        }
    }

    /// The shadow ray towards the sun, or `None` if the surface faces away from it.
    pub(super) fn sun_ray(&self, point: &SurfacePoint) -> Option<Ray<Binary32>> {
        (dot(point.normal, self.sun) > 0.0).then(|| Ray::new(point.origin, single(self.sun), f32::INFINITY).ok())?
    }

    /// A random ambient-occlusion ray from a point, and the light that it adds if it hits nothing. Directions are
    /// distributed by the cosine of the angle with the normal, so all rays have equal weight.
    pub(super) fn sky_ray(&self, point: &SurfacePoint, random: &mut ChaCha8Rng) -> Option<(Ray<Binary32>, Colour)> {
        let (angle, square) = (TAU * random.random::<f64>(), random.random::<f64>());
        let (sine, cosine) = (square.sqrt(), (1.0 - square).sqrt());
        // Two tangents, from the axis with the least component along the normal.
        let n = point.normal;
        let least = (0..3).min_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs())).unwrap_or(0);
        let tangent = unit(cross(n, std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 })));
        let bitangent = cross(n, tangent);
        let across = add(scale(angle.cos(), tangent), scale(angle.sin(), bitangent));
        let direction = single(add(scale(sine, across), scale(cosine, n)));
        let ray = Ray::new(point.origin, direction, self.reach).ok()?;
        Some((ray, self.sky(direction)))
    }

    /// The light of the whole sky at a point, without occlusion.
    pub(super) fn open_sky(&self, point: &SurfacePoint) -> Colour {
        let part = 0.5 + 0.5 * dot(point.normal, self.up);
        mix(GROUND, mix(HORIZON, ZENITH, 0.5), part)
    }

    pub(super) fn reflected(&self, point: &SurfacePoint, in_sun: bool, sky: Colour) -> Colour {
        let cosine = if in_sun { dot(point.normal, self.sun).max(0.0) } else { 0.0 };
        // The constant approximates light between surfaces.
        std::array::from_fn(|k| CLAY[k] * (cosine * SUN[k] + 0.85 * sky[k] + 0.05))
    }
}

fn mix(a: Colour, b: Colour, part: f64) -> Colour {
    add(scale(1.0 - part, a), scale(part, b))
}
