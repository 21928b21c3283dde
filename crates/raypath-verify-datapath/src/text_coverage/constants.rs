//! Bits that cannot change, by proof: ABC finds signals that are constant by induction over all registers together
//! (signal correspondence, Mishchenko et al. 2008), so that what one stage shows holds in the next.
//!
//! The bits of a stage are proved in the whole pipeline, whatever its inputs and the results of adders, multipliers and
//! sums are; those of a unit in the unit alone, for any inputs but those that all its instances tie to a constant.
//! Registers begin with 0, as they do where bits are counted.

use raypath_hdl::Module;
use raypath_tools::{Abc, CoverageKind, CoveragePoint, ToolError, Yosys, YosysKind, read, temporary_folder, write};
use raypath_verify::Error;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// The module and the bit, `num_q[3]`.
pub type Bit = (String, String);

/// The instances of a design: the paths of each module, empty or instance names that each end in a dot.
pub type Places = BTreeMap<String, Vec<String>>;

/// Units whose results may be any.
const FREE: &str = "delete t:raypath_fp_add_* t:raypath_fp_mul_* t:raypath_fp_sum_*\n";
/// The commands from a module to an and-inverter graph with its state.
const TO_GRAPH: &str = "memory; opt_clean; setundef -undriven -anyseq; setundef -init -zero; async2sync; dffunmap; techmap; \
                        opt_clean; aigmap";
const SCRIPT: &str = "constants.ys";
const LIMIT: Duration = Duration::from_secs(600);

/// The places of all modules under this one.
pub fn places(top: &Module) -> Places {
    let mut places = Places::new();
    let mut open = vec![(String::new(), top)];
    while let Some((path, module)) = open.pop() {
        open.extend(module.instances().iter().map(|it| (format!("{path}{}.", it.name), &*it.module)));
        places.entry(module.name().to_string()).or_default().push(path);
    }
    places
}

/// What is proved of a module: bits with their names in it, by what they are in the design.
struct Question<'t> {
    top: &'t str,
    bits: Vec<(Bit, String, u64)>,
}

/// The bits of this text, among those that were not toggled, that are proved to be constant, with their values. Modules
/// with parameters, whose widths differ by instance, are left out, and so are stages of which there are several.
///
/// # Errors
/// A program is missing or fails.
pub fn constants(
    text: &str,
    top: &str,
    places: &Places,
    points: &[CoveragePoint],
) -> Result<BTreeMap<Bit, bool>, Error> {
    let mut questions = vec![Question { top, bits: Vec::new() }];
    for point in points.iter().filter(|point| point.kind == CoverageKind::Toggle && point.hits < 2) {
        let module = point.module.as_str();
        if !is_plain(&point.name) || text.contains(&format!("module {module} #(")) {
            continue;
        }
        let bit = (module.to_string(), point.name.clone());
        match places.get(module).map(Vec::as_slice) {
            _ if is_unit(module) => match questions.iter_mut().find(|question| question.top == module) {
                Some(question) => question.bits.push((bit, point.name.clone(), point.hits)),
                None => questions.push(Question { top: module, bits: vec![(bit, point.name.clone(), point.hits)] }),
            },
            Some([path]) => questions[0].bits.push((bit, format!("{path}{}", point.name), point.hits)),
            _ => {}
        }
    }
    questions.retain(|question| !question.bits.is_empty());
    let mut script = String::from("read_verilog -sv text.sv\ndesign -save text\n");
    for (number, Question { top: module, bits }) in questions.iter().enumerate() {
        let free = if *module == top { FREE } else { "" };
        script += &format!("design -load text\nhierarchy -top {module}\nproc\n{free}flatten\ncd {module}\n");
        for (port, value) in tied(text, module) {
            script += &format!("delete -input w:{port}\nconnect -set {port} {value}\n");
        }
        let wires: Vec<String> = bits.iter().map(|(_, name, _)| format!("w:{}", signal(name))).collect();
        script += &format!(
            "delete -output o:*\nexpose {}\n{TO_GRAPH}\nwrite_aiger -zinit -symbols {number}.aig\n",
            wires.join(" ")
        );
    }
    let folder = temporary_folder()?;
    let (folder, stop) = (folder.path(), &AtomicBool::new(false));
    write(&folder.join("text.sv"), text)?;
    write(&folder.join(SCRIPT), &script)?;
    Yosys::find(Some(YosysKind::Python))?.run(folder, SCRIPT, "bits that were not toggled", stop)?;
    let (abc, mut constants) = (Abc::find()?, BTreeMap::new());
    for (number, Question { bits, .. }) in questions.into_iter().enumerate() {
        let found = outputs(&abc, folder, number)?;
        // A bit that has changed once can only be 1, because it began with 0.
        let proved = bits.into_iter().filter(|(_, name, hits)| found.get(name) == Some(&(*hits == 1)));
        constants.extend(proved.map(|(bit, _, hits)| (bit, hits == 1)));
    }
    Ok(constants)
}

