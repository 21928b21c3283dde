//! Rendering of a scene, seen by a camera, as a picture.

mod lighting;
mod pixel;

pub(crate) use pixel::{PictureSampler, PixelSampler, SampleRay};

use crate::{Camera, Counts, Hit, Picture, Scene, Stopped, Tracer, Tracing, UnitErrors, heatmap};
use rayon::prelude::*;
use raypath_ops::RayError;
use raypath_timing::{Progress, ProgressCounter};
use std::ops::Range;
use thiserror::Error;

/// Options of rendering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shading {
    /// The options of tracing, for primary and secondary rays.
    pub tracing: Tracing,
    /// Whether to trace a shadow ray from each hit towards the sun.
    pub shadows: bool,
    /// The number of ambient-occlusion rays from each hit into the sky; 0 for none.
    pub ambient_occlusion: u32,
    /// The samples per pixel along each axis, 1 to 64: a pixel is the mean of evenly spaced primary rays.
    pub samples: u32,
    /// The seed for the directions of ambient-occlusion rays.
    pub seed: u64,
}

impl Default for Shading {
    fn default() -> Self {
        Self { tracing: Tracing::default(), shadows: false, ambient_occlusion: 0, samples: 1, seed: 1 }
    }
}

/// A rendered picture with its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// The picture.
    pub picture: Picture,
    /// The number of jobs of each pixel, row by row, with its secondary rays.
    pub jobs: Vec<u32>,
    /// The cost of primary rays.
    pub primary: Costs,
    /// The cost of shadow rays.
    pub shadow: Costs,
    /// The cost of ambient-occlusion rays.
    pub occlusion: Costs,
}

/// The cost of the rays of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Costs {
    /// The number of rays.
    pub rays: u64,
    /// The number of rays with a hit.
    pub hits: u64,
    /// The jobs and fetches.
    pub counts: Counts,
}

/// The reason why rendering failed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RenderError {
    /// The size of the picture is out of range.
    #[error(
        "a picture of {width} x {height} pixels, expected 1 to {MAX_PIXELS} pixels and at most {MAX_SIDE} per side"
    )]
    Size {
        /// The width in pixels.
        width: u32,
        /// The height in pixels.
        height: u32,
    },
    /// The rows are not those of the picture.
    #[error("{found} rows, expected {height}")]
    Rows {
        /// The number of rows.
        found: u32,
        /// The height in pixels.
        height: u32,
    },
    /// The hits are not those of the picture.
    #[error("{found} hits, expected {pixels}, one for each pixel")]
    Hits {
        /// The number of hits.
        found: usize,
        /// The number of pixels.
        pixels: usize,
    },
    /// A hit has a triangle that the scene does not have.
    #[error("pixel {pixel} shows triangle {triangle}, expected one of the scene's {triangles}")]
    Triangle {
        /// The number of the pixel, row by row from 0.
        pixel: usize,
        /// The index of the triangle.
        triangle: u32,
        /// The number of triangles of the scene.
        triangles: usize,
    },
    /// A hit has an instance that the scene does not have, or none in a scene of instances.
    #[error("pixel {pixel} shows {}, expected one of the scene's {instances} instances",
        instance.map_or("no instance".to_string(), |instance| format!("instance {instance}")))]
    Instance {
        /// The number of the pixel, row by row from 0.
        pixel: usize,
        /// The number of the instance.
        instance: Option<u32>,
        /// The number of instances of the scene.
        instances: usize,
    },
    /// The number of samples is out of range.
    #[error("{0} x {0} samples per pixel, expected 1 to 64")]
    Samples(u32),
    /// A primary ray of the camera is invalid.
    #[error("the camera: {0}")]
    Camera(#[from] RayError),
    /// The traversal unit ended rays with an error.
    #[error(transparent)]
    Unit(#[from] UnitErrors),
    /// The progress callback returned false.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The maximum number of pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 28;
/// The maximum number of pixels in a row or column.
pub const MAX_SIDE: u32 = 1 << 16;

/// The pixels that a thread renders at once, so that it stops soon.
const BATCH: usize = 64;

/// Renders a picture of `size` = (width, height) pixels on all threads of rayon; all rays use the operations of the
/// datapath. The picture does not depend on the number of threads. `progress` gets the number of completed pixels.
///
/// # Errors
/// A size or a number of samples out of range; rays that the traversal unit ended with an error; `progress` returned
/// false.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    shading: &Shading,
    progress: Progress,
) -> Result<Rendering, RenderError> {
    Rendering::of(size, [render_rows(scene, camera, size, shading, 0..size.1, progress)?])
}

/// Renders some rows of a picture, as [`render`] does.
///
/// # Errors
/// Those of [`render`]; rows outside of the picture.
pub fn render_rows(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    shading: &Shading,
    rows: Range<u32>,
    progress: Progress,
) -> Result<Rows, RenderError> {
    let sampler = PictureSampler::new(scene, camera, size, shading)?;
    let (width, height) = size;
    if rows.end > height {
        return Err(RenderError::Rows { found: rows.end, height });
    }
    let progress = ProgressCounter::new(progress);
    let first = rows.start as usize * width as usize;
    let mut pixels = vec![Pixel::default(); rows.len() * width as usize];
    let rows = pixels.par_chunks_mut(BATCH).enumerate().map(|(batch, pixels)| {
        let mut costs = [Costs::default(); 3];
        if progress.is_stopped() {
            return Ok(costs);
        }
        let mut tracer = Tracer::new(scene, shading.tracing);
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let before = jobs(&costs);
            let mut pixel_sampler = sampler.pixel(first + batch * BATCH + column);
            let mut hit = None;
            while let Some(SampleRay { ray, kind }) = pixel_sampler.next_ray(hit)? {
                hit = tracer.trace(&ray, kind.goal());
                costs[kind as usize].add(&tracer, hit.is_some());
            }
            pixel.colour = pixel_sampler.colour();
            pixel.jobs = u32::try_from(jobs(&costs) - before).unwrap_or(u32::MAX);
        }
        progress.add(pixels.len() as u64);
        Ok::<_, RayError>(costs)
    });
    let sums = |a: [Costs; 3], b: [Costs; 3]| Ok(std::array::from_fn(|kind| a[kind].and(b[kind])));
    let costs: [Costs; 3] = rows.try_reduce(Default::default, sums)?;
    if progress.is_stopped() {
        return Err(Stopped.into());
    }
    costs.iter().fold(UnitErrors::default(), |all, costs| all.and(costs.counts.errors)).check()?;
    let (colours, jobs) = pixels.into_iter().map(|pixel| (pixel.colour, pixel.jobs)).unzip();
    Ok(Rows { colours, jobs, costs })
}

