//! Bits that cannot change: they are constant for any inputs of their module but those that all its instances tie to a
//! constant, any registers that have a reset, and any outputs of instances in it but [`INLINED`], as Yosys proves by
//! SAT and induction. Registers without a reset begin with 0, as they do in
//! [`raypath_tools::Verilated::coverage`].

use raypath_tools::{CoverageKind, CoveragePoint, ToolError, Yosys, read, temporary_folder, write};
use raypath_verify::Error;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

/// The module and the bit, `num_q[3]`.
pub type Bit = (String, String);

/// Instances that are read with the module around them: an encoder makes constant bits of a constant fraction, a
/// converter of short words to numbers has constant lower bits, and so have the remainders of the parts of a divider.
const INLINED: &str = "t:raypath_fp_encode_* t:raypath_fp_number_* t:raypath_fp_div_*";
/// One step of induction, in which registers without a reset begin with 0. Yosys leaves registers with a reset free.
const PROOF: &str = "sat -ignore_unknown_cells -tempinduct -maxsteps 1 -set-init-zero";
/// What Yosys prints at the end of a proof, and whether it has proved the claim.
const OUTCOMES: [(&str, bool); 3] = [
    ("Induction step proven: SUCCESS!", true),
    ("Reached maximum number of time steps -> proof failed.", false),
    ("SAT temporal induction proof finished - model found for base case: FAIL!", false),
];

const SCRIPT: &str = "constants.ys";
const ANSWERS: &str = "answers.txt";

