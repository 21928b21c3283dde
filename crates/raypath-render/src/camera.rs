//! Cameras and their primary rays.

use raypath_ops::{Binary32, Ray, RayError};
use raypath_scene::mesh::{Bounds, Mesh};
use raypath_scene::placement::Placement;
use raypath_scene::vector::{Vector, add, cross, dot, length, scale, single, subtract, unit, vector};
use thiserror::Error;

/// A pinhole camera that looks at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    field_of_view: f32,
}

/// Parameters of a camera that are not valid: what was found, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct CameraError(String);

impl Camera {
    /// The vertical field of view of [`framing`](Self::framing) in degrees.
    pub const FIELD_OF_VIEW: f32 = 36.0;

    /// A camera at `eye` that looks at `target`, with `up` upwards in the picture and a vertical field of view of
    /// `field_of_view` degrees.
    ///
    /// # Errors
    /// Coordinates that are not finite, an eye at the target, an up vector along the viewing direction, an angle that
    /// is not between 0 and 180.
    pub fn new(eye: [f32; 3], target: [f32; 3], up: [f32; 3], field_of_view: f32) -> Result<Self, CameraError> {
        let fails = |problem: String| Err(CameraError(problem));
        let text = |[x, y, z]: [f32; 3]| format!("({x}, {y}, {z})");
        for (what, value) in [("eye", eye), ("target", target), ("up", up)] {
            if !value.iter().all(|x| x.is_finite()) {
                return fails(format!("{what} {} is not finite, expected three finite numbers", text(value)));
            }
        }
        if eye == target {
            return fails(format!("eye and target are both {}, expected different points", text(eye)));
        }
        let forward = unit(subtract(vector(target), vector(eye)));
        if length(cross(forward, unit(vector(up)))) < 1e-6 {
            return fails(format!("up {} is parallel to the viewing direction, expected another direction", text(up)));
        }
        if !(field_of_view > 0.0 && field_of_view < 180.0) {
            let expected = "expected more than 0 and less than 180";
            return fails(format!("a field of view of {field_of_view} degrees, {expected}"));
        }
        Ok(Self { eye, target, up, field_of_view })
    }

    /// A camera that sees the whole mesh from the front, the right and above, in a picture that is `aspect` times as
    /// wide as high. Up is +y.
    pub fn framing(mesh: &Mesh, aspect: f32) -> Self {
        let corners = (0..mesh.triangles().len() as u32).flat_map(|index| mesh.corners(index));
        Self::around(mesh.bounds(), corners.map(vector), aspect)
    }

    /// A camera that sees all instances of a mesh, as [`framing`](Self::framing) does.
    pub fn framing_instances(mesh: &Mesh, placements: &[Placement], aspect: f32) -> Self {
        let own = mesh.bounds();
        let bounds = placements.iter().fold(Bounds::EMPTY, |all, placement| all.union(placement.bounds(own)));
        Self::around(bounds, placements.iter().flat_map(|placement| placement.corners(own)), aspect)
    }

    /// A camera that sees these points, which are inside of the bounds.
    fn around(bounds: Bounds, points: impl Iterator<Item = Vector>, aspect: f32) -> Self {
        let target = bounds.centre();
        let towards = unit([0.45, 0.42, 1.0]);
        let up = [0.0, 1.0, 0.0];
        let frame = Frame::new(scale(-1.0, towards), vector(up));
        let vertical = (f64::from(Self::FIELD_OF_VIEW).to_radians() / 2.0).tan();
        let horizontal = vertical * f64::from(aspect.max(0.01));
        // The distance at which a corner is inside the edges of the picture.
        let required = |corner: Vector| {
            let r = subtract(corner, vector(target));
            let (x, y) = (dot(r, frame.right).abs() / horizontal, dot(r, frame.up).abs() / vertical);
            x.max(y) + dot(r, towards)
        };
        let distance = 1.08 * points.map(required).fold(0.0, f64::max);
        let eye = single(add(vector(target), scale(distance, towards)));
        // A mesh of a single point has no size, and any distance shows it.
        let eye =
            if eye == target { single(add(vector(target), scale(1.0 + length(vector(target)), towards))) } else { eye };
        Self { eye, target, up, field_of_view: Self::FIELD_OF_VIEW }
    }

    /// The position of the camera, which is the origin of its rays.
    pub fn eye(&self) -> [f32; 3] {
        self.eye
    }

    pub(crate) fn frame(&self) -> Frame {
        Frame::new(unit(subtract(vector(self.target), vector(self.eye))), vector(self.up))
    }

    /// The rays through a picture of `width` × `height` pixels. They have infinite extent and unit directions.
    pub fn view(&self, width: u32, height: u32) -> View {
        let Frame { forward, right, up } = self.frame();
        let half = (f64::from(self.field_of_view).to_radians() / 2.0).tan();
        let step = 2.0 * half / f64::from(height);
        let corner = add(forward, add(scale(-step * f64::from(width) / 2.0, right), scale(half, up)));
        View { eye: self.eye, corner, right: scale(step, right), down: scale(-step, up) }
    }

    /// The rays of a [`view`](Self::view) through the centres of its pixels, row by row from the upper left.
    ///
    /// # Errors
    /// A direction that is not finite, because of an extreme aspect ratio.
    pub fn rays(&self, width: u32, height: u32) -> Result<Vec<Ray<Binary32>>, RayError> {
        let view = self.view(width, height);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
        pixels.map(|(x, y)| view.ray(x, y)).collect()
    }
}

/// The orthonormal axes of a camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) forward: Vector,
    pub(crate) right: Vector,
    pub(crate) up: Vector,
}

impl Frame {
    fn new(forward: Vector, up: Vector) -> Self {
        let right = unit(cross(forward, up));
        Self { forward, right, up: cross(right, forward) }
    }
}

/// The rays through the points of a picture.
#[derive(Debug, Clone, Copy)]
pub struct View {
    eye: [f32; 3],
    corner: Vector,
    right: Vector,
    down: Vector,
}

impl View {
    /// The ray through a point of the picture in pixels from the upper left corner: the centre of the first pixel is
    /// (0.5, 0.5).
    ///
    /// # Errors
    /// A point so far outside the picture that the direction is not finite.
    pub fn ray(&self, x: f64, y: f64) -> Result<Ray<Binary32>, RayError> {
        let direction = add(self.corner, add(scale(x, self.right), scale(y, self.down)));
        Ray::new(self.eye, single(unit(direction)), f32::INFINITY)
    }
}
