//! Triangle meshes.

use thiserror::Error;

/// Triangles with shared vertices; checked, so that whoever holds one need not.
///
/// Every coordinate is finite and at most [`Mesh::GREATEST`] in magnitude, every index names a vertex, and there is at
/// least one triangle. Degenerate triangles are kept. Triangles can be hit from the side from which their vertices run
/// counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Why something is not a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum MeshError {
    /// There is nothing to hit.
    #[error("0 triangles, expected at least 1")]
    NoTriangles,
    /// A coordinate is infinite, NaN, or so great that a triangle's distance would overflow.
    #[error("vertex {vertex} has {axis} = {value}, expected a number of magnitude at most 2^40")]
    Coordinate {
        /// Which vertex; the first is 0.
        vertex: usize,
        /// Along which axis.
        axis: char,
        /// What it is.
        value: f32,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, expected less than {vertices}, the number of vertices")]
    Index {
        /// Which triangle; the first is 0.
        triangle: usize,
        /// What it names.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
}

impl Mesh {
    /// The greatest magnitude of a coordinate, 2⁴⁰. The numerator of a distance is a product of three lengths; beyond
    /// this it could exceed binary32.
    pub const GREATEST: f32 = (1_u64 << 40) as f32;

    /// A mesh of `positions` and of triples of indices into them.
    ///
    /// # Errors
    /// No triangle, a coordinate that is not finite or exceeds [`GREATEST`](Self::GREATEST), an index that names no
    /// vertex.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        for (vertex, position) in positions.iter().enumerate() {
            for (axis, &value) in ['x', 'y', 'z'].into_iter().zip(position) {
                if value.is_nan() || value.abs() > Self::GREATEST {
                    return Err(MeshError::Coordinate { vertex, axis, value });
                }
            }
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            for &index in corners {
                if index as usize >= positions.len() {
                    return Err(MeshError::Index { triangle, index, vertices: positions.len() });
                }
            }
        }
        Ok(Self { positions, triangles })
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

    /// The box around all triangles. Vertices that no triangle names do not count.
    pub fn bounds(&self) -> Bounds {
        let corners = self.triangles.iter().flatten().map(|&vertex| self.positions[vertex as usize]);
        corners.fold(Bounds::EMPTY, Bounds::with)
    }
}

/// A box between two corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the least coordinates.
    pub min: [f32; 3],
    /// The corner with the greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box without points: min is +∞, max −∞.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The least box around this one and a point.
    #[inline]
    pub fn with(self, point: [f32; 3]) -> Self {
        self.union(Self { min: point, max: point })
    }

    /// The least box around two.
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

    /// The point in the middle.
    pub fn centre(self) -> [f32; 3] {
        std::array::from_fn(|axis| self.min[axis] / 2.0 + self.max[axis] / 2.0)
    }

    /// The greatest distance along an axis from a point to one of the box.
    pub fn reach_from(self, point: [f32; 3]) -> f32 {
        let along = |axis: usize| (point[axis] - self.min[axis]).abs().max((self.max[axis] - point[axis]).abs());
        (0..3).map(along).fold(0.0, f32::max)
    }
}
