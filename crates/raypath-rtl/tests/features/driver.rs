//! Random jobs through a configuration's netlist, held against its operations.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::Simulator;
use raypath_ops::{Concrete, Operation, Port, PortKind, from_words, ports_of, to_canonical_words};
use raypath_rtl::{Config, Datapath, Encoding, OperationVisitor};
use std::cell::Cell;
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

/// A configuration's netlist, and its operations over a circuit whose values are known.
pub struct Driver<C: Concrete> {
    config: Config,
    operations: Collected<C>,
    /// Where the circuit leaves its exceptions.
    raised: Option<&'static Cell<u64>>,
}

struct Collected<C> {
    circuit: C,
    all: Vec<Runner>,
}

/// Words of an input to those of the answer.
type Run = dyn FnMut(&[u64]) -> Vec<u64>;

/// An operation that remembers its state.
struct Runner {
    opcode: u64,
    /// All that it may take and answer; what is not there in this configuration is `false`.
    inputs: Vec<(Port, bool)>,
    outputs: Vec<(Port, bool)>,
    run: Box<Run>,
}

impl<C: Concrete + 'static> OperationVisitor for Collected<C> {
    type Error = Infallible;

    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Infallible> {
        let c = self.circuit;
        let inputs = ports_of::<O::Input<_>>().into_iter().map(|port| {
            let is_there = operation.has_input(&port.name);
            (port, is_there)
        });
        let outputs = ports_of::<O::Output<_>>().into_iter().map(|port| {
            let is_there = operation.has_output(&port.name);
            (port, is_there)
        });
        let (inputs, outputs) = (inputs.collect(), outputs.collect());
        let mut state: O::State<C> = from_words(c, &[]);
        let run = move |words: &[u64]| {
            let (output, next) = operation.run(c, from_words(c, words), state);
            state = next;
            let mut words = Vec::new();
            to_canonical_words(&output, &mut words);
            words
        };
        self.all.push(Runner { opcode, inputs, outputs, run: Box::new(run) });
        Ok(())
    }
}

