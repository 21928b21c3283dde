//! The watertightness theorem of `docs/reference/error-bounds.md`, applied to edges and vertices of meshes.

use raypath_ops::{Binary32, Ray};
use raypath_render::Mesh;
use raypath_verify_datapath::geometry::patches::{Patch, Target};
use raypath_verify_datapath::geometry::visibility::{Visibility, visibility};
use std::collections::HashMap;

/// The faces around each edge and vertex.
pub struct Patches<'m> {
    mesh: &'m Mesh,
    /// The faces of each directed edge.
    edges: HashMap<(u32, u32), Vec<u32>>,
    fans: HashMap<u32, Vec<u32>>,
}

impl<'m> Patches<'m> {
    pub fn new(mesh: &'m Mesh) -> Self {
        let (mut edges, mut fans) = (HashMap::new(), HashMap::new());
        for (face, &[a, b, c]) in (0..).zip(mesh.triangles()) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                edges.entry((from, to)).or_insert_with(Vec::new).push(face);
            }
            for vertex in [a, b, c] {
                fans.entry(vertex).or_insert_with(Vec::new).push(face);
            }
        }
        Self { mesh, edges, fans }
    }

    /// The two faces of an edge of `face`, if there are exactly two with opposite directions.
    pub fn edge(&self, face: u32, corner: usize) -> Option<Vec<u32>> {
        let corners = self.mesh.triangles()[face as usize];
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let (one, other) = (self.edges.get(&(a, b))?, self.edges.get(&(b, a))?);
        (one.len() == 1 && other.len() == 1 && one != other).then(|| vec![one[0], other[0]])
    }

    /// All faces at a corner of `face`.
    pub fn fan(&self, face: u32, corner: usize) -> Vec<u32> {
        self.fans[&self.mesh.triangles()[face as usize][corner]].clone()
    }

    /// The greatest possible distance of the hit, if the theorem guarantees one.
    pub fn must_hit(&self, faces: &[u32], ray: &Ray<Binary32>) -> Option<f64> {
        let faces: Vec<[u32; 3]> = faces.iter().map(|face| self.mesh.triangles()[*face as usize]).collect();
        let mut vertices = faces.concat();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |vertex| vertices.binary_search(&vertex).unwrap();
        let faces = faces.iter().map(|face| face.map(place)).collect();
        let corners: Vec<[f32; 3]> = vertices.iter().map(|vertex| self.mesh.positions()[*vertex as usize]).collect();
        let patch = Patch::new(Target::Vertex, corners, faces);
        let Visibility::Clear(_) = visibility(ray, &patch) else { return None };
        let kz = u32::from(ray.kz) as usize;
        let (o, d): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        let depths = patch.vertices.iter().map(|p| (f64::from(p[kz]) - f64::from(o[kz])) / f64::from(d[kz]));
        Some(depths.fold(0.0, f64::max) * (1.0 + 1e-6))
    }
}
