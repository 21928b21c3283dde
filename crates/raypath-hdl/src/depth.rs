//! The longest path through a hierarchy of modules, for estimates of timing.

use crate::Error;
use crate::flatten::loop_free;
use crate::graph::{Graph, Operation};
use crate::netlist::{Driver, Module, Signal, SignalId};
use std::sync::Arc;

/// The longest path between registers, memories and ports of `module` and everything inside it: the sum of the delays
/// along it, in the unit of `delay`.
///
/// `delay` gets the operator, register or input that drives a signal, the widths of its operands, the signal's width,
/// and the bits that each of its bits drives: a select signal of a multiplexer drives one for each bit of the word.
///
/// # Errors
/// Signals that depend on themselves.
pub fn longest_path(module: &Arc<Module>, delay: impl Fn(&Driver, &[u32], u32, u64) -> f64) -> Result<f64, Error> {
    let graph = loop_free(module)?;
    let order = graph.order(std::iter::empty()).map_err(|_| Error::Loop(vec![module.name().to_string()]))?;

    let registers = graph.registers.iter().flat_map(|register| [Some(register.next), register.enable]).flatten();
    let memories = graph.memories.iter().flat_map(|memory| memory.inputs()).copied();
    let outputs = module.outputs().iter().map(|port| port.signal);
    let ends: Vec<SignalId> = registers.chain(memories).chain(outputs).collect();
    let loads = loads(&graph, &order, &ends);
    let mut arrivals = vec![0.0_f64; graph.nodes.len()];
    for &node in &order {
        let operands = graph.operands(node);
        let begin = operands.iter().map(|operand| arrivals[operand.index()]).fold(0.0, f64::max);
        let widths: Vec<u32> = operands.iter().map(|operand| graph.nodes[operand.index()].width).collect();
        let (width, load) = (graph.nodes[node.index()].width, loads[node.index()]);
        arrivals[node.index()] = match &graph.nodes[node.index()].operation {
            // Wires alone: their source drives what they drive.
            Operation::Operator(driver) if driver.is_wiring() => begin,
            Operation::Operator(driver) => begin + delay(driver, &widths, width, load),
            Operation::Register(register) => delay(&Driver::Register(*register), &[], width, load),
            _ => delay(&Driver::Input, &[], width, load),
        };
    }
    Ok(ends.iter().map(|end| arrivals[end.index()]).fold(0.0, f64::max))
}

/// The bits that each bit of a node drives, at most. What no end depends on is no load.
fn loads(graph: &Graph, order: &[SignalId], ends: &[SignalId]) -> Vec<u64> {
    let mut loads = vec![0_u64; graph.nodes.len()];
    let mut is_live = vec![false; graph.nodes.len()];
    ends.iter().for_each(|end| is_live[end.index()] = true);
    for register in &graph.registers {
        loads[register.next.index()] += 1;
        if let Some(enable) = register.enable {
            let bits = u64::from(graph.nodes[register.signal.index()].width);
            loads[enable.index()] += if register.gated { 1 } else { bits };
        }
    }
    for &node in order.iter().rev() {
        if !is_live[node.index()] {
            continue;
        }
        graph.operands(node).iter().for_each(|operand| is_live[operand.index()] = true);
        let (own, bits) = (loads[node.index()], u64::from(graph.nodes[node.index()].width));
        let Operation::Operator(driver) = &graph.nodes[node.index()].operation else { continue };
        match driver {
            // Wires alone.
            Driver::Alias(source) => loads[source.index()] += own,
            Driver::Concat(parts) => parts.iter().for_each(|part| loads[part.index()] += own),
            // Slices of one word mostly have different bits.
            Driver::Slice { source, .. } => loads[source.index()] = loads[source.index()].max(own),
            Driver::Mux { select, if_true, if_false } => {
                loads[select.index()] += bits;
                [if_true, if_false].iter().for_each(|value| loads[value.index()] += 1);
            }
            Driver::Case { selector, arms, default } => {
                loads[selector.index()] += bits;
                arms.iter().map(|arm| arm.value).chain([*default]).for_each(|value| loads[value.index()] += 1);
            }
            driver => driver.operands().for_each(|operand| loads[operand.index()] += 1),
        }
    }
    loads
}

/// The [loads](longest_path) of the signals of a module without instances.
pub(crate) fn loads_of(module: &Arc<Module>) -> Vec<u64> {
    let graph = Graph::new(module, |_, _| false);
    let ends: Vec<SignalId> = module.outputs().iter().map(|port| port.signal).collect();
    let order = graph.order(std::iter::empty()).unwrap_or_default();
    loads(&graph, &order, &ends)
}

/// What operators become, for a model of their delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Technology {
    /// Gates of two inputs, with a tree of buffers where a signal drives many; the unit is the delay of a gate.
    Gates,
    /// Lookup tables of four inputs, carry chains and multipliers of an FPGA; the unit is the delay of a table with the
    /// wire to it.
    Luts,
}

impl Technology {
    /// Whether products have multipliers with registers of their own.
    pub(crate) fn has_multipliers(self) -> bool {
        self == Self::Luts
    }

    /// When the inputs of a unit arrive: its operands are selected before.
    pub(crate) fn arrival(self) -> f64 {
        match self {
            Self::Gates => 9.0,
            Self::Luts => 1.2,
        }
    }

    /// The delay of an operator with operands of these widths, whose result has `width` bits that drive `load` bits
    /// each.
    pub fn delay(self, driver: &Driver, operands: &[u32], width: u32, load: u64) -> f64 {
        match self {
            Self::Gates => gates(driver, operands, width, load),
            Self::Luts => luts(driver, operands, width, load),
        }
    }
}

