//! The cells of a synthesised design, by stage.

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

#[derive(Deserialize)]
struct Module {
    #[serde(default)]
    cells: BTreeMap<String, Cell>,
}

#[derive(Deserialize)]
struct Cell {
    #[serde(rename = "type")]
    kind: String,
}

/// What is around the datapath, in reports.
pub(crate) const AROUND: &str = "shell";

/// Counts the cells of a module by stage.
///
/// # Errors
/// The text is not Yosys's JSON, or has no such module.
pub(crate) fn cells(json: &str, module: &str) -> Result<BTreeMap<String, Cells>, ToolError> {
    let unexpected = |found: String| ToolError::unexpected("yosys", found, "its JSON with the shell");
    let mut design: Design = serde_json::from_str(json).map_err(|problem| unexpected(problem.to_string()))?;
    let module = design.modules.remove(module).ok_or_else(|| unexpected(format!("no module {module}")))?;
    let mut stages: BTreeMap<String, Cells> = BTreeMap::new();
    for (name, cell) in &module.cells {
        stages.entry(stage(name)).or_default().count(&cell.kind);
    }
    Ok(stages)
}

/// The stage that a cell or a net belongs to, by its name. Synthesis names cells by the nets that they drive, and a net
/// by the deepest instance that has it: `u_raypath.u_stage_3.num_4_q_TRELLIS_FF_Q`.
pub(crate) fn stage(name: &str) -> String {
    let inside = name.strip_prefix(INSTANCE).and_then(|rest| rest.strip_prefix('.'));
    let stage = inside.and_then(|rest| rest.strip_prefix("u_")?.split_once('.'));
    match (inside, stage) {
        (_, Some((stage, _))) => stage.to_string(),
        (Some(_), None) => "between stages".to_string(),
        (None, _) => AROUND.to_string(),
    }
}

impl Cells {
    /// Counts a cell of this type.
    fn count(&mut self, kind: &str) {
        let counter = match kind {
            "LUT4" => &mut self.luts,
            "CCU2C" => &mut self.carry_cells,
            "MULT18X18D" => &mut self.multipliers,
            "TRELLIS_FF" => &mut self.flip_flops,
            "DP16KD" => &mut self.block_rams,
            "TRELLIS_DPR16X4" => &mut self.distributed_rams,
            _ => return,
        };
        *counter += 1;
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
        let stages = cells(json, "raypath_shell").expect("cells");
        let of = |name: &str| stages.get(name).copied().unwrap_or_default();
        let found: Vec<&str> = stages.keys().map(String::as_str).collect();
        assert_eq!(found, ["between stages", "shell", "stage_3_1"]);
        assert_eq!(of("stage_3_1"), Cells { luts: 1, multipliers: 1, flip_flops: 1, ..Cells::default() });
        assert_eq!((of("between stages").luts, of("shell").carry_cells), (1, 1));
        assert!(cells(json, "raypath").is_err() && cells("{", "raypath").is_err());
    }
}
