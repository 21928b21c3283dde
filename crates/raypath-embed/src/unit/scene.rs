//! Scenes of the unit, built from meshes.

use super::Unit;
use crate::Error;
use raypath_scene::{Bounds, Mesh, Placement, Scene, SceneError};

/// A scene in memory, as a unit reads it.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitScene {
    /// The bytes, from address 0 on.
    pub bytes: Box<[u8]>,
    /// The child word of the root, for [`UnitRay::root`](crate::UnitRay::root).
    pub root: u32,
    /// The corners of the box around the scene.
    pub bounds: [[f32; 3]; 2],
    /// The greatest distance, along any axis, between a ray's origin and a vertex up to which no hit is lost.
    pub reach: f32,
}

/// What a scene is built from.
#[derive(Debug, Clone, Default)]
pub struct SceneInput {
    /// The vertices.
    pub vertices: Vec<[f32; 3]>,
    /// The vertices of each triangle, counter-clockwise as seen from its front.
    pub triangles: Vec<[u32; 3]>,
    /// The places of the triangles in a scene of two levels, as affine matrices from the triangles to the scene, whose
    /// last column is the translation; `None` for a scene of one level.
    pub instances: Option<Vec<[[f64; 4]; 3]>>,
    /// The reach; 16 times the longest side of the scene by default.
    pub reach: Option<f32>,
}

impl Unit {
    /// Builds a scene in the layout that this unit reads.
    ///
    /// # Errors
    /// A vertex that does not exist; a coordinate, a matrix or a reach out of range; no triangle, or too many; no
    /// instance, one that is too far away, or a unit without instances.
    pub fn scene(&self, input: SceneInput) -> Result<UnitScene, Error> {
        let SceneInput { vertices, triangles, instances, reach } = input;
        let parameters = self.parameters().step;
        let error = |problem: &dyn ToString| Error::Argument(problem.to_string());
        Scene::check_reach(reach).map_err(|problem| error(&problem))?;
        if instances.is_some() && !parameters.features.instances {
            return Err(error(&"instances: the unit has none, expected a unit with instances"));
        }
        let placed = |(index, matrix): (usize, &[[f64; 4]; 3])| {
            Placement::checked(*matrix).map_err(|problem| error(&format!("instances: instance {index}: {problem}")))
        };
        let places = instances.map(|matrices| matrices.iter().enumerate().map(placed).collect::<Result<Vec<_>, _>>());
        let mesh = Mesh::new(vertices, triangles).map_err(|problem| error(&problem))?;
        let places = places.transpose()?;
        let build = || -> Result<Scene, SceneError> {
            let scene = match (places, reach) {
                (None, None) => Scene::new(mesh)?,
                (None, Some(reach)) => Scene::with_reach(mesh, reach)?,
                (Some(places), None) => Scene::of_instances(mesh, &places, [])?,
                (Some(places), Some(reach)) => Scene::of_instances_with_reach(mesh, &places, reach)?,
            };
            Ok(scene.through_unit_of(parameters.node)?)
        };
        let scene = build().map_err(|problem| error(&problem))?;
        let (bytes, root) = scene.blocks().map_or((&[][..], 0), |blocks| (blocks.bytes(), blocks.root()));
        let Bounds { min, max } = scene.bounds();
        Ok(UnitScene { bytes: bytes.into(), root, bounds: [min, max], reach: scene.reach() })
    }
}
