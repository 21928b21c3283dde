//! A pixel, ray by ray.

use super::light::{self, Colour, Light, Point};
use super::{MOST_PIXELS, MOST_SIDE, RenderError, Shading};
use crate::camera::{Camera, View};
use crate::scene::Scene;
use crate::trace::{Goal, Hit};
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Binary32, Ray, RayError};

/// All that pixels have in common.
pub(crate) struct Painter<'s> {
    scene: &'s Scene,
    view: View,
    light: Light,
    shading: Shading,
    width: u32,
    pixels: u64,
}

/// A pixel on its way to a colour: it says which ray it needs next, and takes what that has hit.
pub(crate) struct Brush<'p> {
    painter: &'p Painter<'p>,
    /// The pixel's upper left corner.
    corner: [f64; 2],
    random: ChaCha8Rng,
    /// Samples that have begun.
    begun: u32,
    sum: Colour,
    awaited: Awaited,
}

/// A ray to be traced.
pub(crate) struct Aim {
    pub(crate) ray: Ray<Binary32>,
    pub(crate) kind: Kind,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// From the eye.
    Primary,
    /// Towards the sun.
    Shadow,
    /// Into the sky.
    Occlusion,
}

/// The ray on its way.
enum Awaited {
    None,
    Primary(Ray<Binary32>),
    Shadow(Surface),
    /// And the light it brings if it hits nothing.
    Occlusion(Surface, Colour),
}

/// What a ray from the eye has hit, and what is known of its light.
struct Surface {
    point: Point,
    in_sun: bool,
    sky: Colour,
    /// Rays into the sky that are still to be traced.
    left: u32,
}

impl<'s> Painter<'s> {
    pub(crate) fn new(
        scene: &'s Scene,
        camera: &Camera,
        (width, height): (u32, u32),
        shading: &Shading,
    ) -> Result<Self, RenderError> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MOST_PIXELS || width.max(height) > MOST_SIDE {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=64).contains(&shading.samples) {
            return Err(RenderError::Samples(shading.samples));
        }
        let (view, light) = (camera.view(width, height), Light::new(scene, camera));
        Ok(Self { scene, view, light, shading: *shading, width, pixels })
    }

    pub(crate) fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// How many pixels there are.
    pub(crate) fn pixels(&self) -> usize {
        self.pixels as usize
    }

    /// The brush for a pixel; they are numbered row by row.
    pub(crate) fn brush(&self, pixel: usize) -> Brush<'_> {
        let (pixel, width) = (pixel as u64, u64::from(self.width));
        let corner = [(pixel % width) as f64, (pixel / width) as f64];
        let random = light::random(self.shading.seed, pixel);
        Brush { painter: self, corner, random, begun: 0, sum: [0.0; 3], awaited: Awaited::None }
    }
}

impl Brush<'_> {
    /// The next ray; none if the colour is known. `hit` is what the ray before has hit; before the first it means nothing.
    pub(crate) fn next(&mut self, hit: Option<Hit>) -> Result<Option<Aim>, RayError> {
        match std::mem::replace(&mut self.awaited, Awaited::None) {
            Awaited::None => self.sample(),
            Awaited::Primary(ray) => match hit {
                Some(hit) => self.shade(&ray, &hit),
                None => self.finish_sample(self.painter.light.sky(ray.dir.into())),
            },
            Awaited::Shadow(surface) => self.look_up(Surface { in_sun: hit.is_none(), ..surface }),
            Awaited::Occlusion(mut surface, light) => {
                if hit.is_none() {
                    surface.sky = light::plus(surface.sky, light);
                }
                self.look_up(surface)
            }
        }
    }

    /// The colour, after the last ray.
    pub(crate) fn colour(&self) -> [u8; 3] {
        let samples = self.painter.shading.samples;
        light::developed(self.sum.map(|light| light / f64::from(samples * samples)))
    }

    /// Begins the next sample with its ray from the eye.
    fn sample(&mut self) -> Result<Option<Aim>, RayError> {
        let samples = self.painter.shading.samples;
        if self.begun == samples * samples {
            return Ok(None);
        }
        let within = |step: u32| (f64::from(step) + 0.5) / f64::from(samples);
        let (dx, dy) = (within(self.begun % samples), within(self.begun / samples));
        let ray = self.painter.view.ray(self.corner[0] + dx, self.corner[1] + dy)?;
        self.begun += 1;
        self.awaited = Awaited::Primary(ray);
        Ok(Some(Aim { ray, kind: Kind::Primary }))
    }

    fn finish_sample(&mut self, colour: Colour) -> Result<Option<Aim>, RayError> {
        self.sum = light::plus(self.sum, colour);
        self.sample()
    }

    /// Looks from what was hit towards the sun.
    fn shade(&mut self, ray: &Ray<Binary32>, hit: &Hit) -> Result<Option<Aim>, RayError> {
        let Painter { scene, light, shading, .. } = self.painter;
        let point = Point::new(scene, ray, hit);
        let sun = light.sun_ray(&point);
        let surface = Surface { point, in_sun: sun.is_some(), sky: [0.0; 3], left: shading.ambient_occlusion };
        match sun.filter(|_| shading.shadows) {
            Some(ray) => {
                self.awaited = Awaited::Shadow(surface);
                Ok(Some(Aim { ray, kind: Kind::Shadow }))
            }
            None => self.look_up(surface),
        }
    }

    /// Looks into the sky once more, or if that was often enough is done with the sample.
    fn look_up(&mut self, mut surface: Surface) -> Result<Option<Aim>, RayError> {
        let Painter { light, shading, .. } = self.painter;
        while surface.left > 0 {
            surface.left -= 1;
            if let Some((ray, colour)) = light.sky_ray(&surface.point, &mut self.random) {
                self.awaited = Awaited::Occlusion(surface, colour);
                return Ok(Some(Aim { ray, kind: Kind::Occlusion }));
            }
        }
        let sky = match shading.ambient_occlusion {
            0 => light.open_sky(&surface.point),
            rays => surface.sky.map(|light| light / f64::from(rays)),
        };
        self.finish_sample(light.reflected(&surface.point, surface.in_sun, sky))
    }
}

impl Kind {
    pub(crate) fn goal(self) -> Goal {
        match self {
            Self::Primary => Goal::Closest,
            Self::Shadow | Self::Occlusion => Goal::Any,
        }
    }
}