/// Draws a picture from the hits of the rays through its pixel centres ([`Camera::rays`]), wherever they were traced.
/// The picture is that of [`render`] with the default [`Shading`] if the hits are.
///
/// # Errors
/// A size out of range; hits of another number of pixels or of triangles that the scene does not have.
pub fn draw(scene: &Scene, camera: &Camera, size: (u32, u32), hits: &[Option<Hit>]) -> Result<Picture, RenderError> {
    let (width, height) = size;
    let sampler = PictureSampler::new(scene, camera, size, &Shading::default())?;
    let pixels = sampler.pixels();
    if hits.len() != pixels {
        return Err(RenderError::Hits { found: hits.len(), pixels });
    }
    let triangles = scene.mesh().triangles().len();
    let mut bytes = Vec::with_capacity(3 * pixels);
    for (pixel, hit) in hits.iter().enumerate() {
        if let Some(Hit { triangle, .. }) = *hit
            && triangle as usize >= triangles
        {
            return Err(RenderError::Triangle { pixel, triangle, triangles });
        }
        let instances = scene.instances();
        if let Some(Hit { instance, .. }) = *hit
            && instance.map_or(instances > 0, |instance| instance as usize >= instances)
        {
            return Err(RenderError::Instance { pixel, instance, instances });
        }
        let mut pixel = sampler.pixel(pixel);
        pixel.next_ray(None)?;
        pixel.next_ray(*hit)?;
        bytes.extend(pixel.colour());
    }
    Picture::from_raw(width, height, bytes).ok_or(RenderError::Size { width, height })
}

/// Rendered rows of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rows {
    /// The colour of each pixel, row by row.
    pub colours: Vec<[u8; 3]>,
    /// The number of jobs of each pixel, row by row.
    pub jobs: Vec<u32>,
    /// The costs of primary, shadow and ambient-occlusion rays.
    pub costs: [Costs; 3],
}

impl Rendering {
    /// The picture of `size` = (width, height) pixels with these rows, from the top.
    ///
    /// # Errors
    /// The rows have more or fewer pixels than the picture.
    pub fn of(size: (u32, u32), rows: impl IntoIterator<Item = Rows>) -> Result<Self, RenderError> {
        let (width, height) = size;
        let (mut bytes, mut jobs, mut costs) = (Vec::new(), Vec::new(), [Costs::default(); 3]);
        for rows in rows {
            bytes.extend(rows.colours.into_iter().flatten());
            jobs.extend(rows.jobs);
            costs = std::array::from_fn(|kind| costs[kind].and(rows.costs[kind]));
        }
        let found = u32::try_from(jobs.len() / width.max(1) as usize).unwrap_or(u32::MAX);
        let picture = Picture::from_raw(width, height, bytes).filter(|_| found == height);
        let picture = picture.ok_or(RenderError::Rows { found, height })?;
        let [primary, shadow, occlusion] = costs;
        Ok(Self { picture, jobs, primary, shadow, occlusion })
    }

    /// The heat map of the jobs of each pixel, with a legend below.
    pub fn heatmap(&self) -> Picture {
        heatmap(self.picture.width(), self.picture.height(), &self.jobs)
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    colour: [u8; 3],
    jobs: u32,
}

fn jobs(costs: &[Costs; 3]) -> u64 {
    costs.iter().map(|costs| costs.counts.jobs()).sum()
}

impl Costs {
    fn and(self, other: Self) -> Self {
        Self { rays: self.rays + other.rays, hits: self.hits + other.hits, counts: self.counts + other.counts }
    }

    /// Adds the last ray of a tracer.
    fn add(&mut self, tracer: &Tracer, hit: bool) {
        *self = self.and(Self { rays: 1, hits: hit.into(), counts: tracer.counts() });
    }
}
