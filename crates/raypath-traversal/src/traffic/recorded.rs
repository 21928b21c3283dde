//! An engine whose cycles are recorded, so that the text of the unit can be driven with the same inputs.

use crate::{UnitEngine, UnitInputs, UnitOutputs, UnitPorts};
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use raypath_hdl::Module;

/// A cycle at the ports of a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedCycle {
    /// The words of `rst_ni` and of all inputs in the order of declaration: the frame that a Verilated unit takes.
    /// Inputs of channels that are not valid have random values.
    pub frame: Vec<u64>,
    /// The outputs; none in a reset.
    pub outputs: Option<UnitOutputs>,
}

/// An engine with its recorded cycles.
pub struct RecordedEngine<E> {
    /// The engine.
    pub engine: E,
    /// Its cycles so far, without those that were taken out.
    pub cycles: Vec<RecordedCycle>,
    ports: UnitPorts,
    random: ChaCha8Rng,
}

impl<E: UnitEngine> RecordedEngine<E> {
    /// Records the cycles of an engine for a unit with this top module.
    pub fn new(engine: E, top: &Module) -> Self {
        Self { engine, cycles: Vec::new(), ports: UnitPorts::of(top), random: ChaCha8Rng::seed_from_u64(9) }
    }
}

impl<E: UnitEngine> UnitEngine for RecordedEngine<E> {
    fn outputs(&mut self) -> UnitOutputs {
        self.engine.outputs()
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        let words = self.ports.words(inputs, || self.random.next_u64());
        let frame = [1].into_iter().chain(words).collect();
        self.cycles.push(RecordedCycle { frame, outputs: Some(self.engine.outputs()) });
        self.engine.cycle(inputs);
    }

    fn reset(&mut self) {
        let idle = self.ports.words(&UnitInputs::default(), || self.random.next_u64());
        self.cycles.push(RecordedCycle { frame: [0].into_iter().chain(idle).collect(), outputs: None });
        self.engine.reset();
    }
}