/// Rounded from the fastest circuits that ABC makes of single operators in sky130, where a gate takes about 70 ps.
fn gates(driver: &Driver, operands: &[u32], width: u32, load: u64) -> f64 {
    let levels = |count: u32| f64::from(count.max(1)).log2();
    let operand = operands.first().copied().unwrap_or(1);
    let own = match driver {
        Driver::And(..) | Driver::Or(..) => 1.0,
        Driver::Not(_) => 0.3,
        Driver::Xor(..) | Driver::Mux { .. } => 1.8,
        Driver::Case { arms, .. } => 1.8 + levels(arms.len() as u32),
        Driver::Add(..) | Driver::Sub(..) => {
            // The carry ripples through the bits of both operands; above the shorter, it passes gates of many inputs.
            let both = operands.iter().copied().min().unwrap_or(width).min(width);
            let passes = if both < width { 1.5 + 0.8 * levels(width - both) } else { 0.0 };
            2.0 + 1.15 * f64::from(both) + passes
        }
        Driver::Mul(..) => 3.0 + 4.0 * levels(width),
        Driver::Equal(..) => 1.6 + levels(operand),
        Driver::Less(..) => 2.4 * levels(operand),
        Driver::Any(_) | Driver::All(_) => 0.8 * levels(operand),
        Driver::ShiftLeft(..) | Driver::ShiftRight(..) => 1.9 * f64::from(operands.get(1).copied().unwrap_or(1).min(6)),
        _ => 0.0,
    };
    // A tree of buffers, four loads each.
    own + 0.5 * (load.max(1) as f64).log2()
}

/// Synthesis puts about two operators of two inputs into a table.
fn luts(driver: &Driver, operands: &[u32], width: u32, load: u64) -> f64 {
    let inputs = |count: u32| f64::from(count.max(2)).log2() / 2.0;
    let chain = |bits: u32| 0.9 + 0.03 * f64::from(bits);
    let operand = operands.first().copied().unwrap_or(1);
    let own = match driver {
        Driver::Not(_) => 0.0,
        Driver::And(..) | Driver::Or(..) | Driver::Xor(..) => 0.5,
        Driver::Mux { .. } => 0.75,
        Driver::Case { arms, .. } => inputs(2 * arms.len() as u32) + 0.5,
        Driver::Add(..) | Driver::Sub(..) => chain(width),
        Driver::Mul(..) => 3.0,
        Driver::Equal(..) => inputs(2 * operand),
        Driver::Less(..) => chain(operand),
        Driver::Any(_) | Driver::All(_) => inputs(operand),
        Driver::ShiftLeft(..) | Driver::ShiftRight(..) => f64::from(operands.get(1).copied().unwrap_or(1).min(6)),
        _ => 0.0,
    };
    // Longer wires.
    if own > 0.0 { own + 0.05 * (load.max(1) as f64).log2() } else { own }
}

impl Module {
    /// An estimate of the gates of two inputs of an operator that is not a multiplexer.
    pub fn gates_of(&self, signal: &Signal) -> f64 {
        let width = |id: &SignalId| f64::from(self.signal(*id).width);
        let own = f64::from(signal.width);
        match &signal.driver {
            Driver::And(..) | Driver::Or(..) => own,
            Driver::Not(_) => 0.5 * own,
            Driver::Xor(..) => 2.0 * own,
            Driver::Add(..) | Driver::Sub(..) => 6.0 * own,
            Driver::Mul(a, b) => 6.0 * width(a) * width(b),
            Driver::Equal(a, _) => 3.0 * width(a),
            Driver::Less(a, _) => 4.0 * width(a),
            Driver::Any(a) | Driver::All(a) => width(a),
            Driver::ShiftLeft(_, amount) | Driver::ShiftRight(_, amount) => 3.0 * own * width(amount),
            _ => 0.0,
        }
    }

    /// An estimate of the gates of two inputs of a module, without its instances.
    pub(crate) fn gates_of_two_inputs(&self) -> f64 {
        let gates = |signal: &Signal| match signal.driver {
            Driver::Mux { .. } => 3.0 * f64::from(signal.width),
            _ => self.gates_of(signal),
        };
        self.signals().iter().map(gates).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Builder;

    /// One for each gate, and the logarithm of the load where there is more than one reader.
    fn levels(driver: &Driver, _: &[u32], _: u32, load: u64) -> f64 {
        let own = match driver {
            Driver::And(..) | Driver::Or(..) | Driver::Xor(..) | Driver::Mux { .. } | Driver::Not(_) => 1.0,
            _ => 0.0,
        };
        own + (load.max(1) as f64).log2()
    }

    /// From a register, through another module, to a multiplexer of eight bits.
    #[test]
    fn paths_pass_instances_and_end_at_registers() {
        let inner = Builder::new("inner");
        let a = inner.input("a_i", 1);
        inner.output("a_o", !(!a));
        let inner = inner.finish().expect("a module");

        let m = Builder::new("outer");
        let (select, word) = (m.register("select_q", 1).reset_to(0), m.register("word_q", 8));
        let chosen = m.input("chosen_i", 1);
        select.next(chosen);
        let passed = m.instance("u_inner", &inner, &[("a_i", select.wire())])[0];
        let sum = word.wire() ^ m.input("other_i", 8);
        word.next(passed.mux(sum, word.wire()));
        m.output("passed_o", passed & chosen);
        let outer = m.finish().expect("a module");

        // The builder removes a double negation, so the instance adds no gate; a gate that is left without a reader is
        // no load. The select drives eight bits of the multiplexer and a gate: log2(9), and 1 of the multiplexer. The
        // path from the word is shorter: it drives two gates, log2(2), and passes two.
        let found = longest_path(&outer, levels).expect("no loop");
        assert!((found - (9_f64.log2() + 1.0)).abs() < 1e-9, "{found}");
    }
}
