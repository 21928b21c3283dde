//! An elaborated datapath in Debian's cell library: the report finds every register and unit by its name.

use raypath_ops::{Circuit, Num, Operation, bundle};
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library};
use raypath_rtl::{Control, Datapath, Microarchitecture, Operations, UnitKind};
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::Path;

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
    let bench = Bench {
        library: Library::read(Path::new(DEFAULT_LIBRARY)).expect("the package qflow-tech-osu018"),
        yosys: Yosys::find(Some(YosysKind::Program)).expect("the package yosys"),
        sta: OpenSta::find().expect("the package opensta"),
        period: 12.0,
        jobs: 2,
        cache: folder.path().join("cache"),
    };
    let controls = [Control::Skid, Control::Credit];
    let datapaths = controls.map(|control| {
        let operations = Operations::new().with(&Small, 2).expect("an operation");
        Datapath::build(operations, Microarchitecture { control, ..Microarchitecture::DEFAULT }).expect("a datapath")
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
