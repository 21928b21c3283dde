//! The sequence of rays that determines the colour of a pixel.

use super::lighting::{self, Colour, Lighting, SurfacePoint};
use super::{MAX_PIXELS, MAX_SIDE, RenderError, Shading};
use crate::camera::View;
use crate::{Camera, Goal, Hit, Scene};
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray, RayError};
use raypath_scene::vector::add;

/// The data that all pixels of a picture share.
pub(crate) struct PictureSampler<'s> {
    scene: &'s Scene,
    view: View,
    lighting: Lighting,
    shading: Shading,
    width: u32,
    pixels: u64,
}

/// The computation of one pixel's colour: it yields rays to trace and takes their hits.
pub(crate) struct PixelSampler<'p> {
    picture: &'p PictureSampler<'p>,
    /// The upper left corner of the pixel.
    corner: [f64; 2],
    random: ChaCha8Rng,
    /// The number of samples started.
    samples: u32,
    sum: Colour,
    pending: Pending,
}

pub(crate) struct SampleRay {
    pub(crate) ray: Ray<Binary32>,
    pub(crate) kind: RayKind,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum RayKind {
    /// From the eye.
    Primary,
    /// Towards the sun.
    Shadow,
    /// Into the sky, for ambient occlusion.
    Occlusion,
}

/// The ray whose hit is awaited.
enum Pending {
    None,
    Primary(Ray<Binary32>),
    Shadow(Surface),
    /// With the light that the ray adds if it hits nothing.
    Occlusion(Surface, Colour),
}

/// The surface that a primary ray has hit, and the light that it receives.
struct Surface {
    point: SurfacePoint,
    in_sun: bool,
    sky: Colour,
    /// The number of occlusion rays still to trace.
    occlusion_rays: u32,
}

impl<'s> PictureSampler<'s> {
    pub(crate) fn new(
        scene: &'s Scene,
        camera: &Camera,
        (width, height): (u32, u32),
        shading: &Shading,
    ) -> Result<Self, RenderError> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MAX_PIXELS || width.max(height) > MAX_SIDE {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=64).contains(&shading.samples) {
            return Err(RenderError::Samples(shading.samples));
        }
        let (view, lighting) = (camera.view(width, height), Lighting::new(scene, camera));
        Ok(Self { scene, view, lighting, shading: *shading, width, pixels })
    }

    pub(crate) fn pixels(&self) -> usize {
        self.pixels as usize
    }

    /// The sampler of a pixel; pixels are numbered row by row.
    pub(crate) fn pixel(&self, number: usize) -> PixelSampler<'_> {
        let (number, width) = (number as u64, u64::from(self.width));
        let corner = [(number % width) as f64, (number / width) as f64];
        let random = lighting::random(self.shading.seed, number);
        PixelSampler { picture: self, corner, random, samples: 0, sum: [0.0; 3], pending: Pending::None }
    }
}

impl PixelSampler<'_> {
    /// The next ray, or `None` when the colour is complete. `hit` is the hit of the previous ray; the first call
    /// ignores it.
    pub(crate) fn next_ray(&mut self, hit: Option<Hit>) -> Result<Option<SampleRay>, RayError> {
        match std::mem::replace(&mut self.pending, Pending::None) {
            Pending::None => self.start_sample(),
            Pending::Primary(ray) => match hit {
                Some(hit) => self.shade(&ray, &hit),
                None => self.finish_sample(self.picture.lighting.sky(ray.dir.into())),
            },
            Pending::Shadow(surface) => self.sample_sky(Surface { in_sun: hit.is_none(), ..surface }),
            Pending::Occlusion(mut surface, light) => {
                if hit.is_none() {
                    surface.sky = add(surface.sky, light);
                }
                self.sample_sky(surface)
            }
        }
    }

    /// The colour in sRGB, after the last ray.
    pub(crate) fn colour(&self) -> [u8; 3] {
        let samples = self.picture.shading.samples;
        lighting::tone_map(self.sum.map(|light| light / f64::from(samples * samples)))
    }

    /// Starts the next sample with its primary ray.
    fn start_sample(&mut self) -> Result<Option<SampleRay>, RayError> {
        let samples = self.picture.shading.samples;
        if self.samples == samples * samples {
            return Ok(None);
        }
        let offset = |step: u32| (f64::from(step) + 0.5) / f64::from(samples);
        let (dx, dy) = (offset(self.samples % samples), offset(self.samples / samples));
        let ray = self.picture.view.ray(self.corner[0] + dx, self.corner[1] + dy)?;
        self.samples += 1;
        self.pending = Pending::Primary(ray);
        Ok(Some(SampleRay { ray, kind: RayKind::Primary }))
    }

    fn finish_sample(&mut self, colour: Colour) -> Result<Option<SampleRay>, RayError> {
        self.sum = add(self.sum, colour);
        self.start_sample()
    }

    /// Sends a shadow ray from the surface that a primary ray hit.
    fn shade(&mut self, ray: &Ray<Binary32>, hit: &Hit) -> Result<Option<SampleRay>, RayError> {
        let PictureSampler { scene, lighting, shading, .. } = self.picture;
        let point = SurfacePoint::new(scene, ray, hit);
        let sun = lighting.sun_ray(&point);
        let occlusion_rays = shading.ambient_occlusion;
        let surface = Surface { point, in_sun: sun.is_some(), sky: [0.0; 3], occlusion_rays };
        match sun.filter(|_| shading.shadows) {
            Some(ray) => {
                self.pending = Pending::Shadow(surface);
                Ok(Some(SampleRay { ray, kind: RayKind::Shadow }))
            }
            None => self.sample_sky(surface),
        }
    }

    /// Sends the next occlusion ray, or finishes the sample after the last.
    fn sample_sky(&mut self, mut surface: Surface) -> Result<Option<SampleRay>, RayError> {
        let PictureSampler { lighting, shading, .. } = self.picture;
        while surface.occlusion_rays > 0 {
            surface.occlusion_rays -= 1;
            if let Some((ray, colour)) = lighting.sky_ray(&surface.point, &mut self.random) {
                self.pending = Pending::Occlusion(surface, colour);
                return Ok(Some(SampleRay { ray, kind: RayKind::Occlusion }));
            }
        }
        let sky = match shading.ambient_occlusion {
            0 => lighting.open_sky(&surface.point),
            rays => surface.sky.map(|light| light / f64::from(rays)),
        };
        self.finish_sample(lighting.reflected(&surface.point, surface.in_sun, sky))
    }
}

impl RayKind {
    pub(crate) fn goal(self) -> Goal {
        match self {
            Self::Primary => Goal::Closest,
            Self::Shadow | Self::Occlusion => Goal::Any,
        }
    }
}
