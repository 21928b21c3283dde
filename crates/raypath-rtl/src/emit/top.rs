//! The top module: a chain of input registers, stages and output.

use crate::allocate::plan::Plan;
use crate::config::Control;
use crate::emit::boundary::label;
use crate::emit::control::{self, Spacing};
use crate::emit::input;
use crate::emit::interface;
use crate::emit::library::Library;
use crate::emit::output;
use crate::emit::positions;
use crate::emit::stage;
use crate::error::Error;
use crate::fold::Rounds;
use raypath_hdl::{Builder, Forward, Module, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The top module, and those of its steps: the input's registers, then stage 1 and so on.
#[derive(Debug)]
pub struct Pipeline {
    pub top: Arc<Module>,
    pub steps: Vec<Arc<Module>>,
    /// The module `raypath_credit`, if control is by credits.
    pub credit: Option<Arc<Module>>,
    /// The module `raypath_rounds`, if the pipeline is folded.
    pub rounds: Option<Arc<Module>>,
}

/// Builds the module `raypath` and all below it. `doc` is its head comment.
pub fn pipeline(plan: &Plan, library: &Library, doc: &[String]) -> Result<Pipeline, Error> {
    let m = Builder::new("raypath");
    let package = interface::package(plan, library);
    m.package(&package);
    for line in doc {
        m.doc(line);
    }
    let mut wires: BTreeMap<String, Wire<'_>> = BTreeMap::new();
    let input_valid = m.input("input_valid_i", 1);
    wires.insert("valid".to_string(), input_valid);
    wires.insert("opcode".to_string(), m.input("opcode_i", plan.opcode_width()));
    let output_ready = m.input("output_ready_i", 1);
    let mut unread = Vec::new();
    for port in input::ports(plan) {
        let wire = m.input(&format!("{}_i", port.name), port.width);
        if port.read {
            wires.insert(port.name, wire);
        } else {
            unread.push(wire);
        }
    }
    if !unread.is_empty() {
        m.section("Ports that no configured rule reads");
        m.unused("unused_ports", &unread);
    }

    let mut modules = vec![("input".to_string(), input::input(plan, library, &package)?)];
    for step in 1..plan.steps.len() {
        modules.push((interface::step_name(plan.steps[step].label), stage::stage(plan, library, &package, step)?));
    }
    let mut credit = None;
    let mut leaves = None;
    if plan.microarchitecture.control == Control::Credit {
        m.section("A job enters while the exit has a place for it");
        let interval = plan.microarchitecture.interval.cycles();
        let credits = plan.capacity() as u32;
        let module = control::credit(credits, interval, plan.opcode_width(), &spacings(plan), &package)?;
        let returned = m.forward("job_leaves", 1);
        wires.insert("returned".to_string(), returned.wire());
        let outputs = instance(&m, "credit", &module, &wires);
        m.output("input_ready_o", outputs["ready"]);
        wires.insert("valid".to_string(), outputs["valid"]);
        (credit, leaves) = (Some(module), Some(returned));
    }

    let rounds = match &plan.rounds {
        None => None,
        Some(rounds) => {
            m.section("The positions of the jobs");
            Some(Positions::new(&m, plan, rounds, &modules, &mut wires)?)
        }
    };

    m.section("The pipeline");
    let mut backward = Backward { m: &m, forwards: BTreeMap::new(), driven: BTreeMap::new() };
    let mut ready_before: Option<Forward<'_>> = None;
    for (index, (name, module)) in modules.iter().enumerate() {
        if let Some(rounds) = &rounds {
            rounds.supply(index + 1 == modules.len(), &mut wires);
        }
        let is_elastic = plan.microarchitecture.control == Control::Skid && rounds.is_none();
        let next = modules.get(index + 1).filter(|_| is_elastic);
        let ready_after = next.map(|_| m.forward_unnamed(1));
        wires.insert("ready".to_string(), ready_after.map_or(output_ready, |forward| forward.wire()));
        backward.supply(module, &mut wires);
        wires = instance(&m, name, module, &wires);
        backward.collect(&wires);
        if let Some(rounds) = &rounds {
            rounds.collect(&wires);
            continue;
        }
        match (ready_before, wires.get("ready").copied()) {
            (Some(forward), Some(ready)) => forward.drive(ready),
            (None, Some(ready)) => m.output("input_ready_o", ready),
            (_, None) => {}
        }
        ready_before = ready_after;
    }
    backward.connect();

    if let Some(leaves) = leaves {
        leaves.drive(wires["valid"] & output_ready);
    }
    m.output("output_valid_o", wires["valid"]);
    m.output("opcode_o", wires["opcode"]);
    let output = output::output(plan, library, &package)?;
    for (name, wire) in instance(&m, "output", &output, &wires) {
        m.output(&format!("{name}_o"), wire);
    }
    let steps = modules.into_iter().map(|(_, module)| module).collect();
    let rounds = rounds.map(|rounds| rounds.module);
    Ok(Pipeline { top: m.finish()?, steps, credit, rounds })
}

/// The control of a folded pipeline at the top.
struct Positions<'m> {
    module: Arc<Module>,
    /// Its outputs for the steps, by stem.
    outputs: BTreeMap<String, Wire<'m>>,
    /// Whether the exit is ready, if jobs may have to wait for it.
    ready: Option<Forward<'m>>,
}

