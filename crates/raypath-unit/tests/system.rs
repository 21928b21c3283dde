//! The simulated system skips cycles in which nothing happens. That changes neither time nor replies.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_model::Shape;
use raypath_unit::system::{MemoryParameters, RayUser, simulate};
use raypath_unit::traffic::{BlockScene, random_ray};
use raypath_unit::{
    Memory, RayRequest, Reply, Response, UnitEngine, UnitInputs, UnitModel, UnitOutputs, UnitParameters,
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

/// Runs the unit in every cycle, with a memory that answers in order. Returns the replies.
fn every_cycle(
    unit: &mut UnitModel,
    beat_bytes: usize,
    scene: &[u8],
    mut user: List,
    latency: u64,
) -> Vec<(u64, Reply)> {
    let mut beats = VecDeque::new();
    let count = user.rays.len();
    let mut ray = user.next_ray();
    for now in 0.. {
        let UnitOutputs { ray_ready, hit, request, .. } = unit.outputs();
        let beat = beats.pop_front_if(|(due, _)| *due <= now);
        let response = beat.map(|(_, (tag, beat))| Response { tag, is_error: false, beat });
        unit.cycle(&UnitInputs { ray, hit_ready: true, request_ready: true, response });
        if ray_ready {
            ray = user.next_ray();
        }
        if let Some(request) = request {
            let block = scene.block(request.address, 128).expect("a block");
            beats.extend(block.chunks(beat_bytes).map(|beat| (now + latency, (request.tag, beat))));
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

#[test]
fn skipped_cycles_change_nothing() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let (scene, root) = BlockScene::random(200, &mut random);
    for (rays, contexts, memory_width, latency) in [(40, 8, 128, 300), (200, 64, 512, 1000), (100, 8, 1024, 57)] {
        let parameters = UnitParameters { contexts, memory_width, ..UnitParameters::default() };
        let rays = (0..rays).map(|number| (number, random_ray(root, &mut random))).collect();
        let mut user = List { rays, replies: Vec::new() };
        let again = List { rays: user.rays.clone(), replies: Vec::new() };
        let memory = MemoryParameters { latency, bandwidth: None, cache: None };
        let timing = simulate(&Shape::default(), parameters, &scene.0[..], &memory, &mut user);
        let mut unit = UnitModel::new(&Shape::default(), parameters);
        let replies = every_cycle(&mut unit, memory_width as usize / 8, &scene.0, again, latency);
        assert_eq!(timing.unit, unit.counts(), "{contexts} contexts, latency {latency}");
        assert_eq!(user.replies, replies, "{contexts} contexts, latency {latency}");
    }
}
