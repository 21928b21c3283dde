//! The problem of a configuration and an operation: can an outcome of the design differ from that of the operation?

use super::conversion::Conversion;
use super::design::{Design, Id};
use super::reference::{JobValues, Outcome, outcome};
use super::script::{Script, Term};
use super::units::Units;
use super::unrolled::Unrolled;
use raypath_float::Format;
use raypath_ops::{Operation, Rules};
use raypath_rtl::{Config, Encoding};
use raypath_tools::ToolError;
use raypath_verify::Error;
use std::collections::{BTreeMap, BTreeSet};

/// The cycle in which the job enters. The reset is on in cycle 0.
const ENTERS: u32 = 1;

/// A question to a solver.
#[derive(Debug)]
pub(super) struct Problem {
    /// The operation or the module.
    pub name: String,
    script: Script,
    /// What is compared: its name, its value in the design, its value by the operation.
    pairs: Vec<(String, Term, Term)>,
    /// The units of one operand, whose modules may be any functions here.
    pub conversions: BTreeSet<Conversion>,
}

/// A design with its configuration.
#[derive(Clone, Copy)]
pub(super) struct Pipeline<'d> {
    pub config: Config,
    pub latency: u32,
    /// It has an operation in addition to the paper's.
    pub has_added: bool,
    /// It has a fault that may be none for what units compute.
    pub has_fault: bool,
    pub design: &'d Design,
}

/// The outcome of an operation for values of a job.
type Outcomes<'a> = dyn Fn(&mut Script, Units<'_>, &dyn JobValues) -> Outcome + 'a;

impl Problem {
    /// A job of an operation in an empty pipeline: it enters in cycle [`ENTERS`], and its outcome leaves after the
    /// latency. All registers have any values but those of the control, which the reset sets, and so have the states
    /// and, in the other cycles, all inputs but the handshake.
    pub fn new<O: Operation>(pipeline: Pipeline<'_>, operation: &O, opcode: u64) -> Result<Self, Error> {
        let outcome =
            |script: &mut Script, units: Units<'_>, values: &dyn JobValues| outcome(operation, script, units, values);
        Self::of(pipeline, O::NAME, opcode, &outcome)
    }

    /// [`new`](Self::new), not generic, so that it is compiled once.
    fn of(pipeline: Pipeline<'_>, operation: &str, opcode: u64, outcome: &Outcomes<'_>) -> Result<Self, Error> {
        let Pipeline { config, latency, design, .. } = pipeline;
        let mut script = Script::default();
        let mut unrolled = Unrolled::new(design);
        let leaves = ENTERS + latency;
        for cycle in ENTERS..=leaves {
            let handshake = [("input_valid_i", u64::from(cycle == ENTERS)), ("output_ready_i", 1)];
            let opcode = (cycle == ENTERS).then_some(("opcode_i", opcode));
            for (name, value) in handshake.into_iter().chain(opcode) {
                let id = find(&design.inputs, name)?;
                let value = script.constant(design.nodes[&id].width, value);
                unrolled.set(cycle, id, value);
            }
        }
        let mut values = Values { design, operation, inputs: BTreeMap::new(), states: BTreeMap::new() };
        for (name, &id) in design.inputs.iter().filter(|(name, _)| !name.contains('.')) {
            values.inputs.insert(name, unrolled.value(&mut script, ENTERS, id)?);
        }
        for (name, id) in states(design) {
            let value = script.free(design.nodes[&id].width);
            unrolled.set(ENTERS, id, value);
            values.states.insert(name, (id, value));
        }

        let format = config.semantics.format;
        let ieee_registers = config.microarchitecture.registers == Encoding::Ieee;
        let is_narrow = matches!(config.semantics.rules, Rules::Bounds(_));
        let has_quantised = config.semantics.features.quantised_boxes || pipeline.has_added;
        let states_classes = ieee_registers || is_narrow || has_quantised || pipeline.has_fault;
        let units = Units { design, format, ieee_registers, states_classes, positive_nans: is_narrow };
        let outcome = outcome(&mut script, units, &values);
        let mut expected = outcome.outputs;
        expected.extend(values.input("tag").map(|tag| ("tag".to_string(), tag)));
        expected.insert("opcode".to_string(), values.inputs["opcode_i"]);
        let all = outcome.exceptions.into_iter().reduce(|a, b| script.operator(a.width, "bvor", &[a, b]));
        expected.extend(all.map(|all| ("exception_flags".to_string(), all)));

        let mut pairs = Vec::new();
        let ready = find(&design.outputs, "input_ready_o")?;
        pairs.push(("input_ready_o".into(), unrolled.value(&mut script, ENTERS, ready)?, script.constant(1, 1)));
        for cycle in ENTERS..=leaves {
            let valid = unrolled.value(&mut script, cycle, find(&design.outputs, "output_valid_o")?)?;
            let is_last = script.constant(1, u64::from(cycle == leaves));
            pairs.push((format!("output_valid_o after {} cycles", cycle - ENTERS), valid, is_last));
        }
        let is_handshake = |name: &str| name == "input_ready_o" || name == "output_valid_o";
        for (name, &id) in design.outputs.iter().filter(|(name, _)| !name.contains('.') && !is_handshake(name)) {
            let actual = unrolled.value(&mut script, leaves, id)?;
            let own = name.strip_suffix("_o").and_then(|port| expected.remove(port));
            // Ports of other operations are zero.
            let value = own.unwrap_or_else(|| script.constant(actual.width, 0));
            pairs.push((name.clone(), actual, value));
        }
        for (name, (id, before)) in &values.states {
            let after = unrolled.value(&mut script, leaves + 1, *id)?;
            let own = name.strip_prefix(operation).and_then(|name| name.strip_prefix('_'));
            let own = own.and_then(|state| outcome.states.get(state));
            pairs.push((name.clone(), after, own.copied().unwrap_or(*before)));
        }
        let widths = |(_, actual, expected): &&(String, Term, Term)| actual.width != expected.width;
        let absent = outcome.states.keys().find(|state| values.state(state).is_none());
        match (expected.keys().chain(absent).next(), pairs.iter().find(widths)) {
            (Some(name), _) => Err(missing(name)),
            (None, Some((name, actual, expected))) => {
                let expected = format!("{} bits", expected.width);
                Err(ToolError::unexpected("yosys", format!("{name} has {} bits", actual.width), expected).into())
            }
            (None, None) => Ok(Self { name: operation.to_string(), script, pairs, conversions: outcome.conversions }),
        }
    }

