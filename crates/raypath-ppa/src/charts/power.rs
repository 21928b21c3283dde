//! The energy of workloads as bars by kind, and of one of them by stage.

use super::bars::{BAR, COLUMN, LEFT, LEGEND, Segment, axis, bar, colour, legend, scaled};
use crate::power::CLOCK;
use crate::{Power, Report};
use raypath_rtl::report::drawing::{self, text};
use svg::node::element::Group;

const TOP: i32 = 84;
const HEIGHT: i32 = 240;
/// The height of the names under the upper diagram.
const NAMES: i32 = 150;
const LOWER_TOP: i32 = TOP + HEIGHT + NAMES + 60;

/// A column of a diagram.
struct Column {
    name: String,
    segments: Vec<Segment>,
}

/// The energy of a cycle as SVG: above a bar for each workload, below a bar for each stage in the workload that takes
/// most energy, both by kind.
pub fn power(report: &Report, power: &Power) -> String {
    let of_workloads = power.workloads.iter().map(|workload| column(&workload.name, workload.kinds()));
    let of_workloads: Vec<Column> = of_workloads.collect();
    let by_energy = |a: &&crate::WorkloadPower, b: &&crate::WorkloadPower| {
        a.picojoules_per_cycle.total_cmp(&b.picojoules_per_cycle)
    };
    let highest = power.workloads.iter().max_by(by_energy);
    let stages = highest.map(|workload| workload.stages.as_slice()).unwrap_or_default();
    let of_stages = stages.iter().map(|stage| {
        let kinds = stage.kinds.iter().map(|(kind, energy)| (kind.as_str(), *energy));
        column(stage.name.trim_start_matches("stage "), kinds)
    });
    let of_stages: Vec<Column> = of_stages.collect();

    let columns = of_workloads.len().max(of_stages.len()) as i32;
    let right = LEFT + columns * COLUMN;
    let name = highest.map(|workload| workload.name.as_str()).unwrap_or_default();
    let below = format!("pJ per cycle by stage: {name}");
    let kinds = power.workloads.iter().flat_map(|workload| workload.kinds().into_keys().collect::<Vec<_>>());
    let mut kinds: Vec<&str> = kinds.collect();
    kinds.sort_by_key(|kind| order(kind));
    kinds.dedup();
    let entries = kinds.into_iter().map(|kind| (kind.to_string(), colour(kind)));
    drawing::picture("Energy by workload and by stage", right + LEGEND, LOWER_TOP + HEIGHT + 40)
        .add(text(12, 24, "head", &format!("raypath: {}", report.design)))
        .add(text(
            12,
            42,
            "small",
            &format!("clock period {:.2} ns; library {}", power.period_ns, report.setting.library),
        ))
        .add(text(12, TOP - 18, "small", "pJ per cycle by workload"))
        .add(diagram(TOP, right, &of_workloads, true))
        .add(text(12, LOWER_TOP - 18, "small", &below))
        .add(diagram(LOWER_TOP, right, &of_stages, false))
        .add(legend(right + 20, TOP, entries))
        .to_string()
        + "\n"
}

/// The clock first, then as in the diagram of areas.
fn order(kind: &str) -> (u8, String) {
    let place = match kind {
        CLOCK => 0,
        "registers" => 1,
        "control" | "output gates" => 4,
        _ if kind.contains("mux") || kind == "shared logic" => 3,
        _ => 2,
    };
    (place, kind.to_string())
}

fn column<'k>(name: &str, kinds: impl IntoIterator<Item = (&'k str, f64)>) -> Column {
    let mut kinds: Vec<(&str, f64)> = kinds.into_iter().filter(|(_, energy)| *energy > 0.0).collect();
    kinds.sort_by_key(|(kind, _)| order(kind));
    let segment = |(kind, size): (&str, f64)| Segment { name: kind.to_string(), colour: colour(kind), size };
    Column { name: name.to_string(), segments: kinds.into_iter().map(segment).collect() }
}

fn diagram(top: i32, right: i32, columns: &[Column], slanted: bool) -> Group {
    let sum = |column: &Column| column.segments.iter().map(|segment| segment.size).sum::<f64>();
    let max = columns.iter().map(sum).fold(0.001, f64::max);
    let mut group = Group::new().add(axis(top, HEIGHT, right, max));
    for (number, column) in columns.iter().enumerate() {
        let x = LEFT + number as i32 * COLUMN + (COLUMN - BAR) / 2;
        let (middle, bottom) = (x + BAR / 2, top + HEIGHT);
        let height = scaled(sum(column), max, HEIGHT);
        group = group.add(bar(x, bottom, HEIGHT, max, &column.segments)).add(text(
            middle,
            bottom - height - 4,
            "small middle",
            &format!("{:.0}", sum(column)),
        ));
        group = group.add(match slanted {
            true => text(middle, bottom + 12, "small", &column.name)
                .set("transform", format!("rotate(60 {middle} {})", bottom + 12)),
            false => text(middle, bottom + 16, "middle", &column.name),
        });
    }
    group
}
