//! The scene that is made by code is what it says.

use raypath_render::builtin;
use std::collections::HashMap;

#[test]
fn bodies_are_closed_and_turned_outwards() {
    let mesh = builtin().unwrap();
    assert_eq!(mesh.triangles().len(), 92_288);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut volume = 0.0;
    for (index, &[a, b, c]) in mesh.triangles().iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert_ne!(from, to);
            *edges.entry((from, to)).or_default() += 1;
        }
        let [a, b, c] = mesh.corners(index as u32).map(|corner| corner.map(f64::from));
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))
            / 6.0;
    }
    for (&(from, to), &count) in &edges {
        assert_eq!((count, edges.get(&(to, from))), (1, Some(&1)), "edge from {from} to {to}");
    }
    // The ground alone, a disc of radius 4.2 and height 0.5, is 27.7.
    assert!(volume > 30.0, "{volume}");
}
