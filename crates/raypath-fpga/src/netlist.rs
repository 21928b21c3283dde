//! The cells of a synthesised design, by stage.

use crate::flow::DESIGN;
use crate::report::Cells;
use crate::shell::INSTANCE;
use raypath_tools::ToolError;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The part of Yosys's JSON that is read here.
#[derive(Deserialize)]
struct Design {
    modules: BTreeMap<String, Module>,
}

/// The cells of a synthesised module.
#[derive(Deserialize)]
pub(crate) struct Module {
    #[serde(default)]
    cells: BTreeMap<String, Cell>,
}

/// A cell.
#[derive(Deserialize)]
pub(crate) struct Cell {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    attributes: Attributes,
}

#[derive(Deserialize, Default)]
struct Attributes {
    #[serde(default)]
    src: String,
}

/// What is around the datapath, in reports.
pub(crate) const AROUND: &str = "shell";

impl Module {
    /// The module `name` in Yosys's JSON.
    ///
    /// # Errors
    /// The text is not Yosys's JSON, or has no such module.
    pub(crate) fn parse(json: &str, name: &str) -> Result<Self, ToolError> {
        let unexpected = |found: String| ToolError::unexpected("yosys", found, "its JSON with the top module");
        let mut design: Design = serde_json::from_str(json).map_err(|problem| unexpected(problem.to_string()))?;
        design.modules.remove(name).ok_or_else(|| unexpected(format!("no module {name}")))
    }

    /// The numbers of its cells by stage. Without a shell, the module is the design itself.
    pub(crate) fn count(&self, has_shell: bool) -> BTreeMap<String, Cells> {
        let mut stages: BTreeMap<String, Cells> = BTreeMap::new();
        for (name, cell) in &self.cells {
            let stage = if has_shell { stage(name) } else { stage(&format!("{INSTANCE}.{name}")) };
            stages.entry(stage).or_default().count(&cell.kind);
        }
        stages
    }

    /// A cell by nextpnr's name, which has an ending such as `$CCU2_COMB0` if it is a part of the cell.
    pub(crate) fn cell(&self, name: &str) -> Option<&Cell> {
        self.cells.get(name).or_else(|| self.cells.get(name.rsplit_once('$')?.0))
    }
}

impl Cell {
    /// The line of the design's text that it was made of, from 1. Lookup tables have none: they are made of many.
    pub(crate) fn line(&self) -> Option<usize> {
        let place = self.attributes.src.split('|').find_map(|place| place.strip_prefix(DESIGN)?.strip_prefix(':'))?;
        place.split('.').next()?.parse().ok()
    }
}

/// The part of a traversal unit whose stages are parts too.
const DATAPATH: &str = "datapath";

/// The stage that a cell or a net belongs to, by its name. Synthesis names cells by the nets that they drive, and a net
/// by the deepest instance that has it: `u_raypath.u_stage_3.num_4_q_TRELLIS_FF_Q`.
pub(crate) fn stage(name: &str) -> String {
    let Some(inside) = name.strip_prefix(INSTANCE).and_then(|rest| rest.strip_prefix('.')) else {
        return AROUND.to_string();
    };
    let instance =
        |path: &'_ str| path.strip_prefix("u_")?.split_once('.').map(|(name, rest)| [name, rest].map(str::to_string));
    match instance(inside) {
        None => "between stages".to_string(),
        Some([part, rest]) if part == DATAPATH => {
            instance(&rest).map_or(part.clone(), |[stage, _]| in_datapath(&stage))
        }
        Some([stage, _]) => stage,
    }
}

/// The stages of a design, and of the datapath in a traversal unit, in order, each with its module.
pub(crate) fn stages(design: &raypath_hdl::Module) -> Vec<(String, String)> {
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

    #[test]
    fn cells_belong_to_the_stage_in_their_names() {
        let json = r#"{"creator": "Yosys", "modules": {"raypath_shell": {"ports": {}, "cells": {
            "u_raypath.u_stage_3_1.u_mul_0.whole_MULT18X18D_P0": {"type": "MULT18X18D", "connections": {"A0": [2]}},
            "u_raypath.u_stage_3_1.u_skid.data_q_TRELLIS_FF_Q": {"type": "TRELLIS_FF"},
            "u_raypath.u_stage_3_1.x_LUT4_Z": {"type": "LUT4"},
            "u_raypath.ready_LUT4_Z": {"type": "LUT4"},
            "count_q_CCU2C_S0": {"type": "CCU2C"},
            "count_q_PFUMX_Z": {"type": "PFUMX"}}},
            "LUT4": {}}}"#;
        let module = Module::parse(json, "raypath_shell").expect("cells");
        let stages = module.count(true);
        let of = |name: &str| stages.get(name).copied().unwrap_or_default();
        let found: Vec<&str> = stages.keys().map(String::as_str).collect();
        assert_eq!(found, ["between stages", "shell", "stage_3_1"]);
        assert_eq!(of("stage_3_1"), Cells { luts: 1, multipliers: 1, flip_flops: 1, ..Cells::default() });
        assert_eq!((of("between stages").luts, of("shell").carry_cells), (1, 1));
        assert!(Module::parse(json, "raypath").is_err() && Module::parse("{", "raypath").is_err());
    }

    #[test]
    fn cells_of_xilinx_without_a_shell() {
        let cells: String = [
            ("u_walk.a_q", "FDRE"),
            ("u_datapath.u_stage_2.b", "LUT6"),
            ("u_datapath.u_stage_2.m", "DSP48E1"),
            ("u_datapath.ready", "INV"),
            ("u_rays.words", "RAMB36E2"),
            ("u_rays.more", "RAMB18E2"),
            ("u_rays.few", "RAM32M"),
            ("u_rays.late", "SRLC32E"),
            ("u_rays.sum", "CARRY8"),
            ("u_rays.mux", "MUXF7"),
        ]
        .map(|(name, kind)| format!(r#""{name}": {{"type": "{kind}"}}"#))
        .join(",");
        let json = format!(r#"{{"modules": {{"raypath_unit": {{"cells": {{{cells}}}}}}}}}"#);
        let stages = Module::parse(&json, "raypath_unit").expect("cells").count(false);
        let cells = Cells::default();
        let rays = Cells { block_rams: 3, distributed_rams: 1, shift_registers: 1, carry_cells: 1, ..cells };
        let expected = [
            ("datapath", Cells { luts: 1, ..cells }),
            ("datapath.stage_2", Cells { luts: 1, multipliers: 1, ..cells }),
            ("rays", rays),
            ("walk", Cells { flip_flops: 1, ..cells }),
        ];
        assert_eq!(stages, expected.map(|(name, cells)| (name.to_string(), cells)).into());
    }
}