/// The outputs of a graph that are constant, by the names of their bits, with their values.
fn outputs(abc: &Abc, folder: &Path, number: usize) -> Result<BTreeMap<String, bool>, Error> {
    let unexpected = |found: &str| ToolError::unexpected("abc", found.to_string(), "a graph with constant outputs");
    let lines = |name: &str| -> Result<Vec<String>, Error> {
        let bytes = read(&folder.join(name))?;
        Ok(bytes.split(|byte| *byte == b'\n').map(|line| String::from_utf8_lossy(line).into_owned()).collect())
    };
    let graph = lines(&format!("{number}.aig"))?;
    // "aig", and the numbers of variables, inputs, latches, outputs and gates. A line for each latch and output follows.
    let counts = |graph: &[String]| {
        let counts: Vec<usize> = graph[0].split(' ').skip(3).filter_map(|word| word.parse().ok()).collect();
        counts.first().copied().zip(counts.get(1).copied()).ok_or_else(|| unexpected(&graph[0]))
    };
    let (latches, _) = counts(&graph)?;
    let (sweep, swept) = (if latches == 0 { "fraig" } else { "scorr -k" }, format!("swept_{number}.aig"));
    let commands = format!("read_aiger {number}.aig; {sweep}; write_aiger {swept}");
    let said = abc.run(folder, &commands, LIMIT, &AtomicBool::new(false))?.unwrap_or_default();
    if !folder.join(&swept).exists() {
        return Err(unexpected(&said).into());
    }
    let swept = lines(&swept)?;
    let (latches, count) = counts(&swept)?;
    let swept: Vec<String> = swept.into_iter().skip(1 + latches).take(count).collect();
    // The names follow the gates, which are binary: "o3 b_o[1]", and a comment.
    let is_name = |line: &&String| line.starts_with(['i', 'l', 'o']);
    let names = graph.iter().rev().skip_while(|line| *line != "c").skip(1).take_while(is_name);
    let output = |name: &String| {
        let (place, name) = name.strip_prefix('o')?.split_once(' ')?;
        let literal = swept.get(place.parse::<usize>().ok()?)?;
        Some((name.to_string(), ["0", "1"].iter().position(|constant| constant == literal)? == 1))
    };
    Ok(names.filter_map(output).collect())
}

