//! Tables and pictures of a report small enough to compute by hand.

use crate::common::setting::setting;
use raypath_ppa::tables::{
    areas, comparison, energy_by_kind, energy_by_stage, explored, paths, power_summary, summary, units, workloads,
};
use raypath_ppa::{
    Area, Baseline, DesignPoint, Exploration, Path, Power, Report, Setting, Slowest, Stage, StagePower, Step, Units,
    WorkloadPower, charts,
};
use std::collections::BTreeMap;

fn area(units: &[(&str, u64, f64)], registers: f64, operand_muxes: f64) -> Area {
    let units = units.iter().map(|&(kind, count, area)| (kind.to_string(), Units { count, area }));
    let units: BTreeMap<String, Units> = units.collect();
    let total = units.values().map(|units| units.area).sum::<f64>() + registers + operand_muxes;
    Area { total, units, registers, operand_muxes, ..Area::default() }
}

fn path(steps: &[(&str, f64)], setup_ns: f64) -> Path {
    let name = |step: Option<&(&str, f64)>| step.expect("a step").0.to_string();
    Path {
        ns: steps.last().expect("a step").1 + setup_ns,
        start: name(steps.first()),
        end: name(steps.last()),
        steps: steps.iter().map(|(through, ns)| Step { through: through.to_string(), ns: *ns }).collect(),
        setup_ns,
    }
}

/// Two stages: 1,000 and 3,000 µm², 2 and 5 ns.
fn report() -> Report {
    let first = Stage {
        name: "input".to_string(),
        area: area(&[], 1000.0, 0.0),
        flip_flops: 50,
        slowest: Some(path(&[("port a_i", 0.5), ("gates", 1.5), ("input num_0_q[3]", 1.5)], 0.5)),
    };
    let second = Stage {
        name: "stage 1".to_string(),
        area: area(&[("add", 2, 400.0), ("mul", 1, 2000.0)], 500.0, 100.0),
        flip_flops: 1025,
        slowest: Some(path(&[("input num_0_q[3]", 0.25), ("u_mul_0", 4.0), ("stage 1 num_1_q", 4.5)], 0.5)),
    };
    Report {
        design: "small".to_string(),
        setting: setting(),
        area: area(&[("add", 2, 400.0), ("mul", 1, 2000.0)], 1500.0, 100.0),
        flip_flops: 1075,
        memory_bits: 0,
        kilo_gates: 2.0,
        slowest: Slowest { stage: "stage 1".to_string(), ns: 5.0 },
        clock_mhz: 200.0,
        area_period: 0.02,
        stages: vec![first, second],
        power: None,
    }
}

/// The rows of a table as cells. A line without a first cell continues the line before.
fn rows(table: &str) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for line in table.lines().filter(|line| !line.contains("|--")) {
        let cells: Vec<String> = line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect();
        match rows.last_mut() {
            Some(row) if cells[0].is_empty() => {
                for (whole, rest) in row.iter_mut().zip(&cells).filter(|(_, rest)| !rest.is_empty()) {
                    *whole += &format!(" {rest}");
                }
            }
            _ => rows.push(cells),
        }
    }
    rows
}

#[test]
fn tables_show_the_report() {
    let report = report();
    let found = rows(&areas(&report));
    let row = |cells: [&str; 12]| cells.map(str::to_string).to_vec();
    let expected = [
        row(["input", "", "", "1,000", "", "", "", "", "", "1,000", "25.0 %", "50"]),
        row(["stage 1", "2 add, 1 mul", "2,400", "500", "100", "", "", "", "", "3,000", "75.0 %", "1,025"]),
        row(["all", "3", "2,400", "1,500", "100", "", "", "", "", "4,000", "100.0 %", "1,075"]),
        row(["share", "", "60.0 %", "37.5 %", "2.5 %", "0.0 %", "0.0 %", "0.0 %", "0.0 %", "", "", ""]),
    ];
    assert_eq!(found[1..], expected);
    let found = rows(&units(&report));
    assert_eq!(found[1..], [["add", "2", "200", "400", "10.0 %"], ["mul", "1", "2,000", "2,000", "50.0 %"]]);
    let found = rows(&paths(&report));
    assert_eq!(
        found[1..],
        [
            ["input", "2.00", "port a_i", "gates 1.50", "input num_0_q[3]"],
            ["stage 1", "5.00", "input num_0_q[3]", "u_mul_0 4.00", "stage 1 num_1_q"]
        ]
    );
    let words = summary(&report);
    for part in
        ["0.004 mm² = 2.0 kGE (NAND = 1 GE), 60.0 % of it units; 1,075", "5.00 ns, to stage 1: 200.0 MHz", "7.5 ns"]
    {
        assert!(words.contains(part), "{part}: {words}");
    }
    let divided = Setting { unit_period_ns: Some(5.0), ..setting() };
    let words = summary(&Report { setting: divided, ..report });
    assert!(words.contains("gates chosen for 7.5 ns, of which 5 ns for units;"), "{words}");
}

