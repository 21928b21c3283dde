//! Measurements with Yosys, OpenSTA and Debian's cell library: of a design small enough to know its figures, and of an
//! elaborated datapath, whose report finds every register and unit by its name.

use crate::common::{WIDTH, bench, chain, stage};
use raypath_hdl::{Builder, Module};
use raypath_ops::{Circuit, Num, Operation, bundle};
use raypath_ppa::{Bench, Design, Error, Report, Stage};
use raypath_rtl::{Control, DatapathNetlist, Microarchitecture, Operations, UnitKind};
use raypath_tools::ToolError;
use std::sync::Arc;

/// A "floating-point unit": a sum.
fn unit() -> Arc<Module> {
    let m = Builder::new("raypath_fp_add_tiny");
    let (a, b) = (m.input("a_i", WIDTH), m.input("b_i", WIDTH));
    m.output("sum_o", a + b);
    m.finish().expect("a unit")
}

/// Three stages: one that only registers, one with two adders in series, one with a multiplexer before its adder.
fn design() -> Design {
    let first = stage("raypath_tiny_input", true, |_, number| number);
    let second = stage("raypath_tiny_row", false, |m, number| {
        let sum = m.instance("u_add_0", &unit(), &[("a_i", number), ("b_i", number)])[0];
        m.instance("u_add_1", &unit(), &[("a_i", sum), ("b_i", number)])[0]
    });
    let third = stage("raypath_tiny_choice", false, |m, number| {
        let chosen = number.bit(0).mux(!number, number);
        m.instance("u_add_0", &unit(), &[("a_i", chosen), ("b_i", number)])[0]
    });
    let top = chain(&[("u_input", first), ("u_stage_1", second), ("u_stage_2", third)]);
    Design::new("tiny", &top)
}

fn stage_of<'r>(report: &'r Report, name: &str) -> &'r Stage {
    report.stages.iter().find(|stage| stage.name == name).expect(name)
}

/// The elements of a path, without the indices of bits.
fn through(stage: &Stage) -> Vec<&str> {
    let path = stage.slowest.as_ref().expect("a path");
    path.steps.iter().map(|step| step.through.split('[').next().unwrap_or_default()).collect()
}

fn ns(stage: &Stage) -> f64 {
    stage.slowest.as_ref().expect("a path").ns
}

/// A counter that addresses a memory; with or without it the flip-flops are those of the counter.
#[test]
fn memories_are_reported_as_bits() {
    let measured = |depth: Option<u32>| {
        let m = Builder::new("raypath_tiny_store");
        let (enable, data) = (m.input("enable_i", 1), m.input("data_i", 32));
        let count = m.register("count_q", 3).reset_to(0);
        count.next_when(enable, count.wire() + m.constant(3, 1));
        let shown = match depth {
            Some(depth) => {
                let memory = m.memory("u_memory", depth, &[("word", 32)]);
                let address = count.wire().lower(if depth == 4 { 2 } else { 3 });
                memory.write(enable, address, &[data]);
                memory.read(!enable, address)[0]
            }
            None => data,
        };
        m.output("data_o", shown);
        m.output("count_o", count.wire());
        let store = m.finish().expect("a stage");
        let m = Builder::new("raypath");
        let ports = [("enable_i", m.input("enable_i", 1)), ("data_i", m.input("data_i", 32))];
        let outputs = m.instance("u_store", &store, &ports);
        m.output("data_o", outputs[0]);
        m.output("count_o", outputs[1]);
        Design::new("store", &m.finish().expect("a design"))
    };
    let folder = tempfile::tempdir().expect("a folder");
    let designs = [None, Some(4), Some(8)].map(measured);
    let reports = bench(&folder.path().join("cache")).measure(&designs, |_| true).expect("reports");
    let figures: Vec<_> = reports.iter().map(|report| (report.flip_flops, report.memory_bits)).collect();
    assert_eq!(figures, [(3, 0), (3, 4 * 32), (3, 8 * 32)]);
    assert_eq!(reports[1].area, reports[2].area);
    let text = raypath_ppa::tables::summary(&reports[2]);
    assert!(text.contains("3 flip-flops; memories of 256 bits are not in it."), "{text}");
}

