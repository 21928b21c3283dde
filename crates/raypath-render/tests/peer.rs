//! Comparison with obvhs: an independent tree and triangle test.

use crate::common::meshes;
use crate::common::rays::{Kind, rays};
use raypath_render::compare::compare;
use raypath_render::{Scene, Stopped, Tracing};

#[test]
fn obvhs_hits_the_same() {
    for named in meshes::all() {
        let scene = Scene::new(named.mesh).unwrap();
        for kind in [Kind::Primary, Kind::Random] {
            let rays = rays(scene.mesh(), kind, 20_000, 8);
            let tracing = Tracing { two_sided: true, ..Tracing::default() };
            let comparison = compare(&scene, &rays, tracing, 1, &|_| true).unwrap();
            println!("{} {kind:?}: {comparison:?}", named.name);
            assert!(comparison.our_hits > 2_000);
            // The test of obvhs is not watertight and differs at edges.
            assert!(comparison.differences <= 4, "{}, {kind:?}: {comparison:?}", named.name);
        }
    }
}

#[test]
fn the_progress_callback_stops_comparisons() {
    let scene = Scene::new(meshes::real("teapot").mesh).unwrap();
    let rays = rays(scene.mesh(), Kind::Random, 10, 9);
    assert_eq!(compare(&scene, &rays, Tracing::default(), 5, &|done| done < 2), Err(Stopped));
}
