//! Features of the paper's operations: the netlist equals the operations bit for bit, and features that are off add no
//! text to that of the plain operations.

use crate::common::drive::{Ports, drive};
use crate::features::check;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_hdl::verilog;
use raypath_ops::EdgeRule;
use raypath_ops::{Angular, Circuit, Culling, Euclidean, JobKind, Operation, RayBox, RayTriangle, Rounding, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, DatapathNetlist, Encoding, Error, Features, Lanes, Multiplier, OperationVisitor,
    Operations, Sharing, UnitLatency,
};

/// Each feature by itself, and all of them.
fn every_feature() -> Vec<(&'static str, Features)> {
    let off = Features::OFF;
    vec![
        ("tag", Features { tag: 8, ..off }),
        ("barycentrics", Features { barycentrics: true, ..off }),
        ("edges once", Features { edges: EdgeRule::Once, ..off }),
        ("culling front", Features { culling: Culling::Front, ..off }),
        ("culling none", Features { culling: Culling::None, ..off }),
        ("facing", Features { facing: true, ..off }),
        ("range", Features { range: true, ..off }),
        ("conservative", Features { conservative: true, ..off }),
        ("quantised boxes", Features { quantised_boxes: true, ..off }),
        ("2 accumulators", Features { accumulators: Accumulators::Two, ..off }),
        ("4 accumulators", Features { accumulators: Accumulators::Four, ..off }),
        ("8 accumulators", Features { accumulators: Accumulators::Eight, ..off }),
        ("16 accumulators", Features { accumulators: Accumulators::Sixteen, ..off }),
        ("exception flags", Features { exception_flags: true, ..off }),
        ("all", Features { exception_flags: true, ..ALL }),
    ]
}

const ALL: Features = Features {
    tag: 32,
    barycentrics: true,
    edges: EdgeRule::Shared,
    culling: Culling::None,
    facing: true,
    range: true,
    conservative: true,
    quantised_boxes: false,
    accumulators: Accumulators::Four,
    exception_flags: false,
};

const SMALL: Config = Config::DEFAULT.lanes(Lanes::Two);

/// All modules as text.
fn text(datapath: &DatapathNetlist) -> String {
    verilog::text(datapath.top()).expect("modules")
}

#[test]
fn features_that_are_off_add_no_hardware() {
    let rounding = Rounding::Unit;
    for rules in [Rules::Paper, Rules::Chisel] {
        let plain = Operations::new()
            .with(&RayBox { rules, is_conservative: false }, JobKind::Quadbox.opcode())
            .and_then(|set| set.with(&RayTriangle { rules, rounding }, JobKind::Triangle.opcode()))
            .and_then(|set| set.with(&Euclidean::<16> { rounding }, JobKind::Euclidean.opcode()))
            .and_then(|set| set.with(&Angular::<8> { rounding }, JobKind::Angular.opcode()))
            .expect("operations");
        let config = Config::DEFAULT.rules(rules).features(Features::default());
        let (plain, off) = (DatapathNetlist::build(plain, config.microarchitecture), DatapathNetlist::new(config));
        assert!(text(&plain.expect("a datapath")) == text(&off.expect("a datapath")));
    }
    assert_eq!(Config::DEFAULT.semantics.features, Features::default());
}

/// Each feature by itself is in the configurations of `raypath verify configurations`.
#[test]
fn features_do_not_depend_on_the_microarchitecture() {
    let all = SMALL.features(ALL);
    let front = Features { conservative: false, culling: Culling::Front, ..ALL };
    for config in [
        all,
        all.control(Control::Credit).unit_latency(UnitLatency::THREE),
        all.io(Encoding::Recoded).multiplier(Multiplier::Inferred).unit_latency(UnitLatency::TWO),
        all.registers(Encoding::Ieee).sharing(Sharing::Segregated),
        all.lanes(Lanes::None).rules(Rules::Chisel).features(front),
        // The widening constant is that of the format.
        all.format(Format::BINARY16),
        all.format(Format::BFLOAT16),
    ] {
        check(config, 1_000);
    }
}

/// A job whose opcode is not configured passes through like any other, and all its outputs are zero.
#[test]
fn unsupported_opcodes_yield_zeros_after_the_latency() {
    let datapath = DatapathNetlist::new(Config::DEFAULT.lanes(Lanes::None)).expect("a datapath");
    let mut rng = ChaCha8Rng::seed_from_u64(16);
    let stems: Vec<&str> = datapath.top().inputs().iter().map(|port| port.stem()).collect();
    let words = stems.into_iter().filter(|stem| !["input_valid", "output_ready", "opcode"].contains(stem));
    let words: Vec<&str> = words.collect();
    let job = |opcode| -> Ports {
        let word = |stem: &&str| match *stem {
            "ray_kx" | "ray_ky" | "ray_kz" => (stem.to_string(), rng.random_range(0..3)),
            _ => (stem.to_string(), f32::from(rng.random_range(-4_i8..=4)).to_bits().into()),
        };
        words.iter().map(word).chain([("opcode".to_string(), opcode)]).collect()
    };
    let jobs: Vec<Ports> = (2..802).map(|number| number % 4).map(job).collect();
    let (answers, first) = drive(&datapath, &jobs);
    assert_eq!(first, 12);
    let mut not_zero = 0;
    for (job, answer) in jobs.iter().zip(answers) {
        assert_eq!(answer["opcode"], job["opcode"], "the opcode is passed along");
        let is_zero = answer.iter().all(|(port, &bits)| port == "opcode" || bits == 0);
        assert!(is_zero || job["opcode"] < 2, "{answer:?}");
        not_zero += usize::from(!is_zero);
    }
    assert!(not_zero > 300, "{not_zero}");
}

