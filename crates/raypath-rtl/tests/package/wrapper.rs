//! The wrapper: lint, and comparison with the datapath without wrapper.

use crate::package::folder::{PRESETS, Written, preset, write};
use crate::package::frames::agree_in_frames;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_hdl::{Builder, Module};
use raypath_ops::{Circuit, Num, Operation, bundle};
use raypath_rtl::{Config, Control, DatapathNetlist, Lanes, Operations};
use raypath_tools::{Options, ToolError, Verilated, lint_slang, lint_verilator, lint_yosys};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const FRAMES: usize = 600;

#[test]
fn all_three_front_ends_accept_it() {
    for name in PRESETS {
        let written = write(&preset(name));
        lint_files(&written.listed(), &written, "raypath_wrapper").unwrap_or_else(|fault| panic!("{name}: {fault}"));
    }
}

/// The example in the book.
#[test]
fn the_example_is_clean() {
    let written = write(&preset("graphics"));
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/wrapper/nearest_box.sv");
    let mut files = written.listed();
    files.push(example);
    lint_files(&files, &written, "nearest_box").unwrap_or_else(|fault| panic!("{fault}"));
}

/// Verilator and slang read the listed files; Yosys reads their concatenation.
fn lint_files(files: &[PathBuf], written: &Written, top: &str) -> Result<(), ToolError> {
    let texts = files.iter().map(|file| fs::read_to_string(file).expect("text"));
    let all = texts.collect::<String>();
    assert!(!all.contains("lint_off") && !all.contains("verilator"), "a waiver");
    let one = written.path().join("all.sv");
    fs::write(&one, all).expect("a file");
    lint_verilator(files, top, &[])?;
    lint_yosys(&one, top)?;
    lint_slang(files)
}

/// Negative control: the linters report a field of a wrong width in the wrapper.
#[test]
fn a_fault_in_the_wrapper_is_found() {
    let written = write(&preset("graphics"));
    let package = written.path().join("rtl/raypath_wrapper_pkg.sv");
    let text = fs::read_to_string(&package).expect("text");
    fs::write(&package, text.replace("logic [31:0] extent", "logic [30:0] extent")).expect("a file");
    lint_verilator(&written.listed(), "raypath_wrapper", &[]).expect_err("Verilator");
    lint_slang(&written.listed()).expect_err("slang");
}

/// Random words at the ports of both in every cycle, with random handshakes and resets.
#[test]
fn it_equals_the_bare_datapath() {
    // All kinds of ports, and narrow numbers.
    let config = Config::DEFAULT.lanes(Lanes::Two).format(Format::BINARY16).control(Control::Credit);
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let top = datapath.top();
    let written = write(&datapath);
    let flat = written.path().join("flat.sv");
    fs::write(&flat, flattened(top)).expect("a file");
    let mut files = written.listed();
    files.extend([flat, written.path().join("raypath_properties.sv")]);

    let frames = frames(top, &mut ChaCha8Rng::seed_from_u64(1));
    let verilated = Verilated::build_sources(&files, &ports_of(top), written.path(), &Options::default());
    let outputs = agree_in_frames(top, &verilated.expect("a build"), &frames);
    let valid = top.outputs().iter().position(|port| port.name == "output_valid_o").expect("a handshake");
    let shown = outputs.iter().filter(|outputs| outputs[valid] == 1).count();
    assert!(shown > FRAMES / 4, "{shown} cycles with an outcome");
}

/// The field of each port, written by hand: prefixes of ports, and their replacements in paths of fields.
const FIELDS: &[(&str, &str)] = &[
    ("ray_origin_", "ray.origin."),
    ("ray_dir_", "ray.dir."),
    ("ray_inv_", "ray.inv."),
    ("ray_shear_", "ray.shear."),
    ("ray_", "ray."),
    ("triangle_a_", "triangle.a."),
    ("triangle_b_", "triangle.b."),
    ("triangle_c_", "triangle.c."),
    ("euclidean_", "euclidean."),
    ("angular_", "angular."),
    ("box_index_", "box.index_"),
    ("t_num", "t.num"),
    ("t_denom", "t.denom"),
];

fn field(stem: &str) -> String {
    if let Some(bound) = stem.strip_prefix("aabb_") {
        let words: Vec<&str> = bound.split('_').collect();
        return format!("aabb_{}", words.join("."));
    }
    let found = FIELDS.iter().find_map(|(port, field)| Some(format!("{field}{}", stem.strip_prefix(port)?)));
    found.unwrap_or_else(|| stem.to_string())
}

const HANDSHAKES: [&str; 4] = ["input_valid_i", "output_ready_i", "input_ready_o", "output_valid_o"];

