//! Synthesis of units, and the whole flow on something small.

use raypath_float::{Format, Product};
use raypath_fpga::{Device, Flow, Shell, StreamWidth, Target, reduced};
use raypath_hdl::{Builder, Module, verilog};
use raypath_tools::{ToolError, Yosys, temporary_folder, write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The number of cells of a type that `synth_ecp5` makes of a module.
fn cells(module: &Arc<Module>, kind: &str) -> u64 {
    let folder = temporary_folder().expect("a folder");
    write(&folder.path().join("unit.sv"), &verilog::text(module).expect("text")).expect("a file");
    let name = module.name();
    let script =
        format!("read_verilog -sv unit.sv\nsynth_ecp5 -top {name}\ntee -o {kind}.txt select -count t:{kind}\n");
    write(&folder.path().join("script.ys"), &script).expect("a file");
    let yosys = Yosys::find(None).expect("Yosys");
    yosys.run(folder.path(), "script.ys", name, &AtomicBool::new(false)).expect("synthesis");
    let count = std::fs::read_to_string(folder.path().join(format!("{kind}.txt"))).expect("a count");
    count.split_whitespace().next().expect("a number").parse().expect("a number")
}

/// The product of 24 bits takes four multipliers of 18 bits with `*`, and none without.
#[test]
fn inferred_multipliers_are_those_of_the_device() {
    let inferred = raypath_float::mul(Format::BINARY32, Product::Inferred, false).expect("a unit");
    assert_eq!(cells(&inferred, "MULT18X18D"), 4);
    let booth = raypath_float::mul(Format::BFLOAT16, Product::Booth, false).expect("a unit");
    assert_eq!(cells(&booth, "MULT18X18D"), 0);
}

/// A module with the ports of a datapath: a product, a cycle later.
fn small() -> Arc<Module> {
    let m = Builder::new("raypath");
    let [valid, opcode] = [("input_valid_i", 1), ("opcode_i", 2)].map(|(name, width)| m.input(name, width));
    let [ready, a, b] = [("output_ready_i", 1), ("a_i", 18), ("b_i", 18)].map(|(name, width)| m.input(name, width));
    let full = m.register("full_q", 1).reset_to(0);
    let advances = !full.wire() | ready;
    full.next_when(advances, valid);
    let opcode_q = m.register("opcode_q", 2);
    opcode_q.next_when(advances, opcode);
    let product = m.register("product_q", 36);
    product.next_when(advances, a * b);
    m.output("input_ready_o", advances);
    m.output("output_valid_o", full.wire());
    m.output("opcode_o", opcode_q.wire());
    m.output("product_o", product.wire());
    m.finish().expect("a module")
}

/// Yosys, nextpnr and ecppack make a bitstream; a second run takes everything but the bitstream from the cache.
#[test]
fn a_small_shell_becomes_a_bitstream() {
    let shell = Shell::new(&small(), StreamWidth::Eight).expect("a shell");
    let folder = tempfile::tempdir().expect("a folder");
    let flow = || Flow { yosys: Yosys::find(None).expect("Yosys"), cache: folder.path().join("cache") };
    let target = Target::of(Device::Ecp5_25k);
    let targets = [(6, 1), (6, 2), (8, 1)].map(|(speed, seed)| Target { speed, seed, ..target });
    let first = flow().implement("small", &shell.top, &targets, |_| true).expect("a bitstream");
    let report = &first.report;
    let routed = report.routed.as_ref().expect("a layout");
    assert_eq!((report.cells.multipliers, routed.timing.used["MULT18X18D"].available), (1, 28));
    // At least the bits of the ports, in the shell and in the module, which has a product of 36.
    assert!(report.cells.flip_flops >= 2 + 18 + 18 + 2 * (2 + 36) && routed.timing.clock_mhz > 50.0, "{report:?}");
    assert!((routed.timing.path.last().expect("a path").at_ns - routed.timing.period_ns).abs() < 0.01, "{report:?}");
    // The fastest of grade 6, although grade 8 is faster.
    let clocks: Vec<f64> = routed.runs.iter().map(|run| run.clock_mhz).collect();
    assert!(routed.timing.clock_mhz == clocks[0].max(clocks[1]) && clocks[2] > routed.timing.clock_mhz, "{clocks:?}");
    // The first bytes of a bitstream are a comment, and its preamble follows.
    assert!(first.bitstream.starts_with(&[0xff, 0x00]), "{:x?}", &first.bitstream[..8]);
    assert!(first.bitstream.windows(4).any(|four| four == [0xff, 0xff, 0xbd, 0xb3]));
    assert_eq!(std::fs::read_dir(folder.path().join("cache")).expect("a folder").count(), 1 + targets.len());
    let again = flow().implement("small", &shell.top, &targets, |_| true).expect("a bitstream");
    assert!(again == first, "another result from the cache");
    let stopped = flow().implement("small", &shell.top, &targets, |_| false);
    assert!(matches!(stopped, Err(ToolError::Stopped)), "{stopped:?}");
}

/// Nothing of a design is left out between two shift registers; for Xilinx's it is alone. A factor of a DSP48 has 17
/// bits without a sign, so the product takes two, which have its registers but those of the lowest 17 bits in
/// series 7. Yosys does not use the registers of DSP48E2.
#[test]
fn a_design_without_its_pins() {
    let (design, folder) = (small(), tempfile::tempdir().expect("a folder"));
    let flow = Flow { yosys: Yosys::find(None).expect("Yosys"), cache: folder.path().into() };
    let implement = |module, device| flow.implement("small", module, &[Target::of(device)], |_| true);
    let report = |module, device| implement(module, device).expect("an implementation").report;
    let shell = reduced(&design).expect("a shell");
    let cells = report(&shell, Device::Ecp5_25k).cells;
    let (inputs, outputs, own) = (1 + 2 + 1 + 18 + 18, 1 + 1 + 2 + 36, 1 + 2 + 36);
    assert_eq!((cells.flip_flops, cells.multipliers), (inputs + outputs + own, 1));
    assert_eq!((shell.inputs().len(), shell.outputs().len()), (1, 1));
    for (device, flip_flops) in [(Device::Xilinx7, 1 + 2 + 17), (Device::XilinxUltrascalePlus, own)] {
        let report = report(&design, device);
        let cells = report.cells;
        assert_eq!(report.routed, None);
        assert_eq!((cells.multipliers, cells.flip_flops, cells.block_rams), (2, flip_flops, 0), "{device}: {cells:?}");
    }
}
