//! The simulated netlist of the unit returns what the functional model does, whatever the memory and the users of the
//! other channels do.

use crate::common::along_z;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::Rules;
use raypath_rtl::{Config, Control};
use raypath_tools::{Options, Sources, Verilated};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{
    Behaviour, BlockScene, Environment, RecordedCycle, Recorder, TwoLevelScene, random_ray,
};
use raypath_traversal::{
    NetlistEngine, RayRequest, Reply, StepParameters, Unit, UnitEngine, UnitFeatures, UnitInputs, UnitModel,
    UnitNetlist, UnitParameters, outputs_of,
};

/// All optional parts.
const EVERYTHING: UnitFeatures = UnitFeatures { barycentrics: true, instances: true };
const QUIET: Behaviour = Behaviour { latency: (1, 20), stalls: [0; 4], errors: 0 };

/// The replies of the functional model.
fn expected(scene: &BlockScene, rays: &[RayRequest], parameters: UnitParameters) -> Vec<Reply> {
    let mut model = Unit::new(Rules::Paper, parameters.step);
    rays.iter().map(|ray| model.trace(&scene.0[..], ray)).collect()
}

fn setting(triangles: u32, rays: usize, seed: u64) -> (BlockScene, Vec<RayRequest>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (scene, root) = BlockScene::random(triangles, &mut random);
    let rays = (0..rays).map(|_| random_ray(root, &mut random)).collect();
    (scene, rays)
}

#[test]
fn the_netlist_returns_what_the_functional_model_does() {
    let (scene, rays) = setting(300, 400, 1);
    let parameters = UnitParameters {
        contexts: 16,
        step: StepParameters { stack: 4, ..StepParameters::default() },
        ..UnitParameters::default()
    };
    let unit = UnitNetlist::new(Config::DEFAULT.control(Control::Credit), parameters).expect("a unit");
    let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
    let mut environment = Environment::new(&scene.0, parameters, rays.clone(), QUIET, 2);
    while !environment.is_done() {
        environment.cycle(&mut [&mut netlist]).expect("the protocol");
        assert!(environment.cycles() < 1_000_000, "{} of {} rays ended", environment.replies.len(), rays.len());
    }
    for (id, expected) in expected(&scene, &rays, parameters).into_iter().enumerate() {
        assert_eq!(environment.replies[&(id as u64)], expected, "ray {id}: {:?}", rays[id]);
    }
}

/// The cycle-exact model and the netlist, in lockstep, under every behaviour of the other channels.
#[test]
fn the_model_equals_the_netlist_in_every_cycle() {
    let (scene, rays) = setting(300, 250, 4);
    let slow = Behaviour { latency: (1, 500), stalls: [64; 4], errors: 200 };
    let blocked = Behaviour { latency: (1, 30), stalls: [10, 240, 200, 100], errors: 0 };
    let with_weights = StepParameters {
        features: UnitFeatures { barycentrics: true, ..UnitFeatures::OFF },
        ..StepParameters::default()
    };
    let parameters = [
        // More rays than ids.
        UnitParameters { contexts: 8, memory_width: 128, id_width: 3, divider_latency: 1, ..UnitParameters::default() },
        UnitParameters {
            contexts: 12,
            step: StepParameters { stack: 2, ..StepParameters::default() },
            id_width: 64,
            ..UnitParameters::default()
        },
        UnitParameters { contexts: 64, memory_width: 1024, divider_latency: 27, ..UnitParameters::default() },
        UnitParameters { contexts: 9, step: with_weights, divider_latency: 4, ..UnitParameters::default() },
    ];
    for (number, parameters) in (0..).zip(parameters) {
        for control in [Control::Skid, Control::Credit] {
            let unit = UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit");
            for (seed, behaviour) in (5..).zip([QUIET, slow, blocked]) {
                let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
                let mut model = UnitModel::of(&unit);
                let mut environment = Environment::new(&scene.0, parameters, rays.clone(), behaviour, seed + number);
                while !environment.is_done() {
                    environment.cycle(&mut [&mut netlist, &mut model]).expect("the protocol");
                    assert!(environment.cycles() < 1_000_000, "{} rays ended", environment.replies.len());
                }
                if behaviour.errors == 0 {
                    let replies: Vec<Reply> = environment.replies.values().copied().collect();
                    assert_eq!(replies, expected(&scene, &rays, parameters));
                }
            }
        }
    }
}

