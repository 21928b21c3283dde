//! Checks of modules with data, each by itself: with states that episodes do not reach, or seldom. The other
//! modules have none, because their properties say all that they must do.

mod decoder;
mod distance;
mod hits;
mod set_up;
mod steps;
mod window;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Error, InputPort, Module, OutputPort, Simulator};
use raypath_traversal::UnitParameters;
use std::sync::Arc;

/// The cycles of a module with registers.
const CYCLES: usize = 20_000;

/// Runs a module beside what it must do. Modules without a check of their own pass.
///
/// # Errors
/// What is wrong; the module cannot be compiled.
pub fn check(module: &Arc<Module>, parameters: UnitParameters, seed: u64) -> Result<Result<(), String>, Error> {
    let Some(check) = check_of(module) else { return Ok(Ok(())) };
    let found = check(&mut Bench::new(module, seed)?, parameters);
    Ok(found.map_err(|problem| format!("{} by itself, {parameters:?}: {problem}", module.name())))
}

/// Whether a module has a check of its own.
pub fn has_check(module: &Module) -> bool {
    check_of(module).is_some()
}

/// A check of a module in a unit with these parameters.
type Check = fn(&mut Bench, UnitParameters) -> Result<(), String>;

fn check_of(module: &Module) -> Option<Check> {
    let check: Check = match module.name() {
        "raypath_unit_prepare" => |bench, unit| steps::prepare(bench, unit.step),
        "raypath_unit_finish" => |bench, unit| steps::finish(bench, unit.step),
        "raypath_unit_set_up" | "raypath_unit_entries" => |bench, unit| set_up::run(bench, unit.divider_latency),
        "raypath_unit_decoder" => |bench, unit| decoder::run(bench, unit.step.node),
        "raypath_unit_distance" => |bench, _| distance::run(bench),
        "raypath_unit_hits" => |bench, unit| hits::run(bench, unit),
        "raypath_unit_window" => |bench, _| window::run(bench),
        _ => return None,
    };
    Some(check)
}

/// A simulated module, and random values for it.
struct Bench {
    module: Arc<Module>,
    simulator: Simulator,
    inputs: Vec<(InputPort, u32)>,
    outputs: Vec<OutputPort>,
    random: ChaCha8Rng,
}

impl Bench {
    fn new(module: &Arc<Module>, seed: u64) -> Result<Self, Error> {
        let mut simulator = Simulator::new(module)?;
        simulator.restart_randomly(seed);
        let inputs = module.inputs().iter().map(|port| {
            let width = module.port_width(&port.name).unwrap_or(1);
            Ok::<_, Error>((simulator.input(&port.name)?, width))
        });
        let inputs = inputs.collect::<Result<_, _>>()?;
        let outputs = module.outputs().iter().map(|port| simulator.output(&port.name)).collect::<Result<_, _>>()?;
        Ok(Self { module: module.clone(), simulator, inputs, outputs, random: ChaCha8Rng::seed_from_u64(seed) })
    }

    /// The places of these inputs among all.
    fn inputs<const N: usize>(&self, names: [&str; N]) -> [usize; N] {
        names.map(|name| self.input(name).unwrap_or_default())
    }

    /// The places of these outputs among all.
    fn outputs<const N: usize>(&self, names: [&str; N]) -> [usize; N] {
        names.map(|name| self.output(name).unwrap_or_default())
    }

    fn input(&self, name: &str) -> Option<usize> {
        self.module.inputs().iter().position(|port| port.name == name)
    }

    fn output(&self, name: &str) -> Option<usize> {
        self.module.outputs().iter().position(|port| port.name == name)
    }

    fn set(&mut self, input: usize, value: u64) {
        self.simulator.set(self.inputs[input].0, value);
    }

    fn get(&self, output: usize) -> u64 {
        self.simulator.get(self.outputs[output])
    }

    fn chance(&mut self, one_in: u32) -> bool {
        self.random.random_range(0..one_in) == 0
    }

    /// Random words for all inputs. Words meet earlier ones, or differ from them in a bit, and many are at a limit.
    fn words(&mut self) -> Vec<u64> {
        let mut words: Vec<u64> = Vec::with_capacity(self.inputs.len());
        for place in 0..self.inputs.len() {
            let width = self.inputs[place].1;
            let alike: Vec<usize> = (0..place).filter(|&other| self.inputs[other].1 == width).collect();
            let random = &mut self.random;
            let near = |random: &mut ChaCha8Rng, value: u64| match random.random_range(0..5) {
                0 => value ^ 1 << random.random_range(0..width),
                1 => value.wrapping_add(1),
                2 => value.wrapping_sub(1),
                _ => value,
            };
            let value = match random.random_range(0..8) {
                0 => random.random(),
                1 => random.random_range(0..9),
                2 | 3 if !alike.is_empty() => {
                    let other = words[alike[random.random_range(0..alike.len())]];
                    near(random, other)
                }
                4 if width == 32 => random.random::<u64>() << 7 | random.random_range(0..70),
                5 if width == 32 => f32::to_bits(NUMBERS[random.random_range(0..NUMBERS.len())]).into(),
                6 => 0,
                _ => {
                    let limit = 1 << random.random_range(0..width);
                    near(random, limit)
                }
            };
            words.push(value & u64::MAX >> (64 - width));
        }
        words
    }
}

/// A number: often one at a limit, or any bits.
fn number(random: &mut ChaCha8Rng) -> f32 {
    match random.random_range(0..4) {
        0 => NUMBERS[random.random_range(0..NUMBERS.len())],
        1 => f32::from_bits(random.random()),
        _ => random.random_range(-2.0..9.0),
    }
}

/// Numbers at the limits of the format and between.
const NUMBERS: [f32; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    2.5,
    f32::from_bits(1),
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::from_bits(f32::INFINITY.to_bits() + 1),
    f32::from_bits(f32::NEG_INFINITY.to_bits() + 1),
    f32::MIN_POSITIVE,
    f32::MAX,
];
