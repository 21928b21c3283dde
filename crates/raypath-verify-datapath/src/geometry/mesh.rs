//! Closed meshes of triangles, counter-clockwise as seen from outside. They are computed with basic arithmetic and
//! square roots only, so that they are the same on every machine.

use super::vector::{Point, cross, dot, minus, scaled, sum, unit};
use std::collections::{HashMap, HashSet};

#[derive(Debug, Clone)]
pub struct Mesh {
    pub name: &'static str,
    pub vertices: Vec<[f32; 3]>,
    /// The three vertices of each face.
    pub faces: Vec<[usize; 3]>,
}

/// Some faces of a mesh, and their boundary.
#[derive(Debug, Clone)]
pub struct Patch {
    pub faces: Vec<usize>,
    /// The directed edges that only one of the faces has.
    pub rim: Vec<[usize; 2]>,
}

impl Mesh {
    /// A mesh with the binary32 points nearest to these as vertices.
    pub fn new(name: &'static str, points: &[Point], faces: Vec<[usize; 3]>) -> Self {
        let vertices = points.iter().map(|point| point.map(|coordinate| coordinate as f32)).collect();
        Self { name, vertices, faces }
    }

    /// The mesh scaled and moved, with vertices rounded to binary32.
    pub fn placed(&self, scale: f64, offset: Point) -> Self {
        let place = |vertex: &[f32; 3]| sum(scaled(vertex.map(f64::from), scale), offset);
        let points: Vec<Point> = self.vertices.iter().map(place).collect();
        Self::new(self.name, &points, self.faces.clone())
    }

    pub fn corners(&self, face: usize) -> [[f32; 3]; 3] {
        self.faces[face].map(|vertex| self.vertices[vertex])
    }

    /// These faces as a patch.
    pub fn patch(&self, faces: Vec<usize>) -> Patch {
        let edges: Vec<[usize; 2]> = faces.iter().flat_map(|&face| edges(self.faces[face])).collect();
        // A few edges are faster to compare than to hash.
        let rim = if edges.len() < 64 {
            edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect()
        } else {
            let all: HashSet<[usize; 2]> = edges.iter().copied().collect();
            edges.into_iter().filter(|&[a, b]| !all.contains(&[b, a])).collect()
        };
        Patch { faces, rim }
    }

    /// Each edge once, with its ends and its two faces.
    pub fn edges(&self) -> Vec<([usize; 2], [usize; 2])> {
        let sides: HashMap<[usize; 2], usize> =
            (0..self.faces.len()).flat_map(|face| edges(self.faces[face]).map(|edge| (edge, face))).collect();
        let directed = (0..self.faces.len()).flat_map(|face| edges(self.faces[face]).map(|edge| (edge, face)));
        let undirected = directed.filter(|([a, b], _)| a < b);
        undirected.filter_map(|([a, b], face)| Some(([a, b], [face, *sides.get(&[b, a])?]))).collect()
    }

    /// The faces around each vertex.
    pub fn fans(&self) -> Vec<Vec<usize>> {
        let mut fans = vec![Vec::new(); self.vertices.len()];
        for (face, corners) in self.faces.iter().enumerate() {
            corners.iter().for_each(|&vertex| fans[vertex].push(face));
        }
        fans
    }

    /// The centre of the vertices, and the distance of the farthest vertex from it.
    pub fn ball(&self) -> (Point, f64) {
        let points = || self.vertices.iter().map(|vertex| vertex.map(f64::from));
        let centre = scaled(points().fold([0.0; 3], sum), 1.0 / self.vertices.len() as f64);
        let radius = points().map(|point| dot(minus(point, centre), minus(point, centre)).sqrt()).fold(0.0, f64::max);
        (centre, radius)
    }

    pub fn normal(&self, face: usize) -> Point {
        let [a, b, c] = self.corners(face).map(|corner| corner.map(f64::from));
        unit(cross(minus(b, a), minus(c, a)))
    }
}

fn edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

#[cfg(test)]
mod tests {
    use super::super::shapes::shapes;
    use super::{Mesh, cross, dot, edges};
    use std::collections::HashSet;

    /// Every edge occurs once in each direction, every vertex is used, and the volume is positive.
    fn is_closed_and_faces_outwards(mesh: &Mesh) -> bool {
        let all: HashSet<[usize; 2]> = mesh.faces.iter().flat_map(|&face| edges(face)).collect();
        let walked_once = all.len() == 3 * mesh.faces.len();
        let both_ways = all.iter().all(|&[a, b]| a != b && all.contains(&[b, a]));
        let distinct: HashSet<[u32; 3]> = mesh.vertices.iter().map(|vertex| vertex.map(f32::to_bits)).collect();
        let used = mesh.fans().iter().all(|fan| fan.len() >= 3) && distinct.len() == mesh.vertices.len();
        let corners = (0..mesh.faces.len()).map(|face| mesh.corners(face).map(|corner| corner.map(f64::from)));
        let volume: f64 = corners.map(|[a, b, c]| dot(a, cross(b, c)) / 6.0).sum();
        walked_once && both_ways && used && volume > 0.0
    }

    #[test]
    fn all_shapes_are_closed_and_face_outwards() {
        let shapes = shapes(1);
        assert!(shapes.len() >= 14);
        for mesh in &shapes {
            assert!(is_closed_and_faces_outwards(mesh), "{}", mesh.name);
            assert_eq!(mesh.edges().len() * 2, mesh.faces.len() * 3, "{}", mesh.name);
            let holes = if mesh.name == "torus" { 1 } else { 0 };
            assert_eq!(mesh.vertices.len() + mesh.faces.len() + 2 * holes, mesh.edges().len() + 2, "{}", mesh.name);
            let mut open = mesh.clone();
            open.faces.pop();
            assert!(!is_closed_and_faces_outwards(&open), "{}", mesh.name);
            let mut turned = mesh.clone();
            turned.faces[0].swap(0, 1);
            assert!(!is_closed_and_faces_outwards(&turned), "{}", mesh.name);
        }
    }

    #[test]
    fn a_patch_ends_where_its_faces_do() {
        let cube = &shapes(1)[1];
        assert_eq!((cube.name, cube.faces.len()), ("cube", 12));
        assert!(cube.patch((0..12).collect()).rim.is_empty());
        let (_, sides) = cube.edges()[0];
        assert_eq!(cube.patch(sides.to_vec()).rim.len(), 4);
        for fan in cube.fans() {
            assert_eq!(cube.patch(fan.clone()).rim.len(), fan.len());
        }
    }
}
