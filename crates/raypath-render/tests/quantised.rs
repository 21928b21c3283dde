//! Scenes with compressed nodes, compared with the same scenes with wide ones, and with those of obvhs.

use crate::common::meshes::{self, Named};
use crate::common::rays::{Kind, rays};
use raypath_model::Shape;
use raypath_ops::Rules;
use raypath_render::{Hit, PictureError, RayBatch, Scene, Tracing, UnitSystem, time_rays_through_unit, trace_closest};
use raypath_timing::Sample;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::system::SystemParameters;
use raypath_traversal::{StepParameters, UnitParameters};

fn bits(hits: &[Option<Hit>]) -> Vec<Option<(u32, [u32; 3], bool)>> {
    let bits = |hit: Hit| (hit.triangle, [hit.t, hit.t_num, hit.t_denom].map(f32::to_bits), hit.from_behind);
    hits.iter().map(|hit| hit.map(bits)).collect()
}

#[test]
fn hits_are_those_of_wide_nodes() {
    for Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let wide = scene.clone().through_unit().unwrap();
        let [quantised, wide8] =
            [NodeKind::Quantised, NodeKind::Wide8].map(|nodes| scene.clone().through_unit_of(nodes).unwrap());
        let size = |scene: &Scene| scene.blocks().unwrap().bytes().len();
        let (leaves, triangles) = (size(&quantised) / 64 - wide.bvh().nodes().len(), mesh.triangles().len());
        assert!(leaves < triangles, "{name}: {leaves} blocks with {triangles} triangles");
        assert!(size(&wide8) < size(&wide), "{name}: {} bytes, {} with wide nodes", size(&wide8), size(&wide));
        for two_sided in [false, true] {
            let tracing = Tracing { two_sided, rules: Rules::Paper };
            let (mut nodes, mut found) = ([0; 3], 0);
            for kind in Kind::ALL {
                let rays = rays(&mesh, kind, 2_000, 7);
                let (expected, counts) = trace_closest(&wide, &rays, tracing, &|_| true).unwrap();
                (nodes[0], found) = (nodes[0] + counts.nodes, found + expected.iter().flatten().count());
                for (scene, nodes) in [&quantised, &wide8].into_iter().zip(&mut nodes[1..]) {
                    let (hits, counts) = trace_closest(scene, &rays, tracing, &|_| true).unwrap();
                    assert!(bits(&hits) == bits(&expected), "{name}, {kind:?}, {tracing:?}");
                    *nodes += counts.nodes;
                }
            }
            assert!(found > 1000 && nodes[1] > nodes[0] + 100 && nodes[2] < nodes[0], "{name}: {found}, {nodes:?}");
        }
    }
}

/// The simulated unit has the hits of the functional model, and reads only a scene with its nodes.
#[test]
fn the_simulated_unit_reads_its_nodes() {
    let Named { mesh, .. } = meshes::real("suzanne");
    let rays = rays(&mesh, Kind::Primary, 300, 1);
    let scene = Scene::new(mesh).unwrap();
    let around = SystemParameters::of_latency(40);
    let step = StepParameters { node: NodeKind::Quantised, ..StepParameters::default() };
    let unit = UnitParameters { contexts: 8, step, ..UnitParameters::default() };
    let system = UnitSystem { shape: Shape::default(), unit, around, in_flight: 16 };
    let time = |scene: &Scene| {
        let batch = RayBatch { scene, rays: &rays, tracing: Tracing::default() };
        time_rays_through_unit(&batch, Sample::ALL, &system, &|_| true)
    };
    let quantised = scene.clone().through_unit_of(NodeKind::Quantised).unwrap();
    let (timing, hits) = time(&quantised).unwrap();
    let (expected, counts) = trace_closest(&quantised, &rays, Tracing::default(), &|_| true).unwrap();
    assert_eq!(bits(&hits), bits(&expected));
    let fetches = counts.nodes + counts.triangle / 2..counts.nodes + counts.triangle;
    assert!(fetches.contains(&timing.unit.fetches), "{} fetches, expected {fetches:?}", timing.unit.fetches);
    assert_eq!(timing.beats, timing.unit.fetches, "beats of 512 bits");

    let error = time(&scene.through_unit().unwrap()).err().unwrap();
    assert!(matches!(error, PictureError::Nodes { .. }));
    assert_eq!(error.to_string(), "the scene has wide4 nodes, expected quantised, which the unit reads");
}