    /// A unit of one operand, for every word, or every number that the recoded format writes.
    pub fn conversion(design: &Design, format: Format, conversion: Conversion) -> Result<Self, Error> {
        let (port_in, port_out) = conversion.ports();
        let mut script = Script::default();
        let mut unrolled = Unrolled::new(design);
        let operand = unrolled.value(&mut script, ENTERS, find(&design.inputs, &format!("{port_in}_i"))?)?;
        let units = Units { design, format, ieee_registers: false, states_classes: false, positive_nans: false };
        if matches!(conversion, Conversion::Narrow(_)) {
            units.is_canonical(&mut script, operand);
        }
        let actual = unrolled.value(&mut script, ENTERS, find(&design.outputs, &format!("{port_out}_o"))?)?;
        let actual = units.padded(&mut script, actual);
        let expected = conversion.definition(&mut script, format, operand);
        let mut pairs = vec![(port_out.to_string(), actual, expected)];
        if matches!(conversion, Conversion::Narrow(_)) {
            // So that a register in the layout of IEEE 754 keeps it.
            let can_be_stored = units.can_be_stored(&mut script, actual);
            let can_be_stored = script.bit(&can_be_stored);
            pairs.push((format!("whether {port_out} can be stored"), can_be_stored, script.constant(1, 1)));
        }
        Ok(Self { name: conversion.module(format), script, pairs, conversions: BTreeSet::new() })
    }

    /// The scripts to ask: whether the assumptions can hold, and whether something can differ.
    pub fn questions(&self) -> [String; 2] {
        [self.script.holds(), self.script.differs(&self.pairs)]
    }

    /// The same with a question for each value that is compared.
    pub fn questions_by_output(&self) -> Vec<String> {
        let outputs = self.pairs.chunks(1).map(|pair| self.script.differs(pair));
        std::iter::once(self.script.holds()).chain(outputs).collect()
    }

    /// The values that are compared.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.pairs.iter().map(|(name, ..)| name.as_str())
    }
}

fn find(ports: &BTreeMap<String, Id>, name: &str) -> Result<Id, Error> {
    ports.get(name).copied().ok_or_else(|| missing(name))
}

fn missing(name: &str) -> Error {
    ToolError::unexpected("yosys", format!("no port or register {name}"), "those of the datapath").into()
}

/// The registers of the operations' states, such as `euclidean_accumulator`.
fn states(design: &Design) -> impl Iterator<Item = (String, Id)> {
    design.names.keys().filter_map(|name| {
        let state = name.rsplit('.').next()?.strip_suffix("_state_q")?;
        Some((state.to_string(), design.register(name)?))
    })
}

/// The job's values in the design.
struct Values<'d> {
    design: &'d Design,
    operation: &'d str,
    inputs: BTreeMap<&'d str, Term>,
    states: BTreeMap<String, (Id, Term)>,
}

impl JobValues for Values<'_> {
    fn input(&self, port: &str) -> Option<Term> {
        self.inputs.get(format!("{port}_i").as_str()).copied()
    }

    fn state(&self, state: &str) -> Option<Term> {
        self.states.get(&format!("{}_{state}", self.operation)).map(|(_, value)| *value)
    }

    fn output_width(&self, port: &str) -> Option<u32> {
        self.design.outputs.get(&format!("{port}_o")).map(|id| self.design.nodes[id].width)
    }
}
