//! Scenes of the unit, built from meshes.

use super::Unit;
use crate::Error;
use raypath_scene::{Bounds, Geometry, Group, Member, Mesh, Placement, Scene, SceneError, TrianglePlace, group};
use raypath_traversal::{Instance, Queries, StepParameters, instance_flags};
use std::collections::HashSet;

/// A scene in memory, as a unit reads it.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitScene {
    /// The bytes, from address 0 on.
    pub bytes: Box<[u8]>,
    /// The child word of the root, for [`UnitRay::root`](crate::UnitRay::root).
    pub root: u32,
    /// The corners of the box around the scene, with the margins of instances.
    pub bounds: [[f32; 3]; 2],
    /// The greatest distance, along any axis, between a ray's origin and a vertex up to which no hit is lost: infinite
    /// without instances.
    pub reach: f32,
    /// What it needs of a unit.
    pub queries: Queries,
}

/// What a scene is built from.
#[derive(Debug, Clone, Default)]
pub struct SceneInput {
    /// The vertices.
    pub vertices: Vec<[f32; 3]>,
    /// The vertices of each triangle. With queries, one with a vertex whose x is NaN is inactive: it is not hit, and
    /// counts in indices.
    pub triangles: Vec<[u32; 3]>,
    /// The corners with the least and the greatest coordinates of procedural boxes, as inactive as triangles. One with
    /// a least coordinate above the greatest is the point in its middle.
    pub boxes: Vec<crate::Bounds>,
    /// The geometries, to which the triangles and the boxes belong in order; none for one opaque geometry of all
    /// triangles.
    pub geometries: Vec<SceneGeometry>,
    /// The places of the triangles in a scene of two levels; `None` for a scene of one level.
    pub instances: Option<Vec<SceneInstance>>,
    /// The reach of a scene with instances; 16 times its longest side by default.
    pub reach: Option<f32>,
}

/// Triangles or procedural boxes of a scene that are opaque or not.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SceneGeometry {
    /// The number of its triangles.
    pub triangles: u32,
    /// The number of its boxes; 0 if it has triangles.
    pub boxes: u32,
    /// 0 if they are opaque, 1 if not.
    pub non_opaque: u32,
}

/// A place of the triangles in a scene, 112 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SceneInstance {
    /// The affine matrix from the triangles to the scene, row by row; the last number of each row is the translation.
    pub matrix: [[f64; 4]; 3],
    /// The custom index, below 2²⁴.
    pub custom_index: u32,
    /// Rays count it whose mask has a bit of this one, 0 to 255.
    pub mask: u32,
    /// The offset into the shader table, below 2²⁴.
    pub shader_offset: u32,
    /// The bits `RAYPATH_INSTANCE_…` that are set.
    pub flags: u32,
}

impl SceneInstance {
    /// An instance with this matrix, for all rays.
    pub fn of(matrix: [[f64; 4]; 3]) -> Self {
        Self { matrix, mask: u8::MAX.into(), ..Self::default() }
    }

    /// The place, as a user wrote it.
    fn placed(&self) -> Result<Placement, String> {
        let Self { matrix, custom_index, mask, shader_offset, flags } = *self;
        let (low, high) = ((1 << 24) - 1, u8::MAX.into());
        let words = [("custom_index", custom_index, low), ("mask", mask, high), ("shader_offset", shader_offset, low)];
        for (name, value, most) in words.into_iter().chain([("flags", flags, instance_flags::ALL)]) {
            if value > most {
                return Err(format!("{name} is {value}, expected 0 to {most}"));
            }
        }
        if flags & FORCES == FORCES {
            return Err(format!("flags are {flags}, expected at most one of 4 and 8"));
        }
        let placement = Placement::checked(matrix).map_err(|problem| problem.to_string())?;
        let (mask, flags) = (mask as u8, flags as u8);
        Ok(placement.with_words_of(Instance { custom_index, mask, shader_offset, flags, ..Instance::default() }))
    }
}

const FORCES: u32 = instance_flags::FORCE_OPAQUE | instance_flags::FORCE_NO_OPAQUE;

