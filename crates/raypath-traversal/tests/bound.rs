//! The bound on the cycles of a ray: see "The traversal unit" in `docs/development/verification.md`.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::Rules;
use raypath_rtl::Config;
use raypath_traversal::traffic::{Behaviour, BlockScene, Environment, TwoLevelScene, random_ray};
use raypath_traversal::{NetlistEngine, Reply, StepParameters, Unit, UnitFeatures, UnitNetlist, UnitParameters};

/// The bound for a memory that takes a request in every cycle and returns a beat in every cycle in which one is due.
fn bound(unit: &UnitNetlist, reply: &Reply, latency: u64) -> u64 {
    let UnitParameters { contexts, memory_width, divider_latency, step, .. } = unit.parameters;
    let (contexts, beats) = (u64::from(contexts), u64::from(1024 / memory_width));
    let (datapath, divider) = (u64::from(unit.datapath.latency()), u64::from(divider_latency));
    let waiting = 5 * contexts + 3;
    let memory = contexts + 2 + latency + contexts * beats;
    // The second job of an instance waits for up to two turns of the set-up, the first does not wait.
    let in_datapath = match unit.parameters.step.features.instances {
        true => 6 * 2 * datapath + 6,
        false => 5 * 2 * datapath,
    };
    let jobs = 15 * contexts + 2 + in_datapath + 5 * (divider + 4);
    let answers = 1 + 5 * u64::from(reply.nodes) + u64::from(reply.triangles);
    let entry = 5 + divider + 6 + 2;
    let weights = if step.features.barycentrics { 2 * contexts + divider + 2 } else { 0 };
    entry + (answers + 1) * (waiting + memory + jobs) + weights + contexts + 3
}

#[test]
fn every_ray_ends_within_the_bound() {
    let mut tightest = f64::INFINITY;
    let settings = [
        (8, 128, 1, false),
        (8, 1024, 200, false),
        (64, 512, 20, true),
        (64, 512, 20, false),
        (64, 128, 1, false),
        (16, 256, 500, false),
        (32, 1024, 2, true),
    ];
    for (number, (contexts, memory_width, latency, instances)) in settings.into_iter().enumerate() {
        let features = UnitFeatures { barycentrics: number % 2 == 1, instances, ..UnitFeatures::OFF };
        let step = StepParameters { stack: 2, features, ..StepParameters::default() };
        let parameters = UnitParameters { contexts, memory_width, step, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let mut random = ChaCha8Rng::seed_from_u64(number as u64);
        let (scene, root) = if instances {
            let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(step.node, 40, false, &mut random);
            (blocks, root)
        } else {
            BlockScene::random(random.random_range(10..200), &mut random)
        };
        let rays: Vec<_> = (0..200).map(|_| random_ray(root, &mut random)).collect();
        let mut model = Unit::new(Rules::Paper, step);
        let expected: Vec<Reply> = rays.iter().map(|ray| model.trace(&scene.0[..], ray)).collect();
        let behaviour = Behaviour { latency: (1, latency), stalls: [0; 4], errors: 0 };
        let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
        let mut environment = Environment::new(&scene.0, parameters, rays, behaviour, 5);
        while !environment.is_done() {
            environment.cycle(&mut [&mut netlist]).expect("the protocol");
            assert!(environment.cycles() < 2_000_000, "{} rays ended", environment.replies.len());
        }
        for (&id, &cycles) in environment.latencies() {
            let bound = bound(&unit, &expected[id as usize], latency);
            assert!(cycles <= bound, "ray {id}: {cycles} cycles, at most {bound}");
            tightest = tightest.min(bound as f64 / cycles as f64);
        }
    }
    // The bound says something: some ray takes a twentieth of it.
    assert!(tightest < 20.0, "the bound is {tightest} times the cycles of any ray");
}