impl<C: Concrete + 'static> Driver<C> {
    /// The netlist of a configuration whose numbers are those of `circuit`.
    pub fn new(circuit: C, config: Config) -> Self {
        let mut operations = Collected { circuit, all: Vec::new() };
        let Ok(()) = config.semantics.operations(&mut operations);
        Self { config, operations, raised: None }
    }

    /// With a circuit that leaves its exceptions in a cell: holds them against the port `exception_flags_o`.
    pub fn raising(self, raised: &'static Cell<u64>) -> Self {
        Self { raised: Some(raised), ..self }
    }

    /// Sends so many jobs through it, with a source and a sink that pause now and then.
    pub fn run(mut self, name: &str, jobs: usize) {
        let (config, mut rng) = (self.config, ChaCha8Rng::seed_from_u64(jobs as u64));
        let datapath = Datapath::new(config).expect("a datapath");
        let mut simulator = Simulator::new(datapath.top()).expect("a netlist");
        let input = |port: &str| simulator.input(port).expect(port);
        let output = |port: &str| simulator.output(port).expect(port);
        let [valid, sink_ready, opcode] = ["input_valid_i", "output_ready_i", "opcode_i"].map(input);
        let [ready, shown, shown_opcode] = ["input_ready_o", "output_valid_o", "opcode_o"].map(output);
        let tag = (config.semantics.features.tag > 0).then(|| (input("tag_i"), output("tag_o")));
        let flags_port = self.raised.map(|_| output("exception_flags_o"));
        assert_eq!(simulator.output("exception_flags_o").is_ok(), config.semantics.features.exception_flags);
        let mut ins = BTreeMap::new();
        let mut outs = BTreeMap::new();
        for runner in &self.operations.all {
            for (port, is_there) in &runner.inputs {
                match simulator.input(&format!("{}_i", port.name)) {
                    Ok(wire) => ins.insert(port.name.clone(), wire),
                    Err(_) => {
                        assert!(!is_there, "{name}: no port {}", port.name);
                        continue;
                    }
                };
                assert!(is_there, "{name}: {} should not be there", port.name);
            }
            for (port, is_there) in &runner.outputs {
                let wire = simulator.output(&format!("{}_o", port.name));
                assert_eq!(wire.is_ok(), *is_there, "{name}: {}", port.name);
                outs.extend(wire.ok().map(|wire| (port.name.clone(), (wire, port.kind))));
            }
        }
        let mut expected: VecDeque<(u64, [u64; 2], BTreeMap<String, u64>)> = VecDeque::new();
        let (mut sent, mut seen) = (0, 0);
        // Which bits of flags were 1 and which were 0, so that none is only ever right by being constant.
        let mut flags: BTreeMap<String, [u64; 2]> = BTreeMap::new();
        let mut offered: Option<(usize, u64, Vec<u64>)> = None;
        for _ in 0..40 * (jobs + 50) {
            if offered.is_none() && sent < jobs && rng.random_bool(0.8) {
                let which = rng.random_range(0..self.operations.all.len());
                let tag = rng.random::<u64>() & mask(config.semantics.features.tag);
                offered = Some((which, tag, self.job(which, &mut rng)));
            }
            simulator.set(valid, offered.is_some().into());
            let sink_takes = rng.random_bool(0.8);
            simulator.set(sink_ready, sink_takes.into());
            if let Some((which, word, words)) = &offered {
                let runner = &self.operations.all[*which];
                simulator.set(opcode, runner.opcode);
                if let Some((port, _)) = tag {
                    simulator.set(port, *word);
                }
                for ((port, is_there), &bits) in runner.inputs.iter().zip(words) {
                    if *is_there {
                        simulator.set(ins[&port.name], self.to_port(port.kind, bits));
                    }
                }
            }
            simulator.settle();
            let leaves = simulator.get(shown) == 1;
            let takes = simulator.get(ready) == 1;
            if leaves {
                let Some((opcode, [word, raised], values)) = expected.front() else { panic!("{name}: a job too many") };
                assert_eq!(simulator.get(shown_opcode), *opcode, "{name}: job {seen}");
                assert!(tag.is_none_or(|(_, port)| simulator.get(port) == *word), "{name}: tag of job {seen}");
                if let Some(port) = flags_port {
                    assert_eq!(simulator.get(port), *raised, "{name}: exceptions of job {seen} (opcode {opcode})");
                }
                for (port, &(wire, kind)) in &outs {
                    let found = self.of_port(kind, simulator.get(wire));
                    let expected = values.get(port).copied();
                    // What the operation does not have is zero, as it stands at the port.
                    let same = expected.map_or(simulator.get(wire) == 0, |expected| expected == found);
                    assert!(same, "{name}: {port} of job {seen} (opcode {opcode}): {found:x}, expected {expected:x?}");
                }
            }
            if leaves && let Some((_, _, values)) = expected.front() {
                for (port, _) in outs.iter().filter(|(_, (_, kind))| *kind == PortKind::Flags) {
                    if let Some(&bits) = values.get(port) {
                        let [ones, zeros] = flags.entry(port.clone()).or_default();
                        (*ones, *zeros) = (*ones | bits, *zeros | !bits);
                    }
                }
            }
            if leaves && sink_takes {
                expected.pop_front();
                seen += 1;
            }
            if takes && let Some((which, word, words)) = offered.take() {
                let runner = &mut self.operations.all[which];
                let answer = (runner.run)(&words);
                let there = runner.outputs.iter().zip(answer).filter(|((_, is_there), _)| *is_there);
                let values = there.map(|((port, _), bits)| (port.name.clone(), bits)).collect();
                let raised = self.raised.map_or(0, Cell::take);
                expected.push_back((runner.opcode, [word, raised], values));
                sent += 1;
            }
            simulator.cycle();
            if seen == jobs {
                let constant = flags.iter().find(|(_, [ones, zeros])| ones & zeros != *ones || *ones == 0);
                assert!(constant.is_none(), "{name}: {constant:?} never changes");
                return;
            }
        }
        panic!("{name}: {seen} of {jobs} jobs came out");
    }

    /// A job of an operation: small numbers, special ones, any bits.
    fn job(&self, which: usize, rng: &mut ChaCha8Rng) -> Vec<u64> {
        let style = rng.random_range(0..4);
        let format = self.config.semantics.format;
        let special = [0.0, -0.0, 1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-40, -3e38, 6e-8];
        let number = |rng: &mut ChaCha8Rng| {
            let value = match style {
                0 => return rng.random::<u64>() & mask(format.ieee_width()),
                1 => special[rng.random_range(0..special.len())],
                2 => rng.random_range(-4..=4) as f32,
                _ => rng.random_range(-2.0..2.0),
            };
            format.from_f32(value)
        };
        let ports = self.operations.all[which].inputs.iter();
        // Else next to no triangle would be hit: axes that are axes, and a range that has room.
        let is_proper = rng.random_bool(0.7);
        let bits = ports.map(|(port, _)| match (port.name.as_str(), port.width) {
            ("ray_kx", _) if is_proper => 0,
            ("ray_ky", _) if is_proper => 1,
            ("ray_kz", _) if is_proper => 2,
            ("t_min", _) if is_proper => format.from_f32(rng.random_range(0..2) as f32 / 16.0),
            ("ray_extent", _) if is_proper => format.from_f32([8.0, 64.0, f32::INFINITY][rng.random_range(0..3)]),
            (_, Some(width)) => rng.random::<u64>() & mask(width),
            (_, None) => number(rng),
        });
        bits.collect()
    }

    fn to_port(&self, kind: PortKind, bits: u64) -> u64 {
        let is_recoded = kind == PortKind::Number && self.config.microarchitecture.io == Encoding::Recoded;
        if is_recoded { self.config.semantics.format.encode(bits) } else { bits }
    }

    fn of_port(&self, kind: PortKind, bits: u64) -> u64 {
        let is_recoded = kind == PortKind::Number && self.config.microarchitecture.io == Encoding::Recoded;
        if is_recoded { self.config.semantics.format.decode(bits) } else { bits }
    }
}

/// So many ones.
fn mask(bits: u32) -> u64 {
    u64::MAX.checked_shr(64 - bits).unwrap_or(0)
}
