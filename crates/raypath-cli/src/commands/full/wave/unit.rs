//! `raypath wave --unit`: random rays through the netlist of the traversal unit, with a waveform.

use super::{Arguments, Samples, is_of_interest};
use crate::{CliError, Progress};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::wave::WaveWriter;
use raypath_rtl::UnitKind;
use raypath_traversal::traffic::{Behaviour, BlockScene, Environment, random_ray};
use raypath_traversal::{NetlistEngine, RayRequest, UnitEngine, UnitInputs, UnitNetlist, UnitOutputs};
use std::io::Write;

/// The triangles of the random scene.
const TRIANGLES: u32 = 500;
/// The memory and the users of the ports, which never stall.
const BEHAVIOUR: Behaviour = Behaviour { latency: (20, 20), stalls: [0; 4], errors: 0 };
/// The most cycles that a ray takes in this scene, by far.
const CYCLES_PER_RAY: u64 = 100_000;

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let unit = UnitNetlist::new(arguments.datapath.config()?, arguments.unit_parameters.parameters())?;
    let seed = arguments.stream.seed();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (scene, root) = BlockScene::random_of(unit.parameters.step.node, TRIANGLES, &mut random);
    let total = arguments.rays as usize;
    let rays: Vec<RayRequest> = (0..total).map(|_| random_ray(root, &mut random)).collect();

    let mut units: Vec<String> = UnitKind::ALL.map(|kind| format!("u_{}", kind.stem())).into();
    units.push("u_divider".to_string());
    let netlist = NetlistEngine::observing(&unit.top, |name| is_of_interest(name, &units))?;
    let waves = WaveWriter::create(&arguments.out, netlist.simulator())?;
    let mut waving = Waving { netlist, samples: Samples::new(waves) };
    let mut environment = Environment::new(&scene.0, unit.parameters, rays, BEHAVIOUR, seed);
    let mut progress = Progress::new("rays", total);
    let limit = CYCLES_PER_RAY.saturating_mul(total as u64);
    while !environment.is_done() && progress.at(environment.replies.len()) {
        let cycle = environment.cycle(&mut [&mut waving]);
        cycle.map_err(|problem| CliError::Mismatch(format!("netlist: {problem}")))?;
        if let Some(failed) = waving.samples.failed.take() {
            return Err(failed.into());
        }
        if environment.cycles() > limit {
            let ended = environment.replies.len();
            return Err(CliError::Mismatch(format!("{ended} of {total} rays ended in {limit} cycles, expected all")));
        }
    }
    let ended = environment.replies.len();
    progress.finish(ended)?;
    waving.samples.waves.finish()?;
    writeln!(out, "Wrote {ended} rays in {} cycles to {}", environment.cycles(), arguments.out.display())?;
    Ok(())
}

struct Waving {
    netlist: NetlistEngine,
    samples: Samples,
}

impl UnitEngine for Waving {
    fn outputs(&mut self) -> UnitOutputs {
        self.netlist.outputs()
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        self.netlist.cycle(inputs);
        self.samples.take(self.netlist.simulator());
    }

    fn reset(&mut self) {
        self.netlist.reset();
        self.samples.take(self.netlist.simulator());
    }
}
