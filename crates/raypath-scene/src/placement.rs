//! The places of a mesh in a scene of two levels.

use crate::mesh::{Bounds, Mesh};
use crate::vector::{Vector, add, cross, dot, scale, vector};
use raypath_traversal::Instance;
use thiserror::Error;

/// The names of the numbers of a matrix, row by row.
pub const NUMBERS: [&str; 12] = ["xx", "xy", "xz", "xt", "yx", "yy", "yz", "yt", "zx", "zy", "zz", "zt"];

/// A place of a mesh in a scene: an affine matrix that has an inverse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The rows x, y, z from the mesh to the scene; the last number of each is the translation.
    to_scene: [[f64; 4]; 3],
    /// The instance that the unit reads, of nothing, with the inverse in binary32.
    instance: Instance,
}

/// The reason why a matrix gives a mesh no place.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PlacementError {
    /// A number out of range.
    #[error("{name} = {value}, expected a number of magnitude at most 2^40")]
    Number {
        /// Its place in the matrix, as files name it.
        name: &'static str,
        /// The number.
        value: f64,
    },
    /// A matrix without an inverse, or with one whose numbers binary32 does not have.
    #[error("the matrix has no inverse, expected one that does not flatten")]
    Flat,
}

impl Placement {
    /// The place that this matrix gives a mesh, as a user wrote it.
    ///
    /// # Errors
    /// A number that is not finite or exceeds 2⁴⁰ in magnitude; a matrix without an inverse.
    pub fn checked(to_scene: [[f64; 4]; 3]) -> Result<Self, PlacementError> {
        let most = f64::from(Mesh::MAX_COORDINATE);
        let mut numbers = NUMBERS.into_iter().zip(to_scene.as_flattened());
        match numbers.find(|(_, number)| number.is_nan() || number.abs() > most) {
            Some((name, &value)) => Err(PlacementError::Number { name, value }),
            None => Self::new(to_scene).ok_or(PlacementError::Flat),
        }
    }

    /// The place that this matrix, from the mesh to the scene, gives a mesh. `None` if it has no inverse, or one with
    /// numbers that binary32 does not have.
    pub fn new(to_scene: [[f64; 4]; 3]) -> Option<Self> {
        Some(Self { to_scene, instance: Instance::placed(to_scene, 0, 0)? })
    }

    /// The place with the mask, the flags and the further indices of an instance.
    pub fn with_words_of(self, instance: Instance) -> Self {
        Self { instance: Instance { to_object: self.instance.to_object, ..instance }, ..self }
    }

    /// The instance of an object with this child word.
    pub fn instance(&self, root: u32, index: u32) -> Instance {
        Instance { root, index, ..self.instance }
    }

    /// Where a point of the mesh is in the scene.
    pub fn moved(&self, point: [f32; 3]) -> Vector {
        self.to_scene.map(|[x, y, z, t]| dot([x, y, z], vector(point)) + t)
    }

    /// Whether front faces of the mesh wind clockwise in the scene.
    pub fn is_mirrored(&self) -> bool {
        let [x, y, z] = self.to_scene.map(|[x, y, z, _]| [x, y, z]);
        dot(x, cross(y, z)) < 0.0
    }

    /// The corners in the scene of a box in the mesh.
    pub fn corners(&self, bounds: Bounds) -> [Vector; 8] {
        std::array::from_fn(|corner| {
            let axis = |axis: usize| if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            self.moved([axis(0), axis(1), axis(2)])
        })
    }

    /// The box in the scene around a box in the mesh, but for the rounding of its bounds.
    pub fn bounds(&self, bounds: Bounds) -> Bounds {
        self.corners(bounds).into_iter().fold(Bounds::EMPTY, |all, corner| all.with(corner.map(|x| x as f32)))
    }

    /// The reach in the mesh for rays that have this reach in the scene: the matrix adds up to three distances.
    pub fn object_reach(&self, reach: f32) -> f32 {
        let sums =
            self.instance.to_object.map(|[x, y, z, _]| f64::from(x).abs() + f64::from(y).abs() + f64::from(z).abs());
        // Rounded upwards, with room for the rounding of the matrix.
        (1.000_001 * f64::from(reach) * sums.into_iter().fold(0.0, f64::max)) as f32
    }

    /// How much larger the box of the instance must be on every side, so that a ray that hits the mesh in its own space
    /// hits the box in the scene.
    ///
    /// With R the reach in the scene, P the greatest coordinate of a ray's origin, M the matrix to the mesh, W the one
    /// from it, and u = 2⁻²⁴: the transforms have the errors of a rounded matrix, a product and three sums, at most
    /// 5u (1 + ε) relative to the sum of magnitudes, so that a point of the ray is wrong by at most
    /// e = 6u (|M| (P + R) + |t|) in the mesh. There the ray passes the triangle within 12u of the reach in the mesh
    /// ([`Bvh4`](crate::Bvh4)). In the scene this is |W| times as much; and the box test needs 12u R as always. The
    /// bounds are rounded once, by at most u (P + R).
    pub fn pad(&self, reach: f32, coordinate: f32) -> f64 {
        let u = f64::from(f32::EPSILON / 2.0);
        let (reach, coordinate) = (f64::from(reach), f64::from(coordinate));
        let object_reach = f64::from(self.object_reach(reach as f32));
        let in_object = self.instance.to_object.map(|row| {
            let [x, y, z, t] = row.map(|number| f64::from(number).abs());
            6.0 * u * ((x + y + z) * (coordinate + reach) + t) + 12.0 * u * object_reach
        });
        let in_scene = self.to_scene.map(|[x, y, z, _]| dot([x, y, z].map(f64::abs), in_object));
        in_scene.into_iter().fold(0.0, f64::max) + 12.0 * u * reach + u * (coordinate + reach)
    }

    /// A vector of the mesh's space that is normal to a plane there, in the scene.
    pub fn normal(&self, corners: [[f32; 3]; 3]) -> Vector {
        let [a, b, c] = corners.map(|corner| self.moved(corner));
        let normal = cross(add(b, scale(-1.0, a)), add(c, scale(-1.0, a)));
        if self.is_mirrored() { scale(-1.0, normal) } else { normal }
    }
}