/// While no hit is taken, a unit accepts a ray for each context, and one more: a hit at the port has given its context
/// back.
#[test]
fn a_unit_accepts_one_ray_more_than_it_has_contexts() {
    for (contexts, features) in [(8, UnitFeatures::OFF), (11, EVERYTHING)] {
        let step = StepParameters { features, ..StepParameters::default() };
        let parameters = UnitParameters { contexts, step, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let (mut netlist, mut model) = (NetlistEngine::new(&unit).expect("a simulation"), UnitModel::of(&unit));
        let mut accepted = 0;
        for _ in 0..500 {
            let outputs = netlist.outputs();
            assert_eq!(outputs, model.outputs());
            accepted += u32::from(outputs.ray_ready);
            // The root is missing, so that a ray ends without a request.
            let ray = Some((u64::from(accepted), along_z(0)));
            let inputs = UnitInputs { ray, ..UnitInputs::default() };
            netlist.cycle(&inputs);
            model.cycle(&inputs);
        }
        assert_eq!(accepted, contexts + 1);
    }
}

/// The same for scenes with instances, some of which no ray can enter.
#[test]
fn the_model_equals_the_netlist_in_every_cycle_with_instances() {
    let slow = Behaviour { latency: (1, 200), stalls: [64; 4], errors: 100 };
    let parameters = |contexts, stack, memory_width, divider_latency| {
        let features = UnitFeatures { instances: true, ..UnitFeatures::OFF };
        let step = StepParameters { stack, features, ..StepParameters::default() };
        UnitParameters { contexts, step, memory_width, divider_latency, ..UnitParameters::default() }
    };
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let (mut entered, mut failed) = (0, 0);
    for (control, parameters) in
        [(Control::Skid, parameters(8, 2, 128, 1)), (Control::Credit, parameters(64, 8, 1024, 11))]
    {
        let unit = UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit");
        for behaviour in [QUIET, slow] {
            let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(20, true, &mut random);
            let rays: Vec<RayRequest> = (0..200).map(|_| random_ray(root, &mut random)).collect();
            let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
            let mut model = UnitModel::of(&unit);
            let mut environment = Environment::new(&blocks.0, parameters, rays.clone(), behaviour, 3);
            while !environment.is_done() {
                environment.cycle(&mut [&mut netlist, &mut model]).expect("the protocol");
                assert!(environment.cycles() < 1_000_000, "{} rays ended", environment.replies.len());
            }
            entered += model.counts().transforms / 2;
            if behaviour.errors == 0 {
                let replies: Vec<Reply> = environment.replies.values().copied().collect();
                failed += replies.iter().filter(|reply| reply.status == status::ERROR).count();
                assert_eq!(replies, expected(&blocks, &rays, parameters));
            }
        }
    }
    assert!(entered > 500 && failed > 20, "{entered} instances were entered, {failed} rays failed");
}

/// The frames that drove the netlist, with two resets while rays are inside, drive Verilator, which begins with random
/// values in registers and memories and without a reset. No assertion fails.
#[test]
fn verilator_equals_the_netlist_in_every_cycle() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(16, true, &mut random);
    let rays: Vec<RayRequest> = (0..60).map(|_| random_ray(root, &mut random)).collect();
    let step = StepParameters { features: EVERYTHING, ..StepParameters::default() };
    let parameters = UnitParameters { contexts: 8, memory_width: 256, step, ..UnitParameters::default() };
    verilator_equals_the_netlist(&blocks, rays, parameters);
}

/// Without anything that a unit may have.
#[test]
#[ignore = "long: another build by Verilator"]
fn verilator_equals_the_plain_netlist_in_every_cycle() {
    let (scene, rays) = setting(200, 60, 3);
    let parameters = UnitParameters { contexts: 8, memory_width: 256, ..UnitParameters::default() };
    verilator_equals_the_netlist(&scene, rays, parameters);
}

/// Cycles of resets.
const RESETS: [usize; 2] = [300, 900];

fn verilator_equals_the_netlist(scene: &BlockScene, rays: Vec<RayRequest>, parameters: UnitParameters) {
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&unit.top, folder.path()).expect("sources");
    sources.lint().expect("no report of the linters");
    sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
    let options = Options::default();
    let verilated = Verilated::build_sources(&sources.files, &unit.top, folder.path(), &options).expect("a build");
    let mut recorded = Recorder::new(NetlistEngine::new(&unit).expect("a simulation"), &unit.top);
    let mut environment = Environment::new(&scene.0, parameters, rays, QUIET, 2);
    while !environment.is_done() {
        if RESETS.contains(&recorded.cycles.len()) {
            environment.reset(&mut [&mut recorded]);
        }
        environment.cycle(&mut [&mut recorded]).expect("the protocol");
    }
    // Before the first reset everything is unknown, as are the inputs.
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let words = recorded.cycles[0].frame.len() - 1;
    let before = (0..20).map(|cycle| {
        let frame = [u64::from(cycle < 17)].into_iter().chain((0..words).map(|_| random.random())).collect();
        RecordedCycle { frame, outputs: None }
    });
    let cycles = before.chain(recorded.cycles).map(|cycle| (cycle.frame, cycle.outputs));
    let (frames, outputs): (Vec<_>, Vec<_>) = cycles.unzip();
    let mut seen = 0;
    verilated
        .run_from_power_up(1, frames, |cycle, found| {
            // In a reset no output is expected.
            if let Some(expected) = &outputs[cycle] {
                assert_eq!(outputs_of(found), *expected, "cycle {cycle}");
            }
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, outputs.len());
}
