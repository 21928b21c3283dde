//! Divides a combinational module into parts with registers to come between them.
//!
//! By a model of delays, a period has as many parts as the longest path needs. Where each cut may be follows from the
//! period and the paths to and from a signal; of all places, a minimum cut finds the one with the fewest bits.

mod cut;
mod parts;
mod paths;

use crate::Error;
use crate::depth::Technology;
use crate::netlist::{Driver, Module, Signal, SignalId};
use parts::Division;
use paths::Paths;
use std::sync::Arc;

/// The parts of `module`, in the order of computation. Connected, they compute the same: output port `x_o` of a part
/// drives input port `x_i` of the next. The modules are `<module>_part_1_of_<count>` and so on; with a `count` of 1, the
/// module itself. A product (`*`) has a part without other gates before or after it, for the registers of an FPGA's
/// multipliers, if the technology has them.
///
/// A longer period has fewer bits between the parts: the period is that for which the period, times the gates of the
/// module and of the bits, is least. `bit_gates` are those of a bit; with 0 the period is the shortest.
///
/// # Errors
/// No part; registers, memories or instances in the module.
pub fn divide(
    module: &Arc<Module>,
    count: u32,
    technology: Technology,
    bit_gates: f64,
) -> Result<Vec<Arc<Module>>, Error> {
    let refused = |problem: &str| Error::Name {
        module: module.name.clone(),
        name: format!("part_1_of_{count}"),
        problem: problem.to_string(),
    };
    if count == 0 {
        return Err(refused("does not exist: a module has one part or more"));
    }
    if module.is_clocked() || !module.instances.is_empty() {
        return Err(refused("does not exist: a module with registers or instances is not divided"));
    }
    if count == 1 {
        return Ok(vec![module.clone()]);
    }
    let paths = Paths::new(module, technology);
    let gates = module.gates_of_two_inputs();
    let shortest = paths.shortest_period(count as usize);
    let longer = LONGER.iter().take(if bit_gates > 0.0 { LONGER.len() } else { 1 });
    let divisions = longer.map(|longer| {
        let division = Division::new(module, paths.place(count as usize, shortest * longer), count as usize);
        (shortest * longer * (gates + f64::from(division.bits()) * bit_gates), division)
    });
    let best = divisions.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, division)| division);
    Ok((0..count as usize).filter_map(|part| Some(Arc::new(best.as_ref()?.part(part)))).collect())
}

/// The periods that are tried, in shortest ones.
const LONGER: [f64; 6] = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5];

/// Whether each signal is one of `roots` or one that they depend on.
fn needed(module: &Module, roots: impl Iterator<Item = SignalId>) -> Vec<bool> {
    let mut is_needed = vec![false; module.signals.len()];
    let mut open: Vec<SignalId> = roots.collect();
    while let Some(id) = open.pop() {
        if !std::mem::replace(&mut is_needed[id.index()], true) {
            open.extend(module.signal(id).driver.operands());
        }
    }
    is_needed
}

