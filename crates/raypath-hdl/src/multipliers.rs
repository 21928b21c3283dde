//! Multipliers with registers of their own in place of products.

use crate::Error;
use crate::names::fresh;
use crate::netlist::{Driver, Instance, Item, Module, Signal, SignalId};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

/// A part of a divided module whose products have multipliers.
#[derive(Debug, Clone)]
pub struct WithMultipliers {
    /// The part with an instance for each product.
    pub module: Arc<Module>,
    /// The stems of the input ports that multipliers read: their registers are those before the part.
    pub inputs: BTreeSet<String>,
    /// The stems of the output ports that show bits of products: their registers are those behind the part.
    pub outputs: BTreeSet<String>,
}

/// Puts a multiplier in place of each product of a part that [`divide`](crate::divide()) has made for them: the module
/// that `multiplier` gives for the widths of the operands, with the input ports `a_i` and `b_i` and an output port.
///
/// # Errors
/// Gates between a port and a product, or no product; those of `multiplier`.
pub fn with_multipliers(
    part: &Arc<Module>,
    multiplier: impl Fn(u32, u32) -> Result<Arc<Module>, Error>,
) -> Result<WithMultipliers, Error> {
    let refused = || Error::Name {
        module: part.name.clone(),
        name: "products".to_string(),
        problem: "have gates before or behind them, expected ports".to_string(),
    };
    let is_product = |id: &SignalId| matches!(part.signal(*id).driver, Driver::Mul(..));
    // What the products read, and what gates do.
    let [factors, others] = [true, false].map(|of_products| -> BTreeSet<SignalId> {
        let is_one =
            |signal: &&Signal| !signal.driver.is_wiring() && matches!(signal.driver, Driver::Mul(..)) == of_products;
        let operands = part.signals.iter().filter(is_one).flat_map(|signal| signal.driver.operands());
        operands.flat_map(|id| sources(part, id)).collect()
    });
    let is_apart = |id: &SignalId| !is_product(id) && !factors.contains(id);
    let are_inputs = factors.iter().all(|id| matches!(part.signal(*id).driver, Driver::Input));
    let mut outputs = BTreeSet::new();
    for port in &part.outputs {
        let shown = sources(part, port.signal);
        if shown.iter().any(is_product) && shown.iter().all(is_product) {
            outputs.insert(port.stem().to_string());
        } else if !shown.iter().all(is_apart) {
            return Err(refused());
        }
    }
    if outputs.is_empty() || !are_inputs || !others.iter().all(is_apart) {
        return Err(refused());
    }
    let inputs = part.inputs.iter().filter(|port| factors.contains(&port.signal));
    let inputs = inputs.map(|port| port.stem().to_string()).collect();

    let mut module = Module::clone(part);
    let mut taken: HashSet<String> = part.names().collect();
    let mut made: BTreeMap<[u32; 2], Arc<Module>> = BTreeMap::new();
    for index in 0..module.signals.len() {
        let Driver::Mul(a, b) = module.signals[index].driver else { continue };
        let id = SignalId(index as u32);
        let widths = [a, b].map(|id| module.signal(id).width);
        if let Entry::Vacant(entry) = made.entry(widths) {
            entry.insert(multiplier(widths[0], widths[1])?);
        }
        let instance = module.instances.len();
        let stem = module.signals[index].name.clone().unwrap_or_else(|| fresh(&mut taken, &format!("product_{index}")));
        let name = fresh(&mut taken, &format!("u_{stem}"));
        module.signals[index].name = Some(stem);
        module.signals[index].driver = Driver::Instance { instance, output: 0 };
        module.instances.push(Instance { name, module: made[&widths].clone(), inputs: vec![a, b], outputs: vec![id] });
        let place = module.items.iter().position(|item| *item == Item::Signal(id));
        match place {
            Some(place) => module.items[place] = Item::Instance(instance),
            None => module.items.push(Item::Instance(instance)),
        }
    }
    Ok(WithMultipliers { module: Arc::new(module), inputs, outputs })
}

/// The signals that wires lead to this one, but constants.
fn sources(module: &Module, id: SignalId) -> Vec<SignalId> {
    let signal = module.signal(id);
    match signal.driver {
        Driver::Constant(_) => Vec::new(),
        _ if signal.driver.is_wiring() => signal.driver.operands().flat_map(|id| sources(module, id)).collect(),
        _ => vec![id],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Builder, Simulator, Technology, divide};

    fn multiplier(a: u32, b: u32) -> Result<Arc<Module>, Error> {
        let m = Builder::new("raypath_mul");
        let [a, b] = [("a", a), ("b", b)].map(|(name, width)| {
            let register = m.register(&format!("{name}_q"), width);
            register.next(m.input(&format!("{name}_i"), width));
            register.wire()
        });
        let product = m.register("product_q", a.width() + b.width());
        product.next(a * b);
        m.output("product_o", product.wire());
        m.finish()
    }

    /// The product of a sum's halves, with a word that passes.
    fn part() -> Arc<Module> {
        let m = Builder::new("subject");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 8));
        let sum = (a + b).named("sum");
        let product = (sum.upper(4) * sum.lower(4)).named("product");
        m.output("result_o", product ^ a);
        let parts = divide(&m.finish().expect("a module"), 4, Technology::Luts, 0.0).expect("parts");
        let has_product = |part: &&Arc<Module>| part.signals.iter().any(|s| matches!(s.driver, Driver::Mul(..)));
        parts.iter().find(has_product).expect("a product").clone()
    }

    #[test]
    fn a_product_has_the_registers_of_its_multiplier() {
        let with = with_multipliers(&part(), multiplier).expect("multipliers");
        assert_eq!([with.inputs.len(), with.outputs.len(), with.module.instances().len()], [1, 1, 1]);
        let mut simulator = Simulator::new(&with.module).expect("no loop");
        let place = |ports: &[crate::netlist::Port], stem: &BTreeSet<String>| {
            ports.iter().position(|port| stem.contains(port.stem())).expect("a port")
        };
        let (input, output) = (place(with.module.inputs(), &with.inputs), place(with.module.outputs(), &with.outputs));
        let mut seen = Vec::new();
        for word in [0xff, 0x5a, 0x31, 0, 0] {
            let inputs = (0..with.module.inputs().len()).map(|port| if port == input { word } else { 0 });
            seen.push(simulator.evaluate(inputs)[output]);
            simulator.cycle();
        }
        assert_eq!(seen[2..], [15 * 15, 5 * 10, 3]);
    }

    #[test]
    fn gates_before_or_behind_a_product_are_refused() {
        for (before, behind) in [(true, false), (false, true)] {
            let m = Builder::new("subject");
            let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 4));
            let product = (if before { !a } else { a } * b).named("product");
            m.output("product_o", if behind { !product } else { product });
            let refused = with_multipliers(&m.finish().expect("a module"), multiplier).map(|with| with.inputs);
            assert!(refused.expect_err("gates").to_string().contains("expected ports"));
        }
    }
}