#[test]
fn a_report_survives_its_file_and_compares_with_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = serde_json::to_string_pretty(&report()).expect("JSON");
    assert_eq!(serde_json::from_str::<Report>(&text).expect("a report"), report());
    std::fs::write(folder.path().join("ppa.json"), text).expect("written");
    let found = rows(&comparison(&report(), &Baseline::read(folder.path()).expect("a report")));
    assert_eq!(found[1..], ["input", "stage 1", "all"].map(|name| [name, "1.000", "1.000", "1.000"]));
}

#[test]
fn a_baseline_may_lack_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = r#"{"design": "theirs", "area": {"total": 8000}, "flip_flops": 4300, "slowest": {"ns": 10},
                   "stages": [{"name": "stage 1", "slowest": {"ns": 4}}, {"name": "stage 9", "area": {"total": 1}}]}"#;
    std::fs::write(folder.path().join("ppa.json"), text).expect("written");
    let found = rows(&comparison(&report(), &Baseline::read(folder.path()).expect("a report")));
    assert_eq!(found[1..], [["stage 1", "", "", "1.250"], ["all", "0.500", "0.250", "0.500"]]);
}

/// The original's figures in the repository are those of the paper.
#[test]
fn the_originals_figures_can_be_compared_with() {
    let read = |folder: &str| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/original").join(folder);
        Baseline::read(&path).expect("a report")
    };
    let figures = |baseline: &Baseline| (baseline.area.total, baseline.flip_flops, baseline.slowest.ns);
    assert_eq!(figures(&read("lanes-none")), (1.848e6, 15_867, 17.3));
    let sixteen = read("lanes-16");
    assert_eq!(figures(&sixteen), (2.326e6, 25_600, 17.6));
    // The slowest stage has the slowest path, and the stages have the names of our reports.
    let slowest =
        sixteen.stages.iter().filter_map(|stage| stage.slowest.as_ref()).map(|path| path.ns).fold(0.0, f64::max);
    assert_eq!(slowest, sixteen.slowest.ns);
    assert!((1..=11).all(|number| sixteen.stage(&format!("stage {number}")).is_some()));
}

/// The attributes of all elements that begin with `opening`.
fn elements<'s>(svg: &'s str, opening: &'static str) -> Vec<BTreeMap<&'s str, &'s str>> {
    let opened = svg.split(opening).skip(1);
    let attributes = |element: &'s str| {
        let words: Vec<&str> = element.split('>').next().unwrap_or_default().split('"').collect();
        words.chunks_exact(2).map(|pair| (pair[0].trim().trim_end_matches('='), pair[1])).collect()
    };
    opened.map(attributes).collect()
}

fn number(element: &BTreeMap<&str, &str>, name: &str) -> f64 {
    element[name].parse().expect("a number")
}

#[test]
fn the_length_of_a_bar_is_its_value() {
    let svg = charts::stages(&report());
    // Parts of bars have titles; legends have none.
    let bars: Vec<&str> = svg.split("<rect ").skip(1).filter(|part| part.contains("<title>")).collect();
    let title =
        |bar: &str| bar.split("<title>").nth(1).and_then(|rest| rest.split('<').next()).map(|t| t.trim().to_string());
    let heights: BTreeMap<String, f64> = bars
        .iter()
        .map(|bar| (title(bar).expect("a title"), number(&elements(&format!("<rect {bar}"), "<rect ")[0], "height")))
        .collect();
    // 3,000 µm² is the full height of the upper diagram, 5 ns that of the lower.
    let (area, time) = (320.0 / 3000.0, 150.0 / 5.0);
    let expected = [
        ("mul: 2000.00", 2000.0 * area),
        ("add: 400.00", 400.0 * area),
        ("registers: 1000.00", 1000.0 * area),
        ("u_mul_0: 3.75", 3.75 * time),
        ("gates: 1.00", 1.0 * time),
    ];
    for (title, height) in expected {
        assert!((heights[title] - height).abs() <= 1.0, "{title}: {} for {height}; {heights:?}", heights[title]);
    }
}

