//! The cells of a synthesised design, by stage.

use crate::flow::DESIGN;
use crate::report::Cells;
use crate::shell::INSTANCE;
use raypath_hdl::Module;
use raypath_tools::ToolError;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The part of Yosys's JSON that is read here.
#[derive(Deserialize)]
struct Design {
    modules: BTreeMap<String, RawModule>,
}

#[derive(Deserialize)]
struct RawModule {
    #[serde(default)]
    cells: BTreeMap<String, Cell>,
    #[serde(default)]
    netnames: BTreeMap<String, Net>,
}

/// A cell.
#[derive(Deserialize)]
pub(crate) struct Cell {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    attributes: Attributes,
    #[serde(default)]
    connections: BTreeMap<String, Vec<Value>>,
}

#[derive(Deserialize, Default)]
struct Attributes {
    #[serde(default)]
    src: String,
}

#[derive(Deserialize)]
struct Net {
    /// A number, or a constant as text.
    bits: Vec<Value>,
}

/// A synthesised design.
pub(crate) struct Netlist {
    cells: BTreeMap<String, Cell>,
    nets: BTreeMap<String, Net>,
    /// The lines of the text, from 1, at which modules begin.
    heads: Vec<(usize, String)>,
    /// The stages in order, with their modules.
    pub stages: Vec<(String, String)>,
    has_shell: bool,
}

/// What is around the datapath, in reports.
const AROUND: &str = "shell";

/// The part of a traversal unit whose stages are parts too.
const DATAPATH: &str = "datapath";

/// The inputs of flip-flops in names of cells, of an ECP5 and of Xilinx's.
const INPUTS: [&str; 9] = ["DI", "CE", "LSR", "M", "D", "R", "S", "CLR", "PRE"];

impl Netlist {
    /// The module `top` in Yosys's JSON. `text` is what was synthesised. `stages` are those of the design, in a shell
    /// or not.
    ///
    /// # Errors
    /// Not Yosys's JSON, or without the module.
    pub(crate) fn parse(
        json: &str,
        top: &str,
        text: &str,
        stages: Vec<(String, String)>,
        has_shell: bool,
    ) -> Result<Self, ToolError> {
        let unexpected = |found: String| ToolError::unexpected("yosys", found, "its JSON with the top module");
        let mut design: Design = serde_json::from_str(json).map_err(|problem| unexpected(problem.to_string()))?;
        let module = design.modules.remove(top).ok_or_else(|| unexpected(format!("no module {top}")))?;
        let head = |(index, line): (usize, &str)| {
            let name = line.strip_prefix("module ")?.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
            Some((index + 1, name.to_string()))
        };
        let heads = text.lines().enumerate().filter_map(head).collect();
        Ok(Self { cells: module.cells, nets: module.netnames, heads, stages, has_shell })
    }

    /// The numbers of cells by stage.
    pub(crate) fn count(&self) -> BTreeMap<String, Cells> {
        let mut stages: BTreeMap<String, Cells> = BTreeMap::new();
        for (name, cell) in &self.cells {
            stages.entry(self.stage(name)).or_default().count(&cell.kind);
        }
        stages
    }

    /// A cell by nextpnr's name, which has an ending such as `$CCU2_COMB0` if it is a part of the cell.
    pub(crate) fn cell(&self, name: &str) -> Option<&Cell> {
        self.cells.get(name).or_else(|| self.cells.get(name.rsplit_once('$')?.0))
    }

    /// The module and the line of the text that a cell was made of. Lookup tables have none: they are made of many.
    pub(crate) fn place(&self, cell: &Cell) -> Option<(&str, usize)> {
        let mut places = cell.attributes.src.split('|');
        let line = places.find_map(|place| place.strip_prefix(DESIGN)?.strip_prefix(':')?.split('.').next());
        let line = line?.parse().ok()?;
        let above = self.heads.partition_point(|(head, _)| *head <= line).checked_sub(1)?;
        Some((&self.heads[above].1, line))
    }

