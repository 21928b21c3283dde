//! The simulated system, compared with the unit at its ports.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_model::Shape;
use raypath_ops::EdgeRule;
use raypath_traversal::blocks::{NODE_KIND, NodeKind};
use raypath_traversal::state::status;
use raypath_traversal::system::{RayUser, SystemParameters, simulate};
use raypath_traversal::traffic::{BlockScene, TwoLevelScene, random_ray};
use raypath_traversal::{
    Memory, Queries, RayRequest, Reply, Response, StepParameters, UnitEngine, UnitFeatures, UnitInputs, UnitModel,
    UnitOutputs, UnitParameters, Verdict,
};
use std::collections::VecDeque;

/// Rays that wait, and the replies that arrived.
struct List {
    rays: VecDeque<(u64, RayRequest)>,
    replies: Vec<(u64, Reply)>,
}

impl RayUser for List {
    fn next_ray(&mut self) -> Option<(u64, RayRequest)> {
        self.rays.pop_front()
    }

    fn receive(&mut self, number: u64, reply: &Reply) -> bool {
        self.replies.push((number, *reply));
        true
    }
}

/// Runs the unit by its ports in every cycle, with a memory that answers in order. Returns the replies.
fn every_cycle(
    unit: &mut UnitModel,
    parameters: UnitParameters,
    scene: &[u8],
    mut user: List,
    latency: u64,
) -> Vec<(u64, Reply)> {
    let mut beats = VecDeque::new();
    let block_bytes = parameters.step.node.block_bytes();
    let nothing = vec![0; block_bytes as usize];
    let count = user.rays.len();
    let mut ray = user.next_ray();
    let mut decided = None;
    for now in 0.. {
        let UnitOutputs { ray_ready, hit, request, candidate, .. } = unit.outputs();
        let beat = beats.pop_front_if(|(due, _)| *due <= now);
        let response = beat.map(|(_, response)| response);
        let verdict = decided.take();
        let (ready, flush) = (true, false);
        unit.cycle(&UnitInputs {
            flush,
            ray,
            hit_ready: ready,
            candidate_ready: ready,
            verdict,
            request_ready: ready,
            response,
            ..UnitInputs::default()
        });
        decided = candidate.map(|asked| (asked.tag, Verdict::without_shaders(&asked.candidate)));
        if ray_ready {
            ray = user.next_ray();
        }
        if let Some(request) = request {
            let block = scene.block(request.address, block_bytes);
            let is_error = block.is_err();
            let chunks = block.unwrap_or(&nothing).chunks(parameters.memory_width as usize / 8);
            beats.extend(chunks.map(|beat| (now + latency, Response { tag: request.tag, is_error, beat })));
        }
        if let Some((number, reply)) = hit {
            user.receive(number, &reply);
        }
        if user.replies.len() == count {
            break;
        }
    }
    user.replies
}

/// A simulation computes rays before their blocks arrive and skips cycles in which nothing happens. That changes
/// neither time nor replies: with each kind of nodes, with optional parts, and for rays whose root is not in memory.
#[test]
fn simulations_equal_the_unit_at_its_ports() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let none = UnitFeatures::OFF;
    let (wide, quantised) = (NodeKind::Wide4, NodeKind::Quantised);
    for (rays, contexts, memory_width, latency, node, features) in [
        (40, 8, 128, 300, wide, none),
        (200, 64, 512, 1000, wide, none),
        (100, 8, 1024, 57, wide, none),
        (100, 16, 256, 40, quantised, none),
        (100, 16, 512, 40, quantised, UnitFeatures { instances: true, ..none }),
        (
            100,
            16,
            512,
            40,
            wide,
            UnitFeatures {
                instances: true,
                barycentrics: true,
                edges: EdgeRule::Once,
                nested: true,
                queries: Queries::Full,
            },
        ),
        (100, 16, 128, 40, quantised, UnitFeatures { barycentrics: true, ..none }),
    ] {
        let (mut blocks, root) = if features.instances {
            let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(node, 20, false, &mut random);
            (blocks, root)
        } else {
            BlockScene::random_of(node, 200, &mut random)
        };
        let step = StepParameters { node, features, ..StepParameters::default() };
        let parameters = UnitParameters { contexts, memory_width, step, ..UnitParameters::default() };
        let root = blocks.give_geometries(root, features.queries, &mut random);
        let BlockScene(scene, _) = blocks;
        let mut ray = |number| {
            let root = if number % 8 == 5 { 1 << 30 | NODE_KIND } else { root };
            (number, random_ray(root, &mut random))
        };
        let rays = (0..rays).map(&mut ray).collect();
        let mut user = List { rays, replies: Vec::new() };
        let again = List { rays: user.rays.clone(), replies: Vec::new() };
        let memory = SystemParameters::of_latency(latency);
        let timing = simulate(&Shape::default(), parameters, &scene[..], &memory, &mut user);
        let mut unit = UnitModel::new(&Shape::default(), parameters);
        let replies = every_cycle(&mut unit, parameters, &scene, again, latency);
        assert_eq!(timing.unit, unit.counts(), "{parameters}, latency {latency}");
        assert_eq!(user.replies, replies, "{parameters}, latency {latency}");
        let with = |wanted| replies.iter().filter(|(_, reply)| reply.status == wanted).count();
        let ends = [status::HIT, status::MISS, status::MEMORY].map(with);
        assert!(ends.into_iter().all(|count| count > 0), "{parameters}: {ends:?}");
        assert_eq!(timing.unit.transforms > 0, features.instances);
    }
}
