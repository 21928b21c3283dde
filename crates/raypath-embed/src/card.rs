//! The card of a design: the figures that architecture simulators need, as one JSON document.

use crate::{Datapath, Error, Unit};
use raypath_hdl::Module;
use raypath_rtl::package::all_ports;
use serde_json::{Map, Value, json};

/// A document, whose fields `docs/integration/simulators.md` lists. The object `absent` says why others are null.
#[derive(Debug, Clone, PartialEq)]
pub struct Card(Value);

/// The version of the document. It changes when a reader of the old one would be wrong.
const VERSION: u64 = 1;
/// Where the time of a traversal unit is.
const OF_UNIT: &str = "depends on the ray, the scene and the memory; the cycle-exact model has it";

impl Card {
    fn of(top: &Module, design: &str) -> Self {
        let ports = all_ports(top).into_iter().map(|port| {
            let direction = if port.is_input { "input" } else { "output" };
            json!({"name": port.name, "width": port.width, "direction": direction})
        });
        let mut units = Map::new();
        count_units(top, &mut units);
        let mut card = Self(json!({
            "card_version": VERSION, "raypath_version": env!("CARGO_PKG_VERSION"), "absent": {},
            "design": design, "module": top.name(), "ports": ports.collect::<Value>(), "operations": {},
            "units": units, "register_bits": top.register_bits(), "memory_bits": top.memory_bits(),
        }));
        card.lack("raypath_commit", "this build does not know its commit");
        card.lack("measured", "not measured, which `raypath card --liberty FILE` does");
        card.lack("idle_pj_per_cycle", "not measured, which `--liberty FILE --power` does");
        card
    }

    fn lack(&mut self, field: &str, reason: &str) {
        self.0[field] = Value::Null;
        self.0["absent"][field] = reason.into();
    }

    /// The document.
    pub fn to_json(&self) -> String {
        format!("{:#}", self.0)
    }

    /// Gives a value to a field.
    pub fn set(&mut self, field: &str, value: Value) {
        self.0[field] = value;
        self.0["absent"].as_object_mut().and_then(|absent| absent.remove(field));
    }

    /// Reads a document.
    ///
    /// # Errors
    /// Text that is not JSON; another version.
    pub fn read(text: &str) -> Result<Self, Error> {
        let wrong = |problem| Error::Argument(format!("card: {problem}, expected what `raypath card` writes"));
        let card: Value = serde_json::from_str(text).map_err(wrong)?;
        if card["card_version"] == VERSION {
            return Ok(Self(card));
        }
        Err(Error::Argument(format!("card: card_version is {}, expected {VERSION}", card["card_version"])))
    }

    /// What is at a JSON pointer, such as `/operations/quadbox/pj_per_job`.
    ///
    /// # Errors
    /// Nothing is there. The message has the reason that the card states.
    pub fn at(&self, pointer: &str) -> Result<&Value, Error> {
        let found = self.0.pointer(pointer).filter(|value| !value.is_null());
        let mut reasons = pointer.split('/').filter_map(|field| self.0["absent"].get(field)?.as_str());
        let reason = reasons.next_back().unwrap_or("expected a field of it");
        found.ok_or_else(|| Error::Argument(format!("the card has no {pointer}: {reason}")))
    }

    /// The number at a JSON pointer.
    ///
    /// # Errors
    /// Those of [`at`](Self::at); another value than a number.
    pub fn number(&self, pointer: &str) -> Result<f64, Error> {
        let value = self.at(pointer)?;
        value.as_f64().ok_or_else(|| Error::Argument(format!("{pointer} of the card: {value}, expected a number")))
    }
}

/// Counts the floating-point units in a module and below it, by the names of their modules without `raypath_fp_`.
fn count_units(module: &Module, units: &mut Map<String, Value>) {
    for instance in module.instances() {
        match instance.module.name().strip_prefix("raypath_fp_") {
            Some(kind) => {
                let count = units.get(kind).and_then(Value::as_u64).unwrap_or(0);
                units.insert(kind.to_string(), (count + 1).into());
            }
            None => count_units(&instance.module, units),
        }
    }
}

impl Datapath {
    /// The card, without measured figures.
    pub fn card(&self) -> Card {
        let (shape, mut card) = (self.shape(), Card::of(self.netlist().top(), self.description()));
        card.set("latency_cycles", shape.latency.into());
        card.set("interval_cycles", shape.interval.into());
        let operations = self.operations().into_iter().map(|operation| {
            let (opcode, interval) = (operation.opcode(), shape.interval(operation.opcode()));
            (operation.name().to_string(), json!({"opcode": opcode, "interval_cycles": interval}))
        });
        card.set("operations", operations.collect());
        card
    }
}

impl Unit {
    /// The card, without measured figures.
    pub fn card(&self) -> Card {
        let mut card = Card::of(&self.netlist().top, self.description());
        card.lack("latency_cycles", OF_UNIT);
        card.lack("interval_cycles", OF_UNIT);
        card.lack("idle_pj_per_cycle", "`raypath ppa --power` measures datapaths only");
        card
    }
}