impl SceneInput {
    /// The mesh, without what is inactive in it, which scenes of a unit with queries may have. A box is a triangle of its
    /// corners.
    fn mesh(self, queries: Queries) -> Result<Mesh, String> {
        let Self { mut vertices, mut triangles, boxes, geometries, .. } = self;
        let corners_of = |triangle: &[u32; 3], vertices: &[[f32; 3]]| {
            triangle.map(|vertex| vertices.get(vertex as usize).copied().unwrap_or_default())
        };
        let is_inactive = |triangle: &[u32; 3], vertices: &[[f32; 3]]| {
            queries != Queries::None && corners_of(triangle, vertices).iter().any(|[x, ..]| x.is_nan())
        };
        if geometries.is_empty() && boxes.is_empty() && !triangles.iter().any(|face| is_inactive(face, &vertices)) {
            return Mesh::new(vertices, triangles).map_err(|problem| problem.to_string());
        }
        let whole = SceneGeometry { triangles: triangles.len() as u32, ..SceneGeometry::default() };
        let geometries = if geometries.is_empty() { vec![whole] } else { geometries };
        let count =
            |of: fn(&SceneGeometry) -> u32| geometries.iter().map(|geometry| u64::from(of(geometry))).sum::<u64>();
        for (what, expected, found) in [
            ("triangles", count(|geometry| geometry.triangles), triangles.len()),
            ("boxes", count(|geometry| geometry.boxes), boxes.len()),
        ] {
            if expected != found as u64 {
                return Err(format!("the geometries have {expected} {what}, expected {found}"));
            }
        }
        if let Some(mixed) = geometries.iter().position(|geometry| geometry.triangles > 0 && geometry.boxes > 0) {
            return Err(format!("geometry {mixed} has triangles and boxes, expected one of them"));
        }
        let faces = triangles.len();
        for &crate::Bounds { min, max } in &boxes {
            let first = u32::try_from(vertices.len()).map_err(|_| "too many boxes".to_string())?;
            let is_point = (0..3).any(|axis| min[axis] > max[axis]);
            let middle = std::array::from_fn(|axis| min[axis] / 2.0 + max[axis] / 2.0);
            vertices.extend(if is_point { [middle; 2] } else { [min, max] });
            triangles.push([first, first + 1, first]);
        }
        let (mut of_triangles, mut of_boxes) = (0..faces, faces..triangles.len());
        let (mut active, mut places) = (Vec::new(), Vec::new());
        for (geometry, SceneGeometry { triangles: faces, boxes, .. }) in (0..).zip(&geometries) {
            let own = of_triangles.by_ref().take(*faces as usize).chain(of_boxes.by_ref().take(*boxes as usize));
            for (primitive, place) in (0..).zip(own) {
                if !is_inactive(&triangles[place], &vertices) {
                    active.push(triangles[place]);
                    places.push(TrianglePlace { geometry, primitive });
                }
            }
        }
        // Vertices of what is inactive may be NaN.
        let used: HashSet<u32> = active.iter().flatten().copied().collect();
        let unused = |(number, vertex): (u32, [f32; 3])| if used.contains(&number) { vertex } else { [0.0; 3] };
        let vertices = (0..).zip(vertices).map(unused).collect();
        let kinds = geometries.iter().map(|&SceneGeometry { boxes, non_opaque, .. }| Geometry {
            is_opaque: non_opaque == 0,
            is_boxes: boxes > 0,
        });
        let mesh = Mesh::new(vertices, active).and_then(|mesh| mesh.with_geometries(kinds.collect(), places));
        mesh.map_err(|problem| problem.to_string())
    }
}

