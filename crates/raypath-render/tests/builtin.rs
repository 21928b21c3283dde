//! The built-in scene: closed bodies with outward faces.

use raypath_render::builtin;
use std::collections::HashMap;

#[test]
fn bodies_are_closed_and_face_outwards() {
    let mesh = builtin().unwrap();
    assert_eq!(mesh.triangles().len(), 119_168);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut bodies: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    for &[a, b, c] in mesh.triangles() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert_ne!(from, to);
            *edges.entry((from, to)).or_default() += 1;
            let (one, other) = (first(&mut bodies, from), first(&mut bodies, to));
            bodies[one.max(other) as usize] = one.min(other);
        }
    }
    for (&(from, to), &count) in &edges {
        assert_eq!((count, edges.get(&(to, from))), (1, Some(&1)), "edge from {from} to {to}");
    }
    let mut volumes: HashMap<u32, f64> = HashMap::new();
    for (index, corners) in (0..).zip(mesh.triangles()) {
        let [a, b, c] = mesh.corners(index).map(|corner| corner.map(f64::from));
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        let volume = (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)) / 6.0;
        *volumes.entry(first(&mut bodies, corners[0])).or_default() += volume;
    }
    // The ground, the knot, 28 spheres and the bumpy sphere.
    assert_eq!(volumes.len(), 31);
    assert!(volumes.values().all(|&volume| volume > 0.0), "{volumes:?}");
}

/// The representative of the body of a vertex, in the union-find structure `bodies`.
fn first(bodies: &mut [u32], mut vertex: u32) -> u32 {
    while bodies[vertex as usize] != vertex {
        bodies[vertex as usize] = bodies[bodies[vertex as usize] as usize];
        vertex = bodies[vertex as usize];
    }
    vertex
}
