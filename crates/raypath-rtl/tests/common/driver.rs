//! Comparison of a netlist with its operations, for random jobs.

use super::drive::{Ports, drive};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Concrete, Operation, Port, PortKind, from_words, ports_of, to_canonical_words};
use raypath_rtl::{Config, DatapathNetlist, Encoding, OperationVisitor};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

/// Operations over a circuit whose values are known, and the configuration of the netlist.
pub struct Driver<C: Concrete> {
    circuit: C,
    config: Config,
    /// The cell in which the circuit collects exceptions, to compare with the port `exception_flags_o`.
    pub raised: Option<&'static Cell<u64>>,
    operations: Vec<Runner>,
}

/// Computes the words of an outcome from those of a job.
type Run = dyn FnMut(&[u64]) -> Vec<u64>;

/// An operation that keeps its state.
struct Runner {
    opcode: u64,
    /// Its input and output ports; `false` marks those that are absent in this configuration.
    inputs: Vec<(Port, bool)>,
    outputs: Vec<(Port, bool)>,
    run: Box<Run>,
}

impl<C: Concrete + 'static> OperationVisitor for Driver<C> {
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
        self.operations.push(Runner { opcode, inputs, outputs, run: Box::new(run) });
        Ok(())
    }
}

impl<C: Concrete + 'static> Driver<C> {
    /// A driver without operations; it adds them as a visitor.
    pub fn new(circuit: C, config: Config) -> Self {
        Self { circuit, config, raised: None, operations: Vec::new() }
    }

    /// Sends `jobs` jobs through the netlist, with random pauses of source and sink. Returns the expected values of
    /// each output port.
    pub fn run(mut self, name: &str, datapath: &DatapathNetlist, jobs: usize) -> BTreeMap<String, BTreeSet<u64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(jobs as u64);
        let (inputs, outputs) = (datapath.top().inputs(), datapath.top().outputs());
        for runner in &self.operations {
            for (port, is_there) in &runner.inputs {
                assert_eq!(inputs.iter().any(|input| input.stem() == port.name), *is_there, "{name}: {}", port.name);
            }
            for (port, is_there) in &runner.outputs {
                assert_eq!(outputs.iter().any(|output| output.stem() == port.name), *is_there, "{name}: {}", port.name);
            }
        }
        let ports = self.operations.iter().flat_map(|runner| &runner.outputs);
        let kinds: BTreeMap<String, PortKind> = ports.map(|(port, _)| (port.name.clone(), port.kind)).collect();
        let features = self.config.semantics.features;
        assert_eq!(outputs.iter().any(|port| port.stem() == "exception_flags"), features.exception_flags);
        let (given, expected): (Vec<Ports>, Vec<Ports>) = (0..jobs).map(|_| self.job(&mut rng)).unzip();
        let (answers, _) = drive(datapath, &given, || rng.random_bool(0.2));
        let mut seen: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
        for (job, (answer, expected)) in answers.iter().zip(expected).enumerate() {
            assert!(expected.keys().all(|port| answer.contains_key(port)), "{name}: {answer:?}");
            for (port, &bits) in answer {
                // Output ports that the operation does not have are zero.
                let kind = kinds.get(port).filter(|_| expected.contains_key(port));
                let (found, expected) = (self.of_port(kind, bits), expected.get(port).copied().unwrap_or(0));
                assert_eq!(found, expected, "{name}: {port} of job {job} (opcode {})", answer["opcode"]);
            }
            expected.into_iter().for_each(|(port, bits)| _ = seen.entry(port).or_default().insert(bits));
        }
        // Every flag was both 0 and 1, so a constant flag would be found.
        for (port, values) in seen.iter().filter(|(port, _)| kinds.get(*port) == Some(&PortKind::Flags)) {
            let (ones, always) = values.iter().fold((0, u64::MAX), |(ones, always), bits| (ones | bits, always & bits));
            assert!(ones != 0 && always == 0, "{name}: {port} never changes: {values:?}");
        }
        seen
    }

    /// The ports of a job of any operation, and of its outcome.
    fn job(&mut self, rng: &mut ChaCha8Rng) -> (Ports, Ports) {
        let which = rng.random_range(0..self.operations.len());
        let words = self.words(which, rng);
        let runner = &mut self.operations[which];
        let answer = (runner.run)(&words);
        let there = |ports: &[(Port, bool)], words: Vec<u64>| -> Vec<(Port, u64)> {
            let ports = ports.iter().zip(words).filter(|((_, is_there), _)| *is_there);
            ports.map(|((port, _), bits)| (port.clone(), bits)).collect()
        };
        let (opcode, given, values) = (runner.opcode, there(&runner.inputs, words), there(&runner.outputs, answer));
        let mut given: Ports =
            given.into_iter().map(|(port, bits)| (port.name, self.to_port(port.kind, bits))).collect();
        let mut values: Ports = values.into_iter().map(|(port, bits)| (port.name, bits)).collect();
        let features = self.config.semantics.features;
        let tag = (features.tag > 0).then(|| ("tag", rng.random::<u64>() & mask(features.tag)));
        for (name, bits) in tag.into_iter().chain([("opcode", opcode)]) {
            given.insert(name.to_string(), bits);
            values.insert(name.to_string(), bits);
        }
        values.extend(self.raised.map(|raised| ("exception_flags".to_string(), raised.take())));
        (given, values)
    }

    /// The words of a job: small numbers, special numbers, random bits.
    fn words(&self, which: usize, rng: &mut ChaCha8Rng) -> Vec<u64> {
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
        let sign = 1 << (format.ieee_width() - 1);
        let ports = self.operations[which].inputs.iter();
        // Without these values hardly any job would hit: valid axes, a range that is not empty, boxes around the
        // origin.
        let is_proper = rng.random_bool(0.7);
        let bits = ports.map(|(port, _)| match (port.name.as_str(), port.width) {
            ("ray_kx", _) if is_proper => 0,
            ("ray_ky", _) if is_proper => 1,
            ("ray_kz", _) if is_proper => 2,
            ("t_min", _) if is_proper => format.from_f32(rng.random_range(0..2) as f32 / 16.0),
            ("ray_extent", _) if is_proper => format.from_f32([8.0, 64.0, f32::INFINITY][rng.random_range(0..3)]),
            (name, None) if is_proper && name.ends_with("_min") => number(rng) | sign,
            (name, None) if is_proper && name.ends_with("_max") => number(rng) & !sign,
            (_, Some(width)) => rng.random::<u64>() & mask(width),
            (_, None) => number(rng),
        });
        bits.collect()
    }

    fn to_port(&self, kind: PortKind, bits: u64) -> u64 {
        let is_recoded = kind == PortKind::Number && self.config.microarchitecture.io == Encoding::Recoded;
        if is_recoded { self.config.semantics.format.encode(bits) } else { bits }
    }

    fn of_port(&self, kind: Option<&PortKind>, bits: u64) -> u64 {
        let is_recoded = kind == Some(&PortKind::Number) && self.config.microarchitecture.io == Encoding::Recoded;
        if is_recoded { self.config.semantics.format.decode(bits) } else { bits }
    }
}

/// A word of `bits` ones.
fn mask(bits: u32) -> u64 {
    u64::MAX.checked_shr(64 - bits).unwrap_or(0)
}
