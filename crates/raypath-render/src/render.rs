//! From a scene and a camera to a picture.

mod brush;
mod light;

pub(crate) use brush::{Aim, Brush, Painter};

use crate::camera::Camera;
use crate::picture::{Picture, heatmap};
use crate::progress::{Progress, Stopped};
use crate::scene::Scene;
use crate::trace::{Counts, Tracer, Tracing};
use brush::Kind;
use rayon::prelude::*;
use raypath_ops::RayError;
use thiserror::Error;

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shading {
    /// How rays are traced, secondary ones too.
    pub tracing: Tracing,
    /// Whether a ray goes from each hit towards the sun.
    pub shadows: bool,
    /// How many rays go from each hit into the half space before it, to see how much of the sky lights it; 0 for none.
    pub ambient_occlusion: u32,
    /// A pixel is the mean of `samples` × `samples` rays through it, evenly spaced; 1 for one through its centre. At least
    /// 1.
    pub samples: u32,
    /// Which directions the rays of ambient occlusion have.
    pub seed: u64,
}

impl Default for Shading {
    fn default() -> Self {
        Self { tracing: Tracing::default(), shadows: false, ambient_occlusion: 0, samples: 1, seed: 1 }
    }
}

/// A picture, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// What is seen.
    pub picture: Picture,
    /// The jobs of each pixel, row by row; those of its secondary rays too.
    pub jobs: Vec<u32>,
    /// The cost of rays from the eye.
    pub primary: Costs,
    /// The cost of rays towards the sun.
    pub shadow: Costs,
    /// The cost of rays of ambient occlusion.
    pub occlusion: Costs,
}

/// Rays of one kind, and what they took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Costs {
    /// How many.
    pub rays: u64,
    /// How many of them hit something.
    pub hits: u64,
    /// Jobs and fetches.
    pub counts: Counts,
}

/// Why there is no picture.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RenderError {
    /// The picture has no pixels, or more than a picture should.
    #[error(
        "a picture of {width} x {height} pixels, expected 1 to {MOST_PIXELS} of them, at most {MOST_SIDE} in a row or column"
    )]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A pixel is the mean of no rays, or of very many.
    #[error("{0} x {0} samples a pixel, expected 1 to 64")]
    Samples(u32),
    /// The camera makes something that is not a ray.
    #[error("the camera: {0}")]
    Camera(#[from] RayError),
    /// The watch said to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The most pixels of a picture.
pub const MOST_PIXELS: u64 = 1 << 28;
/// The most pixels in a row or column.
pub const MOST_SIDE: u32 = 1 << 16;

/// Renders a picture of `width` × `height` pixels. Every ray, from the eye, towards the sun and into the sky, goes through
/// the datapath's operations. The same arguments make the same picture, on however many threads. `watch` hears now and
/// then how many pixels are done.
///
/// # Errors
/// A size without pixels or of too many, samples other than 1 to 64, and [`Stopped`] where `watch` answered false.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    shading: &Shading,
    watch: &(dyn Fn(u64) -> bool + Sync),
) -> Result<Rendering, RenderError> {
    let painter = Painter::new(scene, camera, size, shading)?;
    let (width, height) = size;
    let progress = Progress::new(watch);
    let mut canvas = vec![Pixel::default(); painter.pixels()];
    let rows = canvas.par_chunks_mut(width as usize).enumerate().map(|(row, pixels)| {
        let mut spent = Spent::default();
        if progress.is_stopped() {
            return Ok(spent);
        }
        let mut tracer = Tracer::new(scene, shading.tracing);
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let before = spent.jobs();
            let mut brush = painter.brush(row * width as usize + column);
            let mut hit = None;
            while let Some(Aim { ray, kind }) = brush.next(hit)? {
                hit = tracer.trace(&ray, kind.goal());
                spent.of(kind).add(&tracer, hit.is_some());
            }
            pixel.colour = brush.colour();
            pixel.jobs = u32::try_from(spent.jobs() - before).unwrap_or(u32::MAX);
        }
        progress.add(width.into());
        Ok::<Spent, RayError>(spent)
    });
    let spent = rows.try_reduce(Spent::default, |a, b| Ok(a.and(b)))?;
    progress.finish()?;
    let picture = Picture::of(width, height, canvas.iter().map(|pixel| pixel.colour).collect());
    let jobs = canvas.iter().map(|pixel| pixel.jobs).collect();
    Ok(Rendering { picture, jobs, primary: spent.primary, shadow: spent.shadow, occlusion: spent.occlusion })
}

impl Rendering {
    /// The jobs of each pixel as a picture with a legend below.
    pub fn heatmap(&self) -> Picture {
        heatmap(self.picture.width(), self.picture.height(), &self.jobs)
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    colour: [u8; 3],
    jobs: u32,
}

/// What rays of each kind took.
#[derive(Debug, Clone, Copy, Default)]
struct Spent {
    primary: Costs,
    shadow: Costs,
    occlusion: Costs,
}

impl Spent {
    fn of(&mut self, kind: Kind) -> &mut Costs {
        match kind {
            Kind::Primary => &mut self.primary,
            Kind::Shadow => &mut self.shadow,
            Kind::Occlusion => &mut self.occlusion,
        }
    }

    fn jobs(&self) -> u64 {
        [self.primary, self.shadow, self.occlusion].iter().map(|costs| costs.counts.jobs()).sum()
    }

    fn and(self, other: Self) -> Self {
        Self {
            primary: self.primary.and(other.primary),
            shadow: self.shadow.and(other.shadow),
            occlusion: self.occlusion.and(other.occlusion),
        }
    }
}

impl Costs {
    fn and(self, other: Self) -> Self {
        Self { rays: self.rays + other.rays, hits: self.hits + other.hits, counts: self.counts + other.counts }
    }

    /// Takes in the ray that was traced last.
    fn add(&mut self, tracer: &Tracer, hit: bool) {
        *self = self.and(Self { rays: 1, hits: hit.into(), counts: tracer.counts() });
    }
}
