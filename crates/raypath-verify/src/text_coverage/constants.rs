//! Bits that cannot change: they are constant for any inputs of their module, and any registers and outputs of
//! instances in it, as Yosys proves by SAT.

use crate::Error;
use raypath_tools::{CoverageKind, CoveragePoint, ToolError, Yosys, read, temporary_folder, write};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;

/// The module and the bit, `num_q[3]`.
pub type Bit = (String, String);

const SCRIPT: &str = "constants.ys";
const ANSWERS: &str = "answers.txt";

/// The bits of this text, among those that were not toggled, that are proved to be constant. Modules with parameters,
/// whose widths differ by instance, are left out.
pub fn constants(text: &str, points: &[CoveragePoint]) -> Result<BTreeSet<Bit>, Error> {
    let has_parameters = |module: &str| text.contains(&format!("module {module} #("));
    let mut bits: BTreeMap<&str, Vec<(&str, u64)>> = BTreeMap::new();
    for point in points.iter().filter(|point| point.kind == CoverageKind::Toggle && !has_parameters(&point.module)) {
        // A bit that has changed once can only be 1, because it began with 0.
        if point.hits < 2 && is_plain(&point.name) {
            bits.entry(&point.module).or_default().push((&point.name, point.hits));
        }
    }
    if bits.is_empty() {
        return Ok(BTreeSet::new());
    }
    let mut script = String::from("read_verilog -sv text.sv\nproc\n");
    for (module, bits) in &bits {
        script += &format!("cd {module}\n");
        for (name, value) in bits {
            script += &format!("tee -q -a {ANSWERS} sat -ignore_unknown_cells -prove {name} 1'b{value}\n");
        }
        script += "cd ..\n";
    }
    let folder = temporary_folder()?;
    write(&folder.path().join("text.sv"), text)?;
    write(&folder.path().join(SCRIPT), &script)?;
    Yosys::find(None)?.run(folder.path(), SCRIPT, "bits that were not toggled", &AtomicBool::new(false))?;
    let answers = String::from_utf8_lossy(&read(&folder.path().join(ANSWERS))?).into_owned();
    let answers: Vec<bool> = answers
        .lines()
        .filter(|line| line.starts_with("SAT proof finished"))
        .map(|line| line.contains("no model found: SUCCESS"))
        .collect();
    let asked: Vec<Bit> = bits
        .iter()
        .flat_map(|(module, bits)| bits.iter().map(|(name, _)| (module.to_string(), name.to_string())))
        .collect();
    if answers.len() != asked.len() {
        let found = format!("{} answers", answers.len());
        return Err(ToolError::unexpected("Yosys's sat", found, asked.len().to_string()).into());
    }
    Ok(asked.into_iter().zip(answers).filter_map(|(bit, is_proved)| is_proved.then_some(bit)).collect())
}

/// Whether a name is that of a signal or of its bit.
fn is_plain(name: &str) -> bool {
    let name = name.split_once('[').map_or(name, |(name, _)| name);
    name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bits_that_are_constant_for_any_inputs_and_registers_are_proved() {
        let text = "module m (\n  input logic clk_i,\n  input logic [1:0] a_i,\n  output logic [3:0] b_o\n);\n  logic q;\n  \
                    always_ff @(posedge clk_i) q <= 1'b0;\n  \
                    assign b_o = {q, a_i[0] | ~a_i[0], a_i[0] & ~a_i[0], a_i[1]};\nendmodule\n";
        let point = |name: &str, hits| CoveragePoint {
            kind: CoverageKind::Toggle,
            module: "m".to_string(),
            line: 4,
            name: name.to_string(),
            hits,
        };
        let points =
            [("b_o[0]", 0), ("b_o[1]", 0), ("b_o[2]", 1), ("b_o[3]", 0), ("a_i[1]", 0), ("b_o[2]", 0), ("q", 5)];
        let found = constants(text, &points.map(|(name, hits)| point(name, hits))).expect("Yosys");
        let found: Vec<&str> = found.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(found, ["b_o[1]", "b_o[2]"]);
    }
}