/// The bits of this text, among those that were not toggled, that are proved to be constant, with their values. Modules
/// with parameters, whose widths differ by instance, are left out.
pub fn constants(text: &str, points: &[CoveragePoint]) -> Result<BTreeMap<Bit, bool>, Error> {
    let has_parameters = |module: &str| text.contains(&format!("module {module} #("));
    let mut bits: BTreeMap<&str, Vec<(&str, u64)>> = BTreeMap::new();
    for point in points.iter().filter(|point| point.kind == CoverageKind::Toggle && !has_parameters(&point.module)) {
        // A bit that has changed once can only be 1, because it began with 0.
        if point.hits < 2 && is_plain(&point.name) {
            bits.entry(&point.module).or_default().push((&point.name, point.hits));
        }
    }
    if bits.is_empty() {
        return Ok(BTreeMap::new());
    }
    let mut script = String::from("read_verilog -sv text.sv\nproc\n");
    for (module, bits) in &bits {
        let tied: Vec<String> = tied(text, module).iter().map(|(port, value)| format!("-set {port} {value}")).collect();
        let sat = format!("tee -q -a {ANSWERS} {PROOF} {}", tied.join(" "));
        script += &format!("cd {module}\nflatten {INLINED}\n");
        for (name, value) in bits {
            // Yosys imports the logic that drives the signal; the whole module takes many times as long.
            script += &format!("{sat} -prove {name} 1'b{value} w:{} %ci*\n", signal(name));
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
        .filter_map(|line| OUTCOMES.iter().find_map(|&(end, is_proved)| (line == end).then_some(is_proved)))
        .collect();
    let asked: Vec<(Bit, bool)> = bits
        .iter()
        .flat_map(|(module, bits)| {
            bits.iter().map(|&(name, value)| ((module.to_string(), name.to_string()), value == 1))
        })
        .collect();
    if answers.len() != asked.len() {
        let found = format!("{} answers", answers.len());
        return Err(ToolError::unexpected("Yosys's sat", found, asked.len().to_string()).into());
    }
    Ok(asked.into_iter().zip(answers).filter_map(|(bit, is_proved)| is_proved.then_some(bit)).collect())
}

/// The inputs of one bit that have the same constant in each instance of a module in this text, with its literal.
fn tied<'t>(text: &'t str, module: &str) -> Vec<(&'t str, &'t str)> {
    let start = format!("\n  {module} u_");
    let instances = text.match_indices(&start).filter_map(|(at, _)| text[at + start.len()..].split(");").next());
    let mut common: Option<Vec<(&str, &str)>> = None;
    for instance in instances {
        let connections = instance.split('.').filter_map(|connection| connection.split_once(" ("));
        let own: Vec<(&str, &str)> = connections
            .filter_map(|(port, rest)| Some((port, rest.split(')').next()?)))
            .filter(|(_, value)| ["1'b0", "1'b1"].contains(value))
            .collect();
        common = Some(match common {
            None => own,
            Some(common) => common.into_iter().filter(|connection| own.contains(connection)).collect(),
        });
    }
    common.unwrap_or_default()
}

/// The name without the index of a bit.
fn signal(name: &str) -> &str {
    name.split_once('[').map_or(name, |(signal, _)| signal)
}

/// Whether a name is that of a signal or of its bit.
fn is_plain(name: &str) -> bool {
    signal(name).chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bits_that_are_constant_for_any_inputs_are_proved() {
        let text = "module m (\n  input logic clk_i, rst_ni,\n  input logic [1:0] a_i,\n  output logic [3:0] b_o\n);\n  \
                    logic q, r, zero;\n  always_ff @(posedge clk_i) begin q <= a_i[0]; if (q) zero <= 1'b0; end\n  \
                    always_ff @(posedge clk_i or negedge rst_ni) if (!rst_ni) r <= 1'b0; else r <= 1'b0;\n  \
                    assign b_o = {q, a_i[0] | ~a_i[0], a_i[0] & ~a_i[0], a_i[1]};\nendmodule\n";
        let point = |name: &str, hits| CoveragePoint {
            kind: CoverageKind::Toggle,
            module: "m".to_string(),
            line: 4,
            name: name.to_string(),
            hits,
        };
        let points = [
            ("b_o[0]", 0),
            ("b_o[1]", 0),
            ("b_o[2]", 1),
            ("b_o[3]", 0),
            ("a_i[1]", 0),
            ("b_o[2]", 0),
            ("q", 0),
            ("zero", 0),
            ("r", 0),
        ];
        let found = constants(text, &points.map(|(name, hits)| point(name, hits))).expect("Yosys");
        let found: Vec<(&str, bool)> = found.iter().map(|((_, name), value)| (name.as_str(), *value)).collect();
        assert_eq!(found, [("b_o[1]", false), ("b_o[2]", true), ("zero", false)]);
    }

    #[test]
    fn the_text_of_some_instances_is_read_and_that_of_others_is_not() {
        let is_constant = |part: &str| {
            let text = format!(
                "module {part} (\n  input logic [1:0] word_i,\n  output logic [3:0] recoded_o\n);\n  assign \
                 recoded_o = {{word_i, 2'b00}};\nendmodule\nmodule m (\n  input logic [1:0] a_i,\n  output logic \
                 [3:0] b_o\n);\n  {part} u_part (\n    .word_i (a_i), .recoded_o (b_o)\n  );\nendmodule\n"
            );
            let name = "b_o[1]".to_string();
            let point = CoveragePoint { kind: CoverageKind::Toggle, module: "m".into(), line: 8, name, hits: 0 };
            !constants(&text, &[point]).expect("Yosys").is_empty()
        };
        assert!(is_constant("raypath_fp_encode_e4s5"));
        assert!(is_constant("raypath_fp_number_e4s5_w2"));
        assert!(is_constant("raypath_fp_div_e4s5_part_1_of_2"));
        assert!(!is_constant("raypath_fp_mul_e4s5"));
    }

    #[test]
    fn an_input_is_tied_if_all_instances_have_the_same_constant() {
        let text = "module top;\n  part u_a (\n    .clk_i, .a_i (1'b1), .b_i (1'b1),\n    .c_i (1'b0)\n  );\n\n  \
                    part u_b (\n    .clk_i, .a_i (1'b1), .b_i (free), .c_i (1'b1), .d_i (1'b0)\n  );\nendmodule\n";
        assert_eq!(tied(text, "part"), [("a_i", "1'b1")]);
        assert_eq!(tied(text, "other"), []);
        let part = "module part (input logic a_i, output logic a_o);\n  assign a_o = ~a_i;\nendmodule\n";
        let point =
            CoveragePoint { kind: CoverageKind::Toggle, module: "part".into(), line: 1, name: "a_o".into(), hits: 0 };
        let is_constant = |text: &str| !constants(text, std::slice::from_ref(&point)).expect("Yosys").is_empty();
        assert!(is_constant(&(text.to_string() + part)));
        assert!(!is_constant(part));
    }
}