fn is_unit(module: &str) -> bool {
    module.starts_with("raypath_fp_") || module.starts_with("raypath_narrow_")
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

    fn point(module: &str, name: &str, hits: u64) -> CoveragePoint {
        CoveragePoint { kind: CoverageKind::Toggle, module: module.to_string(), line: 4, name: name.to_string(), hits }
    }

    /// The constants of a text whose top is `m`, with these places.
    fn found(text: &str, places: &[(&str, &str)], points: &[CoveragePoint]) -> Vec<(String, bool)> {
        let places = places.iter().map(|(module, path)| (module.to_string(), vec![path.to_string()])).collect();
        let found = constants(text, "m", &places, points).expect("Yosys and ABC");
        found.into_iter().map(|((_, name), value)| (name, value)).collect()
    }

    #[test]
    fn only_bits_that_are_constant_for_any_inputs_are_proved() {
        let text = "module m (\n  input logic clk_i, rst_ni,\n  input logic [1:0] a_i,\n  output logic [3:0] b_o\n);\n  \
                    logic q, r, zero;\n  always_ff @(posedge clk_i) begin q <= a_i[0]; if (q) zero <= 1'b0; end\n  \
                    always_ff @(posedge clk_i or negedge rst_ni) if (!rst_ni) r <= 1'b1; else r <= 1'b0;\n  \
                    assign b_o = {q, a_i[0] | ~a_i[0], a_i[0] & ~a_i[0], a_i[1]};\nendmodule\n";
        let names = [("b_o[0]", 0), ("b_o[1]", 0), ("b_o[2]", 1), ("b_o[3]", 0), ("q", 0), ("zero", 0), ("r", 0)];
        let points = names.map(|(name, hits)| point("m", name, hits));
        let found = found(text, &[("m", "")], &points);
        let found: Vec<(&str, bool)> = found.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        assert_eq!(found, [("b_o[1]", false), ("b_o[2]", true), ("zero", false)]);
    }

    /// A register whose bit is constant because that of the stage before is, behind a comparison.
    #[test]
    fn what_one_stage_shows_holds_in_the_next() {
        let is_constant = |unit: &str| {
            let text = format!(
                "module {unit} (\n  input logic [1:0] a_i,\n  output logic [1:0] b_o\n);\n  assign b_o = {{1'b0, \
                 a_i[0]}};\nendmodule\nmodule stage (\n  input logic clk_i,\n  input logic [1:0] a_i,\n  output logic \
                 [1:0] b_o\n);\n  logic [1:0] b_q;\n  always_ff @(posedge clk_i) b_q <= a_i;\n  assign b_o = b_q;\n\
                 endmodule\nmodule first (\n  input logic clk_i,\n  input logic [1:0] a_i,\n  output logic [1:0] b_o\n);\n  \
                 logic [1:0] b;\n  logic [1:0] b_q;\n  {unit} u_unit (\n    .a_i, .b_o (b)\n  );\n  always_ff @(posedge \
                 clk_i) b_q <= b;\n  assign b_o = b_q;\nendmodule\nmodule m (\n  input logic clk_i,\n  input logic [1:0] \
                 a_i,\n  output logic [1:0] b_o\n);\n  logic [1:0] b;\n  first u_first (.clk_i, .a_i, .b_o (b));\n  stage \
                 u_stage (.clk_i, .a_i (b), .b_o);\nendmodule\n"
            );
            let points = [point("stage", "b_q[0]", 0), point("stage", "b_q[1]", 0)];
            let found = found(&text, &[("m", ""), ("first", "u_first."), ("stage", "u_stage.")], &points);
            assert!(found.iter().all(|(name, value)| name == "b_q[1]" && !value), "{found:?}");
            !found.is_empty()
        };
        assert!(is_constant("raypath_fp_compare_e4s5"));
        assert!(!is_constant("raypath_fp_mul_e4s5"));
    }

    #[test]
    fn an_input_is_tied_if_all_instances_have_the_same_constant() {
        const UNIT: &str = "raypath_fp_part";
        let text = format!(
            "module m;\n  {UNIT} u_a (\n    .clk_i, .a_i (1'b1), .b_i (1'b1),\n    .c_i (1'b0)\n  );\n\n  {UNIT} u_b (\n    \
             .clk_i, .a_i (1'b1), .b_i (free), .c_i (1'b1), .d_i (1'b0)\n  );\nendmodule\n"
        );
        assert_eq!(tied(&text, UNIT), [("a_i", "1'b1")]);
        assert_eq!(tied(&text, "other"), []);
        let unit = format!("module {UNIT} (input logic a_i, output logic a_o);\n  assign a_o = ~a_i;\nendmodule\n");
        let instance = format!("module m;\n  logic b;\n  {UNIT} u_a (\n    .a_i (1'b1), .a_o (b)\n  );\nendmodule\n");
        let points = [point(UNIT, "a_o", 0)];
        assert_eq!(found(&(instance + &unit), &[("m", "")], &points), [("a_o".to_string(), false)]);
        assert_eq!(found(&(unit + "module m;\nendmodule\n"), &[("m", "")], &points), []);
    }
}