#[test]
fn a_design_is_taken_apart_into_stages_and_kinds() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = bench(&folder.path().join("cache"));
    let mut steps = Vec::new();
    let watch = |now| {
        steps.push(now);
        true
    };
    let reports = bench.measure(&[design()], watch).expect("a report");
    let [report] = &reports[..] else { panic!("{} reports", reports.len()) };
    let names: Vec<&str> = report.stages.iter().map(|stage| stage.name.as_str()).collect();
    assert_eq!(names, ["input", "stage 1", "stage 2"]);
    let [input, row, choice] = ["input", "stage 1", "stage 2"].map(|name| stage_of(report, name));

    // Six bits and a valid bit each; the unread register is gone. The areas are those of DFFPOSX1 and DFFSR.
    for stage in [input, row, choice] {
        assert_eq!(stage.flip_flops, 7, "{}", stage.name);
        assert_eq!((stage.area.registers, stage.area.control), (6.0 * 96.0, 176.0), "{}", stage.name);
        assert!(stage.area.register_muxes > 0.0, "holding costs gates: {stage:?}");
    }
    assert_eq!(report.flip_flops, 21);
    assert!(input.area.units.is_empty());
    let (two, one) = (row.area.units["add"], choice.area.units["add"]);
    assert_eq!((two.count, one.count, two.area), (2, 1, 2.0 * one.area));
    assert_eq!(report.area.units["add"].area, 3.0 * one.area);
    assert_eq!((input.area.operand_muxes, row.area.operand_muxes), (0.0, 0.0));
    assert!(choice.area.operand_muxes > 0.0, "{choice:?}");
    let sum: f64 = report.stages.iter().map(|stage| stage.area.total).sum();
    assert!((report.area.total - sum).abs() < 0.01);
    // NAND2X1 has 24.
    assert!((report.kilo_gates * 1000.0 * 24.0 - sum).abs() < 24.0);

    assert_eq!(through(row), ["input num_0_q", "u_add_0", "u_add_1", "gates", "stage 1 num_0_q"]);
    assert_eq!(through(choice), ["stage 1 num_0_q", "gates", "u_add_0", "gates", "stage 2 num_0_q"]);
    assert!(ns(row) > ns(choice) && ns(choice) > ns(input), "{} {} {}", ns(row), ns(choice), ns(input));
    assert_eq!((report.slowest.stage.as_str(), report.slowest.ns), ("stage 1", ns(row)));
    for path in report.stages.iter().filter_map(|stage| stage.slowest.as_ref()) {
        assert!(path.steps.is_sorted_by(|a, b| a.ns <= b.ns) && path.setup_ns > 0.0, "{path:?}");
        assert!((path.steps.last().expect("an end").ns + path.setup_ns - path.ns).abs() < 0.002, "{path:?}");
    }
    let last = steps.last().expect("steps");
    assert_eq!((last.done, last.total), (3, 3), "a unit, what surrounds it, and the timing");

    // A second measurement takes everything from the cache.
    let watch = |now: raypath_ppa::Progress| {
        assert_eq!(now.total, 0);
        true
    };
    assert_eq!(bench.measure(&[design()], watch).expect("a report"), reports);
    // Another period is another measurement. It needs other gates where the period of a block is another one.
    let mut bench = bench;
    for (period, unit_period, programs) in
        [(6.0, None, 3), (9.0, Some(4.0), 2), (9.0, Some(5.0), 2), (10.0, Some(5.0), 1)]
    {
        bench = Bench { period, unit_period, ..bench };
        let mut total = 0;
        let result = bench.measure(&[design()], |now| {
            total = now.total;
            false
        });
        assert!(matches!(result, Err(Error::Tool(ToolError::Stopped))), "{result:?}");
        assert_eq!(total, programs, "{period} ns, {unit_period:?} of it for units");
    }
}

