//! What the documents promise about the unit's state: no output depends on an input of the same cycle, and after a
//! reset nothing depends on what registers and memories had before.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Simulator, depends_combinationally};
use raypath_rtl::{Config, Control};
use raypath_traversal::traffic::{Behaviour, Environment, TwoLevelScene, random_ray};
use raypath_traversal::{
    StepParameters, UnitEngine, UnitFeatures, UnitInputs, UnitNetlist, UnitOutputs, UnitParameters, outputs_of,
    words_of,
};

fn unit(control: Control) -> UnitNetlist {
    // With all that a unit can have.
    let step =
        StepParameters { features: UnitFeatures { barycentrics: true, instances: true }, ..StepParameters::default() };
    let parameters = UnitParameters { contexts: 8, memory_width: 256, step, ..UnitParameters::default() };
    UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit")
}

#[test]
fn no_output_depends_on_an_input_of_its_cycle() {
    for control in [Control::Skid, Control::Credit] {
        let top = unit(control).top;
        let handshakes = top.inputs().iter().filter(|port| !port.name.contains("_data_"));
        for input in handshakes {
            for output in top.outputs().iter().filter(|port| port.name != "mem_rsp_ready_o") {
                let depends = depends_combinationally(&top, &output.name, &input.name).expect("a netlist");
                assert!(!depends, "{} depends on {}", output.name, input.name);
            }
        }
    }
}

/// A simulation whose registers and memories begin with random contents, after a reset.
struct Unknown {
    simulator: Simulator,
    widths: Vec<u32>,
}

impl Unknown {
    fn new(unit: &UnitNetlist, seed: u64) -> Self {
        let top = &unit.top;
        let widths = top.inputs().iter().map(|port| top.signal(port.signal).width).collect();
        let mut simulator = Simulator::new(top).expect("a simulation");
        simulator.restart_randomly(seed);
        let mut unknown = Self { simulator, widths };
        unknown.reset();
        unknown
    }
}

impl UnitEngine for Unknown {
    fn outputs(&mut self) -> UnitOutputs {
        self.simulator.settle();
        let module = self.simulator.module().clone();
        let output = |name: &str| self.simulator.get(self.simulator.output(name).expect("a port"));
        let words: Vec<u64> = module.outputs().iter().map(|port| output(&port.name)).collect();
        outputs_of(&words)
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        let module = self.simulator.module().clone();
        for (port, word) in module.inputs().iter().zip(words_of(inputs, &self.widths, || 0)) {
            let port = self.simulator.input(&port.name).expect("a port");
            self.simulator.set(port, word);
        }
        self.simulator.cycle();
    }

    fn reset(&mut self) {
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}

#[test]
fn nothing_depends_on_what_was_before_a_reset() {
    let unit = unit(Control::Credit);
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(12, true, &mut random);
    let rays = (0..100).map(|_| random_ray(root, &mut random)).collect();
    let behaviour = Behaviour { latency: (1, 40), stalls: [40; 4], errors: 100 };
    let [mut first, mut second, mut third] = [1, 2, 3].map(|seed| Unknown::new(&unit, seed));
    let mut environment = Environment::new(&blocks.0, unit.parameters, rays, behaviour, 5);
    while !environment.is_done() {
        environment.cycle(&mut [&mut first, &mut second, &mut third]).expect("equal outputs");
        assert!(environment.cycles() < 200_000, "{} rays ended", environment.replies.len());
    }
}