    /// The number of pins that a net, by nextpnr's name, drives.
    pub(crate) fn readers(&self, net: &str) -> Option<usize> {
        let bits = |name: &str| Some(&self.nets.get(name)?.bits);
        let indexed = || {
            let (name, index) = net.strip_suffix(']')?.rsplit_once('[')?;
            bits(name)?.get(index.parse::<usize>().ok()?)
        };
        let bit = bits(net).and_then(|bits| bits.first()).or_else(indexed)?;
        let pins = self.cells.values().flat_map(|cell| cell.connections.values().flatten());
        pins.filter(|pin| *pin == bit).count().checked_sub(1)
    }

    /// The stage that a cell belongs to: that of the text that it was made of; or that of the register that it leads
    /// to, if its name says so; or that in its name. A register may have the name of the next stage's input.
    pub(crate) fn stage(&self, name: &str) -> String {
        let of_text = |name: &str| {
            let (module, _) = self.place(self.cell(name)?)?;
            let mut stages = self.stages.iter().filter(|(_, other)| other == module);
            stages.next().filter(|_| stages.next().is_none()).map(|(stage, _)| stage.clone())
        };
        let register = || {
            let ends = name.match_indices('_').map(|(end, _)| end);
            let leads_in = |end: &usize| {
                let port = name[end + 1..].split('_').next();
                port.is_some_and(|port| INPUTS.contains(&port)) && self.cells.contains_key(&name[..*end])
            };
            ends.filter(leads_in).find_map(|end| of_text(&name[..end]))
        };
        of_text(name).or_else(register).unwrap_or_else(|| self.stage_in_name(name))
    }

    /// Synthesis names cells by the nets that they drive, and a net by the deepest instance that has it:
    /// `u_raypath.u_stage_3.num_4_q_TRELLIS_FF_Q`.
    fn stage_in_name(&self, name: &str) -> String {
        let inside = match self.has_shell {
            true => name.strip_prefix(INSTANCE).and_then(|rest| rest.strip_prefix('.')),
            false => Some(name),
        };
        let instance = |path: &str| {
            let (name, rest) = path.strip_prefix("u_")?.split_once('.')?;
            Some((name.to_string(), rest.to_string()))
        };
        match inside.map(instance) {
            None => AROUND.to_string(),
            Some(None) => "between stages".to_string(),
            Some(Some((part, rest))) if part == DATAPATH => {
                instance(&rest).map_or(part, |(stage, _)| in_datapath(&stage))
            }
            Some(Some((stage, _))) => stage,
        }
    }
}

/// The stages of a design, and of the datapath in a traversal unit, in order, each with its module.
pub(crate) fn stages(design: &Module) -> Vec<(String, String)> {
    let mut stages = Vec::new();
    for instance in design.instances() {
        let (name, module) = (instance.stem(), &instance.module);
        stages.push((name.to_string(), module.name().to_string()));
        if name == DATAPATH {
            let inner = module.instances().iter();
            stages.extend(inner.map(|inner| (in_datapath(inner.stem()), inner.module.name().to_string())));
        }
    }
    stages
}

fn in_datapath(stage: &str) -> String {
    format!("{DATAPATH}.{stage}")
}