/// A module `flat` with the ports of the datapath, around the wrapper.
fn flattened(top: &Module) -> String {
    let mut ports = vec!["  input logic clk_i".to_string(), "  input logic rst_ni".to_string()];
    let mut wires = String::new();
    for (direction, list) in [("input", top.inputs()), ("output", top.outputs())] {
        for port in list {
            let width = top.signal(port.signal).width;
            ports.push(format!("  {direction} logic [{}:0] {}", width - 1, port.name));
            if HANDSHAKES.contains(&port.name.as_str()) {
                continue;
            }
            let (stem, name) = (port.stem(), &port.name);
            let wire = match (direction, stem) {
                ("input", "opcode") => format!("job.opcode = {name}"),
                ("input", _) => format!("job.{} = {name}", field(stem)),
                _ => format!("{name} = outcome.{}", field(stem)),
            };
            writeln!(wires, "  assign {wire};").expect("text");
        }
    }
    let handshakes = HANDSHAKES.map(|name| format!(".{name}({name})")).join(", ");
    format!(
        "module flat (\n{}\n);\n  raypath_wrapper_pkg::job_t job;\n  raypath_wrapper_pkg::outcome_t \
         outcome;\n{wires}  raypath_wrapper u_wrapper (.clk_i(clk_i), .rst_ni(rst_ni), {handshakes}, .job_i(job), \
         .outcome_o(outcome));\nendmodule\n",
        ports.join(",\n")
    )
}

/// A module `flat` with these ports, from which the test bench is made.
fn ports_of(top: &Module) -> Arc<Module> {
    let m = Builder::new("flat");
    let inputs: Vec<_> = top.inputs().iter().map(|port| m.input(&port.name, top.signal(port.signal).width)).collect();
    m.unused("unused_inputs", &inputs);
    for port in top.outputs() {
        let register = m.register(&format!("{}_q", port.name), top.signal(port.signal).width).reset_to(0);
        register.next(register.wire());
        m.output(&port.name, register.wire());
    }
    m.finish().expect("a module")
}

/// `rst_ni`, then the inputs in order.
fn frames(top: &Module, random: &mut ChaCha8Rng) -> Vec<Vec<u64>> {
    let mut word = |name: &str, width: u32| match name {
        "input_valid_i" | "output_ready_i" => u64::from(random.random_bool(0.8)),
        "rst_ni" => u64::from(!random.random_bool(0.01)),
        _ => random.random::<u64>() & (u64::MAX >> (64 - width)),
    };
    let mut frame = || {
        let reset = word("rst_ni", 1);
        let inputs = top.inputs().iter().map(|port| word(&port.name, top.signal(port.signal).width));
        [reset].into_iter().chain(inputs).collect()
    };
    (0..FRAMES).map(|_| frame()).collect()
}

bundle! {
    /// Names that are difficult to nest: a port whose name begins others, and keywords.
    pub struct Awkward<C> {
        pub ray: Num<C>,
        /// Has the name above as its prefix.
        pub ray_end: Num<C>,
        /// The field would be `begin`.
        pub range_begin: Num<C>,
        /// The field would be `end`.
        pub range_end: Num<C>,
        /// The whole name is a keyword.
        pub wire: Num<C>,
        pub point_x: Num<C>,
        pub point_y: Num<C>,
    }
}

bundle! {
    /// One number.
    pub struct Total<C> {
        pub total: Num<C>,
    }
}

operation!(Sum = "sum_of_all", Awkward<C> => Total<C>, |c, input| {
    c.stage(2, "first sums");
    let (ends, ray) = (input.range_begin + input.range_end, input.ray + input.ray_end);
    let point = input.point_x + input.point_y;
    c.stage(3, "second sums");
    let (both, point) = (ends + ray, point + input.wire);
    c.stage(4, "the last sum");
    Total { total: both + point }
});

/// The wrapper also exists for added operations with ports of any names.
#[test]
fn any_operation_is_wrapped() {
    let operations = Operations::new().with(&Sum, 5).expect("an operation");
    let written = write(&DatapathNetlist::of(operations).expect("a datapath"));
    lint_files(&written.listed(), &written, "raypath_wrapper").unwrap_or_else(|fault| panic!("{fault}"));
    let package = fs::read_to_string(written.path().join("rtl/raypath_pkg.sv")).expect("text");
    assert!(package.contains("OpSumOfAll = 3'd5"), "{package}");
    let wrapper = written.text("rtl/raypath_wrapper.sv");
    for port in
        ["job_i.ray)", "job_i.ray_end)", "job_i.range_end)", "job_i.point.x)", "job_i.wire_i)", "outcome_o.total)"]
    {
        assert!(wrapper.contains(port), "{port} in {wrapper}");
    }
}
