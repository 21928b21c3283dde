//! A design, divided into blocks for synthesis: each kind of unit once, and everything around the units.

use crate::Error;
use raypath_hdl::{Module, expose_memories, verilog};
use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::sync::Arc;

/// A netlist to measure, and its name in reports.
#[derive(Debug, Clone)]
pub struct Design {
    /// The name in reports.
    pub name: String,
    /// Bits of the words of its memories.
    pub(crate) memory_bits: u64,
    /// Without memories.
    top: Arc<Module>,
}

/// The prefix of the module names of units. Units are synthesised once each and are not flattened.
const UNIT_PREFIX: &str = "raypath_fp_";

/// A part of a design that is synthesised on its own.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// The top module of the block.
    pub module: String,
    /// SystemVerilog of the module and all modules below it. Of units inside, only the ports.
    pub text: String,
    pub is_unit: bool,
    /// Whether its text instantiates clock gates, whose module it lacks.
    pub has_clock_gates: bool,
    /// Words of the text that hold several registers of the netlist.
    pub words: Words,
}

/// Words of the flattened text, such as `u_stage_3.u_skid.data_q`, and the names and widths of the registers that they
/// hold, the most significant first.
pub(crate) type Words = BTreeMap<String, Vec<(String, u32)>>;

/// The operation of a unit, and its part if the unit is pipelined in several parts.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct UnitKind {
    /// The operation: `add`, `mul`, ...
    pub stem: String,
    /// The part, from 1, and the number of parts.
    pub part: Option<(u32, u32)>,
}

/// The group and purpose of a register.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RegisterKind {
    /// The index in [`Design::groups`].
    pub group: usize,
    /// Whether it belongs to the handshake: valid, ready, counters. Other registers hold a job's data or an operation's
    /// state.
    pub is_control: bool,
}

impl Design {
    /// A design named `name`, whose top module consists of instances, the stages. The report has a line for each.
    ///
    /// Memories are macros of another technology: the report has their bits, and what surrounds them is measured with
    /// ports in their place.
    pub fn new(name: impl Into<String>, top: &Arc<Module>) -> Self {
        Self { name: name.into(), memory_bits: top.memory_bits(), top: expose_memories(top) }
    }

    pub(crate) fn top(&self) -> &str {
        self.top.name()
    }

    /// The netlist that is synthesised.
    pub(crate) fn netlist(&self) -> &Arc<Module> {
        &self.top
    }

    /// The blocks to synthesise: each kind of unit, and last everything else.
    pub(crate) fn blocks(&self) -> Result<Vec<Block>, Error> {
        let modules = verilog::modules(&self.top)?;
        let units: Vec<&Arc<Module>> = modules.iter().filter(|module| is_unit(module)).collect();
        let mut inside_units = HashSet::new();
        let mut blocks = Vec::new();
        let mut surroundings = String::new();
        for unit in units {
            let mut text = String::new();
            for source in verilog::sources(unit, &[])? {
                text += &source.text;
                inside_units.insert(source.name);
            }
            surroundings += &ports_only(unit)?;
            blocks.push(Block {
                module: unit.name().to_string(),
                text,
                is_unit: true,
                has_clock_gates: false,
                words: Words::new(),
            });
        }
        let mut has_clock_gates = false;
        for source in verilog::sources(&self.top, &[])? {
            if source.name == verilog::CLOCK_GATE {
                has_clock_gates = true;
            } else if !inside_units.contains(&source.name) {
                surroundings += &source.text;
            }
        }
        let mut words = Words::new();
        walk(&self.top, "", &mut |module, path| {
            for (word, registers) in module.banked_registers() {
                let registers = registers.into_iter().map(|(name, width)| (format!("{path}{name}"), width)).collect();
                words.insert(format!("{path}{word}"), registers);
            }
        });
        let module = self.top().to_string();
        blocks.push(Block { module, text: surroundings, is_unit: false, has_clock_gates, words });
        Ok(blocks)
    }

    /// The names of the instances in the top module, such as `u_stage_3`, in order; last the top module's own name, for
    /// cells outside of all instances.
    pub(crate) fn groups(&self) -> Vec<String> {
        let instances = self.top.instances().iter().map(|instance| instance.name.clone());
        instances.chain([self.top().to_string()]).collect()
    }

    /// All registers outside of units by their names in the flattened design: `u_stage_3.num_4_q`.
    pub(crate) fn registers(&self) -> BTreeMap<String, RegisterKind> {
        let mut found = BTreeMap::new();
        let instances = self.top.instances();
        own_registers(&self.top, "", instances.len(), &mut found);
        for (group, instance) in instances.iter().enumerate() {
            let path = format!("{}.", instance.name);
            walk(&instance.module, &path, &mut |module, path| own_registers(module, path, group, &mut found));
        }
        found
    }
}

impl UnitKind {
    /// Parses the name of a unit's module: `raypath_fp_mul_e8s24_part_1_of_2`.
    pub fn of(module: &str) -> Option<Self> {
        let name = module.strip_prefix(UNIT_PREFIX)?;
        let stem = name.split('_').next()?.to_string();
        let part = name.rsplit_once("_part_").and_then(|(_, part)| {
            let (part, of) = part.split_once("_of_")?;
            Some((part.parse().ok()?, of.parse().ok()?))
        });
        Some(Self { stem, part })
    }
}