impl Cells {
    /// Counts a cell of this type.
    fn count(&mut self, kind: &str) {
        let counter = match kind {
            "LUT4" | "LUT1" | "LUT2" | "LUT3" | "LUT5" | "LUT6" | "INV" => &mut self.luts,
            "CCU2C" | "CARRY4" | "CARRY8" => &mut self.carry_cells,
            "MULT18X18D" | "DSP48E1" | "DSP48E2" => &mut self.multipliers,
            "TRELLIS_FF" | "FDRE" | "FDSE" | "FDCE" | "FDPE" => &mut self.flip_flops,
            "DP16KD" | "RAMB18E1" | "RAMB18E2" | "RAMB36E1" | "RAMB36E2" => &mut self.block_rams,
            "SRL16E" | "SRLC16E" | "SRLC32E" => &mut self.shift_registers,
            // Xilinx's are RAM32M, RAM64X1D and others; block RAMs have the letter B.
            _ if kind == "TRELLIS_DPR16X4" || kind.starts_with("RAM") => &mut self.distributed_rams,
            _ => return,
        };
        // A block RAM of 36 kbit is two of 18.
        *counter += if kind.starts_with("RAMB36") { 2 } else { 1 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn netlist(top: &str, cells: &str) -> Netlist {
        let json = format!(
            r#"{{"creator": "Yosys", "modules": {{"{top}": {{"cells": {{{cells}}},
            "netnames": {{"a": {{"bits": [2]}}, "b": {{"bits": ["0", 3]}}}}}}, "LUT4": {{}}}}}}"#
        );
        let parse = |json: &str| Netlist::parse(json, top, "", Vec::new(), top == "raypath_shell");
        assert!(parse("{").is_err() && parse(r#"{"modules": {}}"#).is_err());
        parse(&json).expect("a netlist")
    }

    #[test]
    fn cells_belong_to_the_stage_in_their_names() {
        let netlist = netlist(
            "raypath_shell",
            r#""u_raypath.u_stage_3_1.u_mul_0.whole_MULT18X18D_P0": {"type": "MULT18X18D", "connections": {"A0": [2]}},
            "u_raypath.u_stage_3_1.u_skid.data_q_TRELLIS_FF_Q": {"type": "TRELLIS_FF", "connections": {"Q": [3]}},
            "u_raypath.u_stage_3_1.x_LUT4_Z": {"type": "LUT4", "connections": {"A": [3], "B": [3], "C": ["0"], "Z": [2]}},
            "u_raypath.ready_LUT4_Z": {"type": "LUT4"},
            "count_q_CCU2C_S0": {"type": "CCU2C"},
            "count_q_PFUMX_Z": {"type": "PFUMX"}"#,
        );
        let stages = netlist.count();
        let of = |name: &str| stages.get(name).copied().unwrap_or_default();
        let found: Vec<&str> = stages.keys().map(String::as_str).collect();
        assert_eq!(found, ["between stages", "shell", "stage_3_1"]);
        assert_eq!(of("stage_3_1"), Cells { luts: 1, multipliers: 1, flip_flops: 1, ..Cells::default() });
        assert_eq!((of("between stages").luts, of("shell").carry_cells), (1, 1));
        // The multiplier reads the lookup table, which reads the flip-flop twice.
        assert_eq!(["a", "b[1]", "b[2]", "c"].map(|net| netlist.readers(net)), [Some(1), Some(2), None, None]);
    }

    #[test]
    fn cells_of_xilinx_without_a_shell() {
        let cells = "u_walk.a FDRE,u_datapath.u_stage_2.b LUT6,u_datapath.u_stage_2.m DSP48E1,u_datapath.ready INV,\
                     u_rays.a RAMB36E2,u_rays.b RAMB18E2,u_rays.c RAM32M,u_rays.d SRLC32E,u_rays.e CARRY8,u_rays.f MUXF7";
        let cells = cells.split(',').filter_map(|cell| cell.split_once(' '));
        let cells: Vec<String> = cells.map(|(name, kind)| format!(r#""{name}": {{"type": "{kind}"}}"#)).collect();
        let stages = netlist("raypath_unit", &cells.join(",")).count();
        let cells = Cells::default();
        let expected = [
            ("datapath", Cells { luts: 1, ..cells }),
            ("datapath.stage_2", Cells { luts: 1, multipliers: 1, ..cells }),
            ("rays", Cells { block_rams: 3, distributed_rams: 1, shift_registers: 1, carry_cells: 1, ..cells }),
            ("walk", Cells { flip_flops: 1, ..cells }),
        ];
        assert_eq!(stages, expected.map(|(name, cells)| (name.to_string(), cells)).into());
    }
}
