//! The traversal unit in a random scene with resets, whose inputs are unknown on channels that are not valid.

use super::Scenario;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::Module;
use raypath_rtl::Config;
use raypath_tools::KnownWord;
use raypath_traversal::traffic::{Behaviour, BlockScene, Environment, random_ray};
use raypath_traversal::{
    UnitEngine, UnitInputs, UnitModel, UnitNetlist, UnitOutputs, UnitParameters, outputs_of, words_of,
};
use raypath_verify::Error;
use std::sync::Arc;

const BEFORE: usize = 3;

/// A small unit.
pub fn unit() -> Result<UnitNetlist, Error> {
    let parameters = UnitParameters { contexts: 8, memory_width: 256, ..UnitParameters::default() };
    UnitNetlist::new(Config::DEFAULT, parameters).map_err(Error::subject)
}

/// The scenario of this unit, with so many rays.
pub fn scenario(rays: usize, seed: u64) -> Result<Scenario, Error> {
    let unit = unit()?;
    let parameters = unit.parameters;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (scene, root) = BlockScene::random_of(parameters.step.node, 8, &mut random);
    let rays = (0..rays).map(|_| random_ray(root, &mut random)).collect();
    let behaviour = Behaviour { latency: (1, 4), stalls: [20; 4], errors: 0 };
    let mut environment = Environment::new(&scene.0, parameters, rays, behaviour, seed);
    let mut recorder = Recorder::new(UnitModel::of(&unit), &unit.top);
    while !environment.is_done() {
        // In a reset, and while rays are inside.
        if [0, 1, 150].contains(&recorder.cycles.len()) {
            environment.reset(&mut [&mut recorder]);
        } else if let Err(problem) = environment.cycle(&mut [&mut recorder]) {
            unreachable!("the model breaks the protocol: {problem}");
        }
    }
    let Recorder { cycles, .. } = recorder;
    let mut before = vec![None; unit.top.inputs().len() + 1];
    before[0] = Some(1);
    let unknown = std::iter::repeat_n(before, BEFORE);
    let frames = unknown.chain(cycles.iter().map(|(frame, _)| frame.clone())).collect();
    let outcomes = cycles.iter().filter(|(_, outputs)| outputs.as_ref().is_some_and(|it| it.hit.is_some())).count();
    let check = move |number: usize, words: &[KnownWord]| {
        let (_, expected) = &cycles[number.checked_sub(BEFORE)?];
        // Outputs of channels that are not valid have no meaning, so both fillings must mean the same.
        let shown = [0, u64::MAX].map(|filling| {
            let words: Vec<u64> = words.iter().map(|word| word.unwrap_or(filling)).collect();
            format!("{:?}", outputs_of(&words))
        });
        match expected {
            _ if shown[0] != shown[1] => Some(format!("unknown outputs: {} or {}", shown[0], shown[1])),
            Some(expected) if format!("{expected:?}") != shown[0] => {
                Some(format!("shows {}, the cycle-exact model {expected:?}", shown[0]))
            }
            _ => None,
        }
    };
    Ok(Scenario { top: unit.top, frames, check: Box::new(check), outcomes: outcomes as u64 })
}

/// An engine whose cycles are recorded: inputs, and outputs except in a reset.
struct Recorder {
    engine: UnitModel,
    widths: Vec<u32>,
    cycles: Vec<(Vec<KnownWord>, Option<UnitOutputs>)>,
}

impl Recorder {
    fn new(engine: UnitModel, top: &Arc<Module>) -> Self {
        let widths = top.inputs().iter().map(|port| top.signal(port.signal).width).collect();
        Self { engine, widths, cycles: Vec::new() }
    }
}

impl UnitEngine for Recorder {
    fn outputs(&mut self) -> UnitOutputs {
        self.engine.outputs()
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        // Words of channels that are not valid depend on the filling.
        let [zeros, ones] = [0, u64::MAX].map(|filling| words_of(inputs, &self.widths, || filling));
        let known = zeros.iter().zip(&ones).map(|(zero, one)| (zero == one).then_some(*zero));
        let frame = std::iter::once(Some(1)).chain(known).collect();
        self.cycles.push((frame, Some(self.engine.outputs())));
        self.engine.cycle(inputs);
    }

    fn reset(&mut self) {
        let frame = std::iter::once(Some(0)).chain(self.widths.iter().map(|_| None)).collect();
        self.cycles.push((frame, None));
        self.engine.reset();
    }
}
