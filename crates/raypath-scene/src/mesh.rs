//! Triangle meshes.

use robust::{Coord, orient2d};
use thiserror::Error;

/// A valid mesh of triangles with shared vertices.
///
/// Every coordinate is at most [`Mesh::MAX_COORDINATE`] in magnitude, every index names a vertex, and there is a
/// triangle. Degenerate triangles are kept. The vertices of a triangle run counter-clockwise as seen from its front.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    geometries: Vec<Geometry>,
    /// The geometry of each triangle, and its index there. Empty if the mesh is one geometry.
    places: Vec<TrianglePlace>,
}

/// What the triangles of a geometry are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Geometry {
    /// They count as opaque.
    pub is_opaque: bool,
    /// They stand for procedural boxes: the vertices a and b are the corners of a box, and c is one of them.
    pub is_boxes: bool,
}

impl Geometry {
    /// Opaque triangles.
    pub const OPAQUE: Self = Self { is_opaque: true, is_boxes: false };
}

/// The place of a triangle among geometries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrianglePlace {
    /// The index of its geometry.
    pub geometry: u32,
    /// Its index in the geometry.
    pub primitive: u32,
}

/// Positions and indices that are not a valid mesh: what was found, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct MeshError(String);

impl Mesh {
    /// The maximum magnitude of a coordinate, 2⁴⁰. The numerator of a distance is a product of three lengths, which
    /// could exceed binary32 for greater coordinates.
    pub const MAX_COORDINATE: f32 = (1_u64 << 40) as f32;

    /// A mesh of `positions` and `triangles`, which are triples of indices into them.
    ///
    /// # Errors
    /// No triangle, a coordinate that is not finite or exceeds [`MAX_COORDINATE`](Self::MAX_COORDINATE), an index that
    /// names no vertex.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError("0 triangles, expected at least 1".to_string()));
        }
        for (vertex, position) in positions.iter().enumerate() {
            for (axis, &value) in ['x', 'y', 'z'].into_iter().zip(position) {
                if value.is_nan() || value.abs() > Self::MAX_COORDINATE {
                    let expected = "expected a number of magnitude at most 2^40";
                    return Err(MeshError(format!("vertex {vertex} has {axis} = {value}, {expected}")));
                }
            }
        }
        let vertices = positions.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(index) = corners.iter().find(|&&index| index as usize >= vertices) {
                let expected = format!("expected less than {vertices}, the number of vertices");
                return Err(MeshError(format!("triangle {triangle} names vertex {index}, {expected}")));
            }
        }
        Ok(Self { positions, triangles, geometries: vec![Geometry::OPAQUE], places: Vec::new() })
    }

    /// The mesh as several geometries, with the place of each triangle.
    ///
    /// # Errors
    /// Another number of places than triangles; a geometry that does not exist.
    pub fn with_geometries(self, geometries: Vec<Geometry>, places: Vec<TrianglePlace>) -> Result<Self, MeshError> {
        if places.len() != self.triangles.len() {
            return Err(MeshError(format!("{} places, expected {}", places.len(), self.triangles.len())));
        }
        if let Some(place) = places.iter().find(|place| place.geometry as usize >= geometries.len()) {
            return Err(MeshError(format!("geometry {}, expected less than {}", place.geometry, geometries.len())));
        }
        Ok(Self { geometries, places, ..self })
    }

    /// The geometries.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The place of triangle `index`.
    #[inline]
    pub fn place(&self, index: u32) -> TrianglePlace {
        let whole = TrianglePlace { geometry: 0, primitive: index };
        self.places.get(index as usize).copied().unwrap_or(whole)
    }

    /// The vertices.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// The triangles, as indices into [`positions`](Self::positions).
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of triangle `index`, which must be less than the number of triangles.
    #[inline]
    pub fn corners(&self, index: u32) -> [[f32; 3]; 3] {
        self.triangles[index as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Whether the corners of triangle `index` are on one line, exactly. Procedural boxes are not degenerate.
    pub fn is_degenerate(&self, index: u32) -> bool {
        let corners = self.corners(index);
        let turns = |x: usize, y: usize| {
            let [a, b, c] = corners.map(|corner| Coord { x: f64::from(corner[x]), y: f64::from(corner[y]) });
            orient2d(a, b, c) != 0.0
        };
        let is_box = self.geometries.get(self.place(index).geometry as usize).is_some_and(|geometry| geometry.is_boxes);
        !(is_box || turns(0, 1) || turns(1, 2) || turns(2, 0))
    }

    /// The bounding box of all triangles. Unused vertices do not count.
    pub fn bounds(&self) -> Bounds {
        let corners = self.triangles.iter().flatten().map(|&vertex| self.positions[vertex as usize]);
        corners.fold(Bounds::EMPTY, Bounds::with)
    }
}

/// An axis-aligned bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the least coordinates.
    pub min: [f32; 3],
    /// The corner with the greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// The empty box: min is +∞, max −∞.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The smallest box that contains this one and a point.
    #[inline]
    pub fn with(self, point: [f32; 3]) -> Self {
        self.union(Self { min: point, max: point })
    }

    /// The smallest box that contains both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// The length of the longest side.
    pub fn longest_side(self) -> f32 {
        (0..3).map(|axis| self.max[axis] - self.min[axis]).fold(0.0, f32::max)
    }

    /// The centre.
    pub fn centre(self) -> [f32; 3] {
        std::array::from_fn(|axis| self.min[axis] / 2.0 + self.max[axis] / 2.0)
    }

    /// The greatest distance, along any axis, between `point` and a point of the box.
    pub fn reach_from(self, point: [f32; 3]) -> f32 {
        let along = |axis: usize| (point[axis] - self.min[axis]).abs().max((self.max[axis] - point[axis]).abs());
        (0..3).map(along).fold(0.0, f32::max)
    }
}
