//! The modules of a step equal the function over native numbers, in our simulator and in Verilator, for states on the
//! way of rays and for random ones.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Module, Simulator, Wire};
use raypath_ops::{Binary32, Port, from_words, ports_of, to_words};
use raypath_tools::{Sources, Verilated};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::state::{Answer, Group, RayState};
use raypath_traversal::{StepParameters, UnitFeatures, finish_module, prepare_module, step};
use std::sync::Arc;

/// Both halves of a step, one after the other: inputs `state_…_i`, `answer_…_i`, `top_…_i`, outputs `next_…_o`,
/// `request_…_o`.
fn step_module(parameters: StepParameters) -> Arc<Module> {
    let m = Builder::new("raypath_unit_step");
    let (prepare, finish) =
        (prepare_module(parameters.features).expect("a half"), finish_module(parameters).expect("a half"));
    let input = |name: &str, module: &Module| m.input(name, module.port_width(name).expect("a port"));
    let given: Vec<(&str, Wire<'_>)> =
        prepare.inputs().iter().map(|port| (port.name.as_str(), input(&port.name, &prepare))).collect();
    let half = m.instance("u_prepare", &prepare, &given);
    let names = prepare.outputs().iter().map(|port| format!("{}_i", port.name.trim_end_matches("_o")));
    let half: Vec<(String, Wire<'_>)> = names.zip(half).collect();
    let of_half = |name: &str| half.iter().find(|(known, _)| known == name).map(|(_, wire)| *wire);
    let given: Vec<(&str, Wire<'_>)> = finish
        .inputs()
        .iter()
        .map(|port| (port.name.as_str(), of_half(&port.name).unwrap_or_else(|| input(&port.name, &finish))))
        .collect();
    let outputs = m.instance("u_finish", &finish, &given);
    finish.outputs().iter().zip(outputs).for_each(|(port, wire)| m.output(&port.name, wire));
    m.finish().expect("a module")
}

/// The words of a random state and answer. Small values are likely, so that fields meet.
fn stimulus(ports: &[Port], random: &mut ChaCha8Rng) -> Vec<u64> {
    const NUMBERS: [f32; 8] = [0.0, -0.0, 1.0, 2.5, f32::INFINITY, f32::NAN, f32::MIN_POSITIVE, -3.0];
    let word = |port: &Port, random: &mut ChaCha8Rng| match port.width {
        None if random.random_range(0..4) > 0 => NUMBERS[random.random_range(0..NUMBERS.len())].to_bits().into(),
        None => u64::from(random.random::<u32>()),
        Some(width) => {
            let all = u64::MAX >> (64 - width);
            let value = match random.random_range(0..4) {
                0 => random.random::<u64>(),
                1 => random.random_range(0..9),
                2 => 0x80 | random.random_range(0..40) | random.random::<u64>() << 7,
                _ => 1 << random.random_range(0..width),
            };
            value & all
        }
    };
    ports.iter().map(|port| word(port, random)).collect()
}

/// The function, from the words of the inputs to those of the outputs.
fn expected(parameters: StepParameters, inputs: &[u64]) -> Vec<u64> {
    let (states, answers) = (ports_of::<RayState<Binary32>>().len(), ports_of::<Answer<Binary32>>().len());
    let state: RayState<Binary32> = from_words(Binary32, &inputs[..states]);
    let answer: Answer<Binary32> = from_words(Binary32, &inputs[states..states + answers]);
    let top: Group<Binary32> = from_words(Binary32, &inputs[states + answers..]);
    let (next, request) = step(Binary32, parameters, state, answer, top);
    let (mut words, mut more) = (Vec::new(), Vec::new());
    to_words(&next, &mut words);
    to_words(&request, &mut more);
    words.extend(more);
    words
}

/// All fields of the function are ports of the module.
const ALL: UnitFeatures = UnitFeatures { barycentrics: true, instances: true };

/// Stimuli, and what the function makes of each: random ones, and walks in which the next state comes from the last.
fn cases(parameters: StepParameters, count: usize) -> Vec<(Vec<u64>, Vec<u64>)> {
    let states = ports_of::<RayState<Binary32>>();
    let answers: Vec<Port> = ports_of::<Answer<Binary32>>().into_iter().chain(ports_of::<Group<Binary32>>()).collect();
    let mut random = ChaCha8Rng::seed_from_u64(parameters.stack.into());
    let mut inputs: Vec<u64> = Vec::new();
    let mut cases = Vec::new();
    for case in 0..count {
        if case % 16 == 0 || inputs.is_empty() {
            inputs = stimulus(&states, &mut random);
        }
        inputs.truncate(states.len());
        inputs.extend(stimulus(&answers, &mut random));
        let outputs = expected(parameters, &inputs);
        let next = outputs[..states.len()].to_vec();
        cases.push((std::mem::replace(&mut inputs, next), outputs));
    }
    cases
}

#[test]
fn the_simulated_module_equals_the_function() {
    for stack in [2, 4, 8, 16, 32] {
        let node = if stack == 4 { NodeKind::Quantised } else { NodeKind::Wide4 };
        let parameters = StepParameters { stack, node, features: ALL };
        let module = step_module(parameters);
        let mut simulator = Simulator::new(&module).expect("a simulator");
        let inputs: Vec<_> = module.inputs().iter().map(|port| simulator.input(&port.name).expect("a port")).collect();
        let outputs: Vec<_> =
            module.outputs().iter().map(|port| simulator.output(&port.name).expect("a port")).collect();
        let mut kinds = [0; 3];
        for (given, expected) in cases(parameters, 40_000) {
            inputs.iter().zip(&given).for_each(|(&input, &word)| simulator.set(input, word));
            simulator.settle();
            let found: Vec<u64> = outputs.iter().map(|&output| simulator.get(output)).collect();
            assert_eq!(found, expected, "{}", described(&module, &given, &found, &expected));
            let kind = module.outputs().iter().position(|port| port.name == "request_kind_o").expect("a port");
            kinds[expected[kind] as usize] += 1;
        }
        assert!(kinds.iter().all(|&count| count > 500), "each kind of request occurs: {kinds:?}");
    }
}

#[test]
fn verilator_equals_the_function() {
    let parameters = StepParameters { features: ALL, ..StepParameters::default() };
    let module = step_module(parameters);
    let folder = tempfile::tempdir().expect("a folder");
    Sources::write(&module, folder.path()).expect("sources").lint().expect("no report of the linters");
    let verilated = Verilated::build(&module, folder.path()).expect("a build");
    let (inputs, expected): (Vec<_>, Vec<_>) = cases(parameters, 20_000).into_iter().unzip();
    let mut seen = 0;
    verilated
        .run(inputs, |case, found| {
            assert_eq!(found, expected[case], "case {case}");
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, 20_000);
}

fn described(module: &Module, given: &[u64], found: &[u64], expected: &[u64]) -> String {
    let inputs = module.inputs().iter().zip(given).map(|(port, word)| format!("{} {word:#x}", port.name));
    let outputs = module.outputs().iter().zip(found.iter().zip(expected));
    let wrong = outputs
        .filter(|(_, (found, expected))| found != expected)
        .map(|(port, (found, expected))| format!("{} is {found:#x}, expected {expected:#x}", port.name));
    format!("{}\n{}", inputs.collect::<Vec<_>>().join(" "), wrong.collect::<Vec<_>>().join("\n"))
}