#[test]
fn a_stopped_measurement_leaves_nothing_half_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    let result = bench(&cache).measure(&[design()], |steps| steps.done == 0);
    assert!(matches!(result, Err(Error::Tool(ToolError::Stopped))), "{result:?}");
    let kept = std::fs::read_dir(&cache).map(|files| files.map(|file| file.expect("a file").file_name()).collect());
    let kept: Vec<_> = kept.unwrap_or_default();
    assert!(kept.iter().all(|name| name.to_string_lossy().ends_with(".json.gz")), "{kept:?}");
    // A second measurement resumes from the cache.
    let mut total = 0;
    let watch = |steps: raypath_ppa::Progress| {
        total = steps.total;
        true
    };
    bench(&cache).measure(&[design()], watch).expect("a report");
    assert_eq!(total, 3 - kept.len() as u64);
}

bundle! {
    /// Two numbers.
    pub struct Input<C> {
        /// A number.
        pub a: Num<C>,
        /// Another.
        pub b: Num<C>,
    }
}

bundle! {
    /// One number.
    pub struct Output<C> {
        /// Their sum.
        pub sum: Num<C>,
    }
}

/// One addition in stage 4, one comparison in stage 6.
struct Small;

impl Operation for Small {
    const NAME: &'static str = "small";
    type Input<C: Circuit> = Input<C>;
    type Output<C: Circuit> = Output<C>;
    type State<C: Circuit> = ();
    fn run<C: Circuit>(&self, c: C, input: Input<C>, _: ()) -> (Output<C>, ()) {
        c.stage(4, "a + b");
        let sum = input.a + input.b;
        c.stage(6, "the larger of that and b");
        let order = sum.compare(input.b);
        (Output { sum: order.greater_or_equal().select(sum, input.b) }, ())
    }
}

#[test]
fn registers_and_units_are_found_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = Bench { period: 12.0, ..bench(&folder.path().join("cache")) };
    let controls = [Control::Skid, Control::Credit];
    let datapaths = controls.map(|control| {
        let operations = Operations::new().with(&Small, 2).expect("an operation");
        DatapathNetlist::build(operations, Microarchitecture { control, ..Microarchitecture::DEFAULT })
            .expect("a datapath")
    });
    let designs = datapaths.each_ref().map(|datapath| Design::new("small", datapath.top()));
    let reports = bench.measure(&designs, |_| true).expect("reports");
    for ((control, datapath), report) in controls.into_iter().zip(datapaths).zip(&reports) {
        for (number, step) in datapath.steps().enumerate() {
            let name = if number == 0 { "input".to_string() } else { format!("stage {step}") };
            let stage_of = |name: &str| report.stages.iter().find(|stage| stage.name == name);
            let stage = stage_of(&name).expect(&name);
            // The datapath counts the credit counter with the input; the report has it as a stage.
            let credit = stage_of("credit").filter(|_| number == 0).map_or(0, |credit| credit.flip_flops);
            assert_eq!(stage.flip_flops + credit, datapath.registers(number).flip_flops(), "{control}, {name}");
            for kind in UnitKind::ALL {
                let found = stage.area.units.get(kind.stem()).map_or(0, |units| units.count);
                assert_eq!(found, datapath.units(number).of(kind) as u64, "{control}, {name}: {kind}");
            }
            // DFFPOSX1 is used for data, DFFSR for registers with a reset.
            let registers = datapath.registers(number);
            assert_eq!(stage.area.registers, (registers.data * 96) as f64, "{control}, {name}");
            let control_flip_flops = ((registers.control - credit) * 176) as f64;
            assert!(stage.area.control >= control_flip_flops, "{control}, {name}: {:?}", stage.area);
        }
        assert_eq!(report.slowest.stage, "stage 4");
        let stage = report.stages.iter().find(|stage| stage.name == "stage 4").expect("stage 4");
        let path = stage.slowest.as_ref().expect("a path");
        assert!(path.start.starts_with("stage 3 num_") && path.end.starts_with("stage 4 num_0_"), "{path:?}");
        assert!(path.steps.iter().any(|step| step.through.starts_with("u_add")), "{path:?}");
    }
}