/// The display of a configuration lists the features that are on, and no others.
#[test]
fn configurations_name_their_features() {
    assert_eq!(Config::DEFAULT.options(), "");
    let features = Features { tag: 8, culling: Culling::None, facing: true, ..Features::OFF };
    let config = Config::DEFAULT.features(features);
    assert_eq!(config.options(), "--tag 8 --culling none --facing");
    assert_eq!(config.to_string(), "lanes 16, rules paper, tag 8, culling none, facing true");
    let features = Features { accumulators: Accumulators::Sixteen, range: true, ..Features::OFF };
    let config = Config::DEFAULT.features(features).control(Control::Credit);
    assert_eq!(config.options(), "--control credit --range --accumulators 16");
}

#[test]
fn a_tag_that_is_too_wide_or_has_the_port_of_another_is_refused() {
    let config = SMALL.tag(33);
    let error = DatapathNetlist::new(config).expect_err("a wide tag");
    assert_eq!(config.check(), Err(error.clone()));
    assert_eq!(error.to_string(), "tag: 33 bits, expected 1 to 32, or 0 for none");
    let operations = Operations::new().with(&Tagged, 0).expect("an operation").tag(4);
    assert!(matches!(DatapathNetlist::of(operations), Err(Error::Feature { feature: "tag", .. })));
}

raypath_ops::bundle! {
    /// A word at the port of the feature.
    pub struct Tag<C> {
        pub tag: raypath_ops::Word<C, 3>,
    }
}

operation!(Tagged = "tagged", Tag<C> => Tag<C>, |_c, input| input);

/// All lists of features have the same order.
#[test]
fn a_visitor_sees_what_the_hardware_has() {
    struct Names(Vec<(&'static str, u64)>);
    impl OperationVisitor for Names {
        type Error = std::convert::Infallible;
        fn visit<O: Operation + Send + Sync + 'static>(&mut self, _: O, opcode: u64) -> Result<(), Self::Error> {
            self.0.push((O::NAME, opcode));
            Ok(())
        }
    }
    for features in [Features::OFF, ALL] {
        let mut names = Names(Vec::new());
        let Ok(()) = SMALL.features(features).semantics.operations(&mut names);
        assert_eq!(names.0, [("quadbox", 1), ("triangle", 0), ("euclidean", 2), ("angular", 3)]);
    }
}

/// Prints the cost of each feature, for `docs/reference/features.md`:
/// `cargo test --profile tests -p raypath-rtl --test integration options::costs -- --nocapture`.
#[test]
fn costs() {
    let of = |features| {
        let datapath = DatapathNetlist::new(Config::DEFAULT.features(features)).expect("a datapath");
        let mut units = [0_usize; 3];
        for step in 0..datapath.steps().count() {
            let here = datapath.units(step);
            for (sum, here) in units.iter_mut().zip([here.add, here.multiply, here.compare]) {
                *sum += here;
            }
        }
        let (mut live, mut data, mut state) = (0, 0, 0);
        for step in 0..datapath.steps().count() {
            let registers = datapath.registers(step);
            (live, data, state) = (live + registers.live, data + registers.data, state + registers.state);
        }
        (units, [live, data, state])
    };
    let (units_off, bits_off) = of(Features::OFF);
    println!("| off | {units_off:?} | {bits_off:?} |");
    println!("| feature | adders | multipliers | comparators | live bits | data registers | accumulators |");
    for (name, features) in every_feature() {
        let (units, bits) = of(features);
        let more = units.iter().zip(units_off).map(|(&on, off)| on as i64 - off as i64);
        let more = more.chain(bits.iter().zip(bits_off).map(|(&on, off)| on as i64 - off as i64));
        let cells: Vec<String> = more.map(|more| format!("{more:+}")).collect();
        println!("| {name} | {} |", cells.join(" | "));
        // An adder and a comparator for the margin of each conservative box; triangles with features need at most one
        // adder more.
        let margins = 4 * usize::from(features.conservative);
        let is_within = units[2] == units_off[2] + margins && units[0] <= units_off[0] + margins + 1;
        assert!(is_within || features.quantised_boxes, "{name}: {units:?}");
    }
}