#[test]
fn points_are_at_their_figures() {
    let point = |name: &str, lanes, mhz: f64, mm2: f64| {
        let mut report = Report { clock_mhz: mhz, ..report() };
        report.area.total = mm2 * 1e6;
        DesignPoint::new(name, "", lanes, report)
    };
    let points = vec![point("graphics", 0, 100.0, 1.0), point("four", 4, 100.0, 2.0), point("eight", 8, 50.0, 1.0)];
    assert_eq!(points[0].boxes_per_second, 400e6);
    let dimensions: Vec<f64> = points.iter().map(|point| point.dimensions_per_second).collect();
    assert_eq!(dimensions, [0.0, 400e6, 400e6]);
    let exploration = Exploration { points };
    let rows = rows(&explored(&exploration));
    assert_eq!(
        rows.last().map(|row| (row[0].as_str(), row[1].as_str(), row[9].as_str())),
        Some(("eight", "1.000", "400 M"))
    );

    let svg = charts::scatter(&exploration);
    let circles = elements(&svg, "<circle ");
    let [graphics, four, eight, far_four, far_eight] = &circles[..] else { panic!("{} points", circles.len()) };
    // Equal clocks and equal areas align, a larger area is higher; without distance modes only in the first diagram.
    assert_eq!((graphics["cx"], graphics["cy"]), (four["cx"], eight["cy"]));
    assert!(number(four, "cy") < number(graphics, "cy") && number(eight, "cx") < number(graphics, "cx"));
    assert_eq!((far_four["cx"], far_four["cy"], far_eight["cy"]), (far_eight["cx"], four["cy"], eight["cy"]));
    // The least area per job, and per dimension, a second is marked by colour.
    assert!(graphics["fill"] != four["fill"] && four["fill"] == eight["fill"]);
    assert_eq!((far_eight["fill"], far_four["fill"]), (graphics["fill"], four["fill"]));
}

fn workload(name: &str, jobs: u64, stages: &[(&str, &[(&str, f64)])]) -> WorkloadPower {
    let stage = |(name, kinds): &(&str, &[(&str, f64)])| StagePower {
        name: name.to_string(),
        picojoules: kinds.iter().map(|(_, energy)| energy).sum(),
        kinds: kinds.iter().map(|(kind, energy)| (kind.to_string(), *energy)).collect(),
    };
    let stages: Vec<StagePower> = stages.iter().map(stage).collect();
    let sum: f64 = stages.iter().map(|stage| stage.picojoules).sum();
    WorkloadPower {
        name: name.to_string(),
        cycles: 100,
        jobs,
        milliwatts: sum / 5.0,
        picojoules_per_cycle: sum,
        picojoules_per_job: (jobs > 0).then(|| sum * 100.0 / jobs as f64),
        clock: 10.0,
        internal: (sum - 10.0) / 4.0,
        switching: (sum - 10.0) * 0.75,
        leakage: 0.0,
        stages,
    }
}

/// Two workloads: 10 pJ without jobs, and 50 pJ per cycle with a job in every second cycle.
fn power() -> Power {
    let idle = workload("idle", 0, &[("input", &[("clock", 4.0)]), ("stage 1", &[("clock", 6.0)])]);
    let busy: &[(&str, &[(&str, f64)])] =
        &[("input", &[("clock", 4.0), ("registers", 6.0)]), ("stage 1", &[("clock", 6.0), ("mul", 34.0)])];
    let workloads = vec![idle, workload("quadbox, random", 50, busy)];
    Power { period_ns: 5.0, streams: 64, compared_cycles: 12_800, workloads }
}

#[test]
fn energies_are_shown_by_workload_kind_and_stage() {
    let shown = rows(&workloads(&power()));
    assert_eq!(shown[1], ["idle", "0", "2.00", "10.0", "", "100.0 %", "0.0 %", "0.0 %", "0.0 %"]);
    assert_eq!(shown[2], ["quadbox, random", "50", "10.00", "50.0", "100.0", "20.0 %", "20.0 %", "60.0 %", "0.0 %"]);
    let kinds = rows(&energy_by_kind(&power()));
    assert_eq!(kinds[1..], [["clock", "10.00", "10.00"], ["mul", "0.00", "34.00"], ["registers", "0.00", "6.00"]]);
    let stages = rows(&energy_by_stage(&power()));
    assert_eq!(stages[1..], [["input", "4.00", "10.00"], ["stage 1", "6.00", "40.00"]]);
    let text = power_summary(&power());
    assert!(text.starts_with("Idle power is 20.0 % of the highest.\nClock period 5.00 ns."), "{text}");
    assert!(text.contains("in 12,800 cycles"), "{text}");
}

#[test]
fn the_picture_of_energy_has_all_workloads_and_kinds() {
    let picture = charts::power(&report(), &power());
    for word in ["quadbox, random", "idle", "clock: 4.00", "clock: 10.00", "mul: 34.00", "by stage: quadbox, random"] {
        assert!(picture.contains(word), "{word}");
    }
    let with_power = Report { power: Some(power()), ..report() };
    let json = serde_json::to_string(&with_power).expect("JSON");
    assert_eq!(serde_json::from_str::<Report>(&json).expect("a report"), with_power);
    assert!(!serde_json::to_string(&report()).expect("JSON").contains("power"));
}