/// A constant is in each part that reads it, and crosses no cut.
fn is_constant(signal: &Signal) -> bool {
    matches!(signal.driver, Driver::Constant(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::netlist::Port;
    use crate::{Builder, Simulator, verilog};
    use std::collections::BTreeMap;

    /// Sums, a product, a shift, a word of which later parts read some bits, and one that goes to an output at once.
    fn subject() -> Arc<Module> {
        let m = Builder::new("subject");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 12));
        let sum = (a + b).named("sum");
        let product = (sum.lower(6) * b.lower(6)).named("product");
        let shifted = product.shift_right(a.lower(4)).named("shifted");
        let ends = m.concat(&[sum.top(), sum.bit(0)]);
        m.section("The result");
        let result = (shifted + ends.extend(12)).named("result");
        m.output("early_o", a.top());
        m.output("result_o", result);
        m.unused("unused_b", &[b.top()]);
        // Nothing reads it.
        let _ = product.any() & !shifted.any();
        m.finish().expect("a module")
    }

    fn results(parts: &[Arc<Module>], a: u64, b: u64) -> Vec<u64> {
        let mut values = BTreeMap::from([("a".to_string(), a), ("b".to_string(), b)]);
        let mut outputs = Vec::new();
        for part in parts {
            let mut simulator = Simulator::new(part).expect("no loop");
            outputs = simulator.evaluate(part.inputs().iter().map(|port| values[port.stem()])).to_vec();
            values = part.outputs().iter().map(|port| port.stem().to_string()).zip(outputs.iter().copied()).collect();
        }
        outputs
    }

    #[test]
    fn parts_compute_the_same() {
        let whole = subject();
        for (technology, count) in
            [Technology::Gates, Technology::Luts].into_iter().flat_map(|t| (1..9).map(move |c| (t, c)))
        {
            for bit_gates in [0.0, 100.0] {
                let parts = divide(&whole, count, technology, bit_gates).expect("parts");
                assert_eq!(parts.len(), count as usize);
                for (part, next) in parts.iter().zip(&parts[1..]) {
                    let read: Vec<SignalId> = next.signals.iter().flat_map(|signal| signal.driver.operands()).collect();
                    let is_read = |port: &Port| {
                        read.contains(&port.signal) || next.outputs.iter().any(|output| output.signal == port.signal)
                    };
                    assert!(next.inputs.iter().all(is_read), "{}, {}", part.name, next.name);
                }
                for (a, b) in [(0, 0), (0xfff, 0xfff), (0x123, 0x9ab), (0x801, 0x7ff), (5, 0x2a), (0xc3f, 0x3c)] {
                    let sum = (a + b) & 0xfff;
                    let shifted = ((sum & 63) * (b & 63)) >> (a & 15);
                    let expected = [a >> 11, (shifted + (sum >> 11 << 1 | sum & 1)) & 0xfff];
                    assert_eq!(results(&parts, a, b), expected, "{technology:?}, {count}: {a:#x}, {b:#x}");
                }
            }
        }
    }

    #[test]
    fn a_part_takes_no_longer_than_the_period_and_a_longer_one_has_fewer_bits() {
        let whole = subject();
        let shortest_period = |count| Paths::new(&whole, Technology::Gates).shortest_period(count as usize);
        let bits = |parts: &[Arc<Module>]| -> u32 {
            parts[1..].iter().flat_map(|part| part.inputs().iter().map(|port| part.signal(port.signal).width)).sum()
        };
        for count in 2..5 {
            let shortest = shortest_period(count);
            let [tight, loose] =
                [0.0, 1e6].map(|bit_gates| divide(&whole, count, Technology::Gates, bit_gates).expect("parts"));
            for (number, part) in tight.iter().enumerate() {
                // The inputs of the first part alone arrive late.
                let arrival = if number == 0 { 0.0 } else { Technology::Gates.arrival() };
                let longest = Paths::new(part, Technology::Gates).shortest_period(1) - arrival;
                // A port is a load that the whole does not have.
                assert!(longest <= shortest * 1.05, "{count}: {longest} in {shortest}");
            }
            assert!(bits(&loose) <= bits(&tight), "{count}");
        }
        let [three, four] = [3, 4].map(shortest_period);
        assert!(four <= three);
    }

    /// The multiplier of an FPGA has its registers before and behind the product.
    #[test]
    fn a_product_is_alone_in_its_part() {
        let parts = divide(&subject(), 4, Technology::Luts, 0.0).expect("parts");
        let product = parts.iter().find(|part| part.signals().iter().any(|s| matches!(s.driver, Driver::Mul(..))));
        let text = verilog::text(product.expect("a product")).expect("text");
        assert!(text.contains("product_o") && !text.contains(" + ") && !text.contains(">>"), "{text}");
    }

    #[test]
    fn products_are_in_one_part() {
        let m = Builder::new("subject");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 12));
        // One of them has few bits, and is needed late.
        let [low, high] = [a.lower(9) * b.lower(9), a.upper(3) * b.upper(3)];
        m.output("result_o", (low + low.lower(9).extend(18)).upper(6) ^ high);
        let parts = divide(&m.finish().expect("a module"), 6, Technology::Luts, 0.0).expect("parts");
        let products = |part: &Arc<Module>| part.signals.iter().filter(|s| matches!(s.driver, Driver::Mul(..))).count();
        let counts: Vec<usize> = parts.iter().map(products).filter(|count| *count > 0).collect();
        assert_eq!(counts, [2]);
    }

    #[test]
    fn what_is_not_divided() {
        let m = Builder::new("clocked");
        let register = m.register("a_q", 1);
        register.next(m.input("a_i", 1));
        m.output("a_o", register.wire());
        let clocked = m.finish().expect("a module");
        for (module, count) in [(&clocked, 2), (&subject(), 0)] {
            let problem = divide(module, count, Technology::Gates, 0.0).expect_err("no parts").to_string();
            assert!(problem.contains("does not exist"), "{problem}");
        }
    }
}
