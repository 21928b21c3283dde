use crate::engine::{CycleEngine, Engine, Handshake, NetlistEngine, Shown};
use crate::lockstep::DIFFERENCES_SHOWN;
use raypath_model::{Model, WordModel, Words};
use std::collections::VecDeque;

/// A kind of difference between netlist and models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Difference {
    /// The ports of the netlist differ from those of the cycle-exact model.
    Ports,
    /// The sink took an outcome that differs from that of the functional model.
    Answer,
}

/// An engine that compares a netlist with a cycle-exact and a functional model. It shows the ports of the netlist.
pub struct SideBySide<'n, F> {
    /// Messages about the first differences.
    pub differences: Vec<String>,
    netlist: &'n mut NetlistEngine,
    cycle_model: CycleEngine,
    functional: WordModel,
    /// The expected outcomes of the jobs that the netlist accepted, oldest first.
    in_flight: VecDeque<Words>,
    cycles: u64,
    jobs: u64,
    on_difference: F,
}

impl<'n, F: FnMut(Difference)> SideBySide<'n, F> {
    /// The netlist in its present state, with models after a reset. `on_difference` is called for each difference.
    pub fn new(netlist: &'n mut NetlistEngine, model: WordModel, on_difference: F) -> Self {
        Self {
            differences: Vec::new(),
            cycle_model: CycleEngine::new(model.clone(), netlist.shape()),
            netlist,
            functional: model,
            in_flight: VecDeque::new(),
            cycles: 0,
            jobs: 0,
            on_difference,
        }
    }

    fn differs(&mut self, difference: Difference, what: impl FnOnce() -> String) {
        (self.on_difference)(difference);
        if self.differences.len() < DIFFERENCES_SHOWN {
            self.differences.push(format!("cycle {}, job {}: {}", self.cycles, self.jobs, what()));
        }
    }

    fn compare_ports(&mut self, shown: &Shown, modelled: &Shown) {
        if shown != modelled {
            let words = || format!("the netlist shows {shown:?}, the cycle-exact model {modelled:?}");
            self.differs(Difference::Ports, words);
        }
        if let Some(outcome) = &shown.output {
            let improper = self.netlist.improper_outputs(outcome);
            if !improper.is_empty() {
                let words = || format!("the netlist shows {outcome:?}, but {}", improper.join(", "));
                self.differs(Difference::Ports, words);
            }
        }
    }
}

impl<F: FnMut(Difference)> Engine for SideBySide<'_, F> {
    fn present(&mut self, job: &Words) {
        self.netlist.present(job);
        self.cycle_model.present(job);
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let Handshake { input_ready, output_valid } = self.netlist.clock(input_valid, output_ready);
        let modelled = self.cycle_model.cycle(input_valid, output_ready);
        let same = modelled.input_ready == input_ready
            && modelled.output.is_some() == output_valid
            && modelled.output.as_ref().is_none_or(|outcome| self.netlist.shows(outcome));
        let shown = if same {
            modelled
        } else {
            let shown = Shown { input_ready, output: if output_valid { self.netlist.outcome() } else { None } };
            self.compare_ports(&shown, &modelled);
            shown
        };
        if let Some(outcome) = shown.output.as_ref().filter(|_| output_ready) {
            let expected = self.in_flight.pop_front();
            if expected.as_ref() != Some(outcome) {
                let words = || format!("the netlist answers {outcome:?}, the functional model {expected:?}");
                self.differs(Difference::Answer, words);
            }
            self.jobs += 1;
        }
        if let Some(job) = self.cycle_model.presented.as_ref().filter(|_| input_valid && input_ready) {
            self.in_flight.push_back(self.functional.run(job));
        }
        self.cycles += 1;
        shown
    }

    fn reset(&mut self) {
        self.netlist.reset();
        let shown = self.netlist.handshake();
        if shown != (Handshake { input_ready: true, output_valid: false }) {
            self.differs(Difference::Ports, || format!("in a reset the netlist shows {shown:?}"));
        }
        self.cycle_model.reset();
        self.functional.reset();
        self.in_flight.clear();
        self.cycles += 1;
    }
}