impl fmt::Display for UnitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.stem)?;
        self.part.map_or(Ok(()), |(part, of)| write!(f, " {part}/{of}"))
    }
}

/// Whether a module is a unit, which is synthesised on its own.
pub(crate) fn is_unit(module: &Module) -> bool {
    module.name().starts_with(UNIT_PREFIX)
}

/// Calls `visit` with a module and all modules below it but units, each with its path in the flattened design.
fn walk(module: &Module, path: &str, visit: &mut dyn FnMut(&Module, &str)) {
    visit(module, path);
    for instance in module.instances().iter().filter(|instance| !is_unit(&instance.module)) {
        walk(&instance.module, &format!("{path}{}.", instance.name), visit);
    }
}

fn own_registers(module: &Module, path: &str, group: usize, found: &mut BTreeMap<String, RegisterKind>) {
    for register in module.registers() {
        let Some(name) = &module.signal(register.signal).name else { continue };
        // Data registers have no reset. A register with one is an operation's state, by its name, or control.
        let is_control = register.reset.is_some() && !name.ends_with("_state_q");
        found.insert(format!("{path}{name}"), RegisterKind { group, is_control });
    }
}

/// A module's ports without its body, marked to be kept when the modules around it are flattened.
fn ports_only(module: &Module) -> Result<String, Error> {
    let text = verilog::print_module(module, &[])?;
    let code = text.lines().skip_while(|line| line.starts_with("//") || line.is_empty());
    let mut lines = vec!["(* keep_hierarchy *)"];
    for line in code {
        lines.push(line);
        if line == ");" {
            break;
        }
    }
    lines.push("endmodule\n");
    Ok(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_hdl::Builder;

    fn unit() -> Arc<Module> {
        let m = Builder::new("raypath_fp_mul_e8s24_part_1_of_2");
        let a = m.input("a_i", 8);
        m.output("a_o", !a);
        m.finish().expect("a unit")
    }

    fn stage() -> Arc<Module> {
        let control = Builder::new("raypath_skid");
        let full = control.register("full_q", 1).reset_to(0);
        full.next(!full.wire());
        control.output("full_o", full.wire());
        let control = control.finish().expect("control");

        let m = Builder::new("raypath_stage_1");
        let a = m.input("a_i", 8);
        let product = m.instance("u_mul_0", &unit(), &[("a_i", a)])[0];
        let sum = m.register("sum_state_q", 8).reset_to(0);
        sum.next(sum.wire() + product);
        let data = m.register("num_0_q", 8);
        data.next(sum.wire());
        m.output("a_o", data.wire());
        m.output("full_o", m.instance("u_skid", &control, &[])[0]);
        m.finish().expect("a stage")
    }

    fn design() -> Design {
        let m = Builder::new("raypath");
        let a = m.input("a_i", 8);
        let outputs = m.instance("u_stage_1", &stage(), &[("a_i", a)]);
        m.output("a_o", outputs[0]);
        m.output("full_o", outputs[1]);
        Design::new("small", &m.finish().expect("a design"))
    }

    #[test]
    fn units_are_blocks() {
        let blocks = design().blocks().expect("blocks");
        let names: Vec<&str> = blocks.iter().map(|piece| piece.module.as_str()).collect();
        assert_eq!(names, ["raypath_fp_mul_e8s24_part_1_of_2", "raypath"]);
        let [unit, rest] = &blocks[..] else { unreachable!("two blocks") };
        assert!(unit.is_unit && unit.text.contains("~a_i") && !unit.text.contains("raypath_skid"), "{}", unit.text);
        assert!(
            !rest.is_unit && rest.text.contains("module raypath_skid") && !rest.text.contains("~a_i"),
            "{}",
            rest.text
        );
        assert!(rest.text.starts_with("(* keep_hierarchy *)\nmodule raypath_fp_mul_e8s24_part_1_of_2 ("));
    }

    #[test]
    fn registers_are_control_state_or_data() {
        let registers = design().registers();
        let control = |name: &str| registers.get(name).map(|kind| (kind.group, kind.is_control));
        assert_eq!(control("u_stage_1.u_skid.full_q"), Some((0, true)));
        assert_eq!(control("u_stage_1.sum_state_q"), Some((0, false)));
        assert_eq!(control("u_stage_1.num_0_q"), Some((0, false)));
        assert_eq!(registers.len(), 3);
        assert_eq!(design().groups(), ["u_stage_1", "raypath"]);
    }

    #[test]
    fn kinds_of_units() {
        let kind = |module| UnitKind::of(module).map(|kind| kind.to_string());
        assert_eq!(kind("raypath_fp_add_e8s24"), Some("add".to_string()));
        assert_eq!(kind("raypath_fp_mul_e8s24_part_1_of_2"), Some("mul 1/2".to_string()));
        assert_eq!(kind("raypath_skid"), None);
    }
}