impl Unit {
    /// Builds a scene in the layout that this unit reads.
    ///
    /// # Errors
    /// A vertex that does not exist; a coordinate, a matrix, a word of an instance or a reach out of range; no active
    /// triangle, or too many; no instance, one that is too far away, or a unit without instances or queries that the
    /// scene needs.
    pub fn scene(&self, input: SceneInput) -> Result<UnitScene, Error> {
        let reach = input.reach;
        let parameters = self.parameters().step;
        let error = |problem: &dyn ToString| Error::Argument(problem.to_string());
        Scene::check_reach(reach).map_err(|problem| error(&problem))?;
        if input.instances.is_some() && !parameters.features.instances {
            return Err(error(&"instances: the unit has none, expected a unit with instances"));
        }
        let placed = |(index, instance): (usize, &SceneInstance)| {
            instance.placed().map_err(|problem| error(&format!("instances: instance {index}: {problem}")))
        };
        let places =
            input.instances.as_ref().map(|all| all.iter().enumerate().map(placed).collect::<Result<Vec<_>, _>>());
        let mesh = input.mesh(parameters.features.queries).map_err(|problem| error(&problem))?;
        let places = places.transpose()?;
        let build = || -> Result<Scene, SceneError> {
            let scene = match (places, reach) {
                (None, _) => Scene::new(mesh)?,
                (Some(places), None) => Scene::of_instances(mesh, &places, [])?,
                (Some(places), Some(reach)) => Scene::of_instances_with_reach(mesh, &places, reach)?,
            };
            Ok(scene.through_unit_of(parameters.node)?)
        };
        let scene = build().map_err(|problem| error(&problem))?;
        let needs = scene.blocks().map_or(Queries::None, |blocks| blocks.features().queries);
        let has = parameters.features.queries;
        if needs > has {
            let what = match needs {
                Queries::Full => "procedural boxes",
                _ => "geometries that are several or not opaque, or instances with a mask, flags or further indices",
            };
            return Err(error(&format!("{what}: the unit has queries {has}, expected {needs}")));
        }
        let (bytes, root, around) = scene
            .blocks()
            .map_or((&[][..], 0, Bounds::EMPTY), |blocks| (blocks.bytes(), blocks.root(), blocks.bounds()));
        let Bounds { min, max } = if scene.instances() == 0 { scene.bounds() } else { around };
        Ok(UnitScene { bytes: bytes.into(), root, bounds: [min, max], reach: scene.reach(), queries: needs })
    }

    /// Builds a scene of scenes that this unit reads: each place names one of them by its number. In a unit with nested
    /// instances they may have instances themselves. The index of an instance is its position among the places.
    ///
    /// # Errors
    /// A scene that does not exist, or is none of this unit's; a matrix, a word of an instance or a reach out of range; a
    /// scene that was built for a smaller reach than its places need; no place, or one that is too far away; a unit
    /// without instances, nested instances or queries that the scene needs.
    pub fn group(
        &self,
        scenes: &[&UnitScene],
        places: &[(u32, SceneInstance)],
        reach: Option<f32>,
    ) -> Result<UnitScene, Error> {
        let error = |problem: &dyn ToString| Error::Argument(problem.to_string());
        Scene::check_reach(reach).map_err(|problem| error(&problem))?;
        let StepParameters { node, features, .. } = self.parameters().step;
        let members: Vec<Member<'_>> = scenes
            .iter()
            .map(|UnitScene { bytes, root, bounds: [min, max], reach, .. }| {
                let bounds = Bounds { min: *min, max: *max };
                Member { bytes, root: *root, bounds, reach: *reach }
            })
            .collect();
        let placed = |(index, (scene, instance)): (usize, &(u32, SceneInstance))| {
            let placement = instance.placed().map_err(|problem| error(&format!("instance {index}: {problem}")))?;
            Ok((*scene as usize, placement))
        };
        let places = places.iter().enumerate().map(placed).collect::<Result<Vec<_>, Error>>()?;
        let Group { blocks, bounds: Bounds { min, max }, reach } =
            group(&members, &places, reach, node).map_err(|problem| error(&problem))?;
        let needs = blocks.features();
        let queries = scenes.iter().fold(needs.queries, |all, scene| all.max(scene.queries));
        for (is_missing, what) in [
            (!features.instances, "instances"),
            (needs.nested && !features.nested, "nested instances"),
            (queries > features.queries, "queries"),
        ] {
            if is_missing {
                return Err(error(&format!(
                    "the unit has no {what}, expected a unit with {what}, which the scene needs"
                )));
            }
        }
        Ok(UnitScene { bytes: blocks.bytes().into(), root: blocks.root(), bounds: [min, max], reach, queries })
    }
}
