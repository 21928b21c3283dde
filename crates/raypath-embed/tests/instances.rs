//! Rays through scenes of two levels: the hits of the functional model of `raypath-traversal`, by both models of this
//! interface.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_embed::{Unit, UnitHit, UnitRay};
use raypath_traversal::state::NO_INSTANCE;
use raypath_traversal::system::SystemParameters;
use raypath_traversal::traffic::{TwoLevelScene, random_ray};
use raypath_traversal::{HitInstance, RayRequest, Unit as Functional};

const MEMORY: SystemParameters = SystemParameters::of_latency(30);

#[test]
fn hits_have_the_instances_of_the_functional_model() {
    let unit =
        Unit::open("preset = \"compact\"\ncontexts = 8\nbarycentrics = true\ninstances = true\nqueries = \"flags\"")
            .expect("a unit");
    let mut functional = Functional::new(unit.config().semantics.rules, unit.parameters().step);
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut count = [0; 3];
    for number in 0..20 {
        let scene = TwoLevelScene::random(raypath_traversal::blocks::NodeKind::Wide4, 6, number % 4 == 3, &mut random);
        let mut blocks = scene.blocks;
        let root = blocks.give_geometries(scene.root, unit.parameters().step.features.queries, &mut random);
        let memory = &blocks.0[..];
        let rays: Vec<UnitRay> = (0..200).map(|_| of(&random_ray(root, &mut random))).collect();
        let (mut hits, mut timed) = (vec![UnitHit::default(); 200], vec![UnitHit::default(); 200]);
        unit.trace(memory, &rays, &mut hits).expect("hits");
        unit.simulate(memory, &rays, &MEMORY, &mut timed, &|_| true).expect("the same hits");
        let words = |hits: &[UnitHit]| format!("{hits:?}");
        assert_eq!(words(&timed), words(&hits), "scene {number}");
        for (ray, hit) in rays.iter().zip(&hits) {
            let reply = functional.trace(memory, &ray.into());
            assert_eq!((hit.status, hit.nodes, hit.triangles), (reply.status, reply.nodes, reply.triangles));
            let Some(expected) = reply.hit else {
                assert_eq!(*hit, UnitHit { status: hit.status, nodes: hit.nodes, triangles: hit.triangles, ..NOTHING });
                continue;
            };
            let none = HitInstance { index: NO_INSTANCE, ..HitInstance::default() };
            let HitInstance { index, custom_index, shader_offset } = expected.instance.unwrap_or(none);
            assert_eq!([hit.instance, hit.custom_index, hit.shader_offset], [index, custom_index, shader_offset]);
            assert_eq!((hit.primitive, hit.geometry), (expected.primitive, expected.geometry));
            assert_eq!(hit.back_face == 1, expected.back_face);
            let numbers = [hit.t, hit.t_num, hit.t_denom, hit.u, hit.v];
            let [u, v] = expected.barycentric.expect("the feature");
            let expected = [expected.t, expected.t_num, expected.t_denom, u, v];
            assert_eq!(numbers.map(f32::to_bits), expected.map(f32::to_bits));
            count[usize::from(hit.instance == NO_INSTANCE)] += 1;
            count[2] += usize::from(hit.instance == 5);
        }
    }
    assert!(count.iter().all(|&hits| hits > 20), "in instances, in none, in the last: {count:?}");
}

const NOTHING: UnitHit = UnitHit {
    status: 0,
    primitive: 0,
    instance: 0,
    t: 0.0,
    t_num: 0.0,
    t_denom: 0.0,
    u: 0.0,
    v: 0.0,
    back_face: 0,
    nodes: 0,
    triangles: 0,
    geometry: 0,
    custom_index: 0,
    shader_offset: 0,
};

fn of(ray: &RayRequest) -> UnitRay {
    let &RayRequest { origin, direction, t_min, t_max, flags, cull_mask, root, base } = ray;
    UnitRay { origin, direction, t_min, t_max, flags, cull_mask: cull_mask.into(), root, base }
}

#[test]
fn parameters_that_do_not_fit_are_refused() {
    for (toml, words) in [
        ("nested-instances = true", "configuration:1: nested-instances: 'true': instances is false, expected true"),
        ("node = \"quantised\"\nmemory-width = 1024", "memory width is 1024, expected 128, 256 or 512 with quantised"),
        ("instances = 1", "configuration:1: instances: '1', expected true or false"),
    ] {
        let problem = Unit::open(toml).expect_err("an error").to_string();
        assert!(problem.contains(words), "{problem}");
    }
}