impl<'m> Positions<'m> {
    /// The instance of `raypath_rounds`, with the outputs that the steps read.
    fn new(
        m: &'m Builder,
        plan: &Plan,
        rounds: &Rounds,
        steps: &[(String, Arc<Module>)],
        wires: &mut BTreeMap<String, Wire<'m>>,
    ) -> Result<Self, Error> {
        let stops = positions::stops(plan);
        let last = rounds.positions() - 1;
        let control = control::Rounds { positions: last + 1, interval: rounds.interval, stops: &stops };
        let is_read = |stem: &str| steps.iter().flat_map(|(_, step)| step.inputs()).any(|port| port.stem() == stem);
        let at = (0..=last).filter(|&position| position == last || is_read(&positions::at(position)));
        let moves = stops.iter().copied().filter(|&stop| is_read(&positions::moves(stop, &stops)));
        let module = control.module(&at.collect(), &moves.collect())?;
        let ready = (!stops.is_empty()).then(|| m.forward("exit_ready", 1));
        wires.extend(ready.map(|ready| ("ready".to_string(), ready.wire())));
        let mut outputs = instance(m, "rounds", &module, wires);
        if let (Some(ready), Some(enters)) = (outputs.remove("ready"), outputs.remove("enters")) {
            m.output("input_ready_o", ready);
            wires.insert("valid".to_string(), enters);
        }
        outputs.insert("last".to_string(), outputs[&positions::at(last)]);
        Ok(Self { module, outputs, ready })
    }

    /// Adds the wires for a step.
    fn supply(&self, is_last: bool, wires: &mut BTreeMap<String, Wire<'m>>) {
        wires.extend(self.outputs.iter().map(|(stem, wire)| (stem.clone(), *wire)));
        if is_last {
            wires.insert("valid".to_string(), self.outputs["last"]);
        }
    }

    /// Takes the ready of the last step.
    fn collect(&self, outputs: &BTreeMap<String, Wire<'m>>) {
        if let (Some(forward), Some(ready)) = (self.ready, outputs.get("ready")) {
            forward.drive(*ready);
        }
    }
}

/// The operations whose jobs must keep a distance, because the pipeline cannot delay a job after its acceptance.
fn spacings(plan: &Plan) -> Vec<Spacing> {
    let loops = plan.operations.iter().enumerate().filter(|(_, traced)| traced.is_loop());
    loops.map(|(op, traced)| Spacing { label: label(traced), name: traced.name, cycles: plan.spacing(op) }).collect()
}

/// Wires from a step to an earlier one: state that is read before the step that writes it.
struct Backward<'m> {
    m: &'m Builder,
    forwards: BTreeMap<String, Forward<'m>>,
    driven: BTreeMap<String, Wire<'m>>,
}

impl<'m> Backward<'m> {
    /// Adds the inputs of a module that no earlier module drives.
    fn supply(&mut self, module: &Module, wires: &mut BTreeMap<String, Wire<'m>>) {
        for port in module.inputs() {
            let stem = port.stem().to_string();
            wires.entry(stem.clone()).or_insert_with(|| {
                let width = module.signal(port.signal).width;
                self.forwards.entry(stem.clone()).or_insert_with(|| self.m.forward(&stem, width)).wire()
            });
        }
    }

    /// Connects outputs of a module to the earlier modules that read them.
    fn collect(&mut self, outputs: &BTreeMap<String, Wire<'m>>) {
        for (stem, wire) in outputs.iter().filter(|(stem, _)| self.forwards.contains_key(*stem)) {
            self.driven.insert(stem.clone(), *wire);
        }
    }

    fn connect(self) {
        for (stem, forward) in self.forwards {
            if let Some(wire) = self.driven.get(&stem) {
                forward.drive(*wire);
            }
        }
    }
}

/// An instance whose inputs are wires of the same names. Returns its outputs by name.
fn instance<'m>(
    m: &'m Builder,
    name: &str,
    module: &Arc<Module>,
    wires: &BTreeMap<String, Wire<'m>>,
) -> BTreeMap<String, Wire<'m>> {
    let connections: Vec<(&str, Wire<'m>)> =
        module.inputs().iter().filter_map(|port| Some((port.name.as_str(), *wires.get(port.stem())?))).collect();
    let outputs = m.instance(&format!("u_{name}"), module, &connections);
    module.outputs().iter().map(|port| port.stem().to_string()).zip(outputs).collect()
}
