//! A plot of a sweep.

use crate::sweep::{Point, Sweep};
use svg::Document;
use svg::node::element::{Circle, Group, Line, Polyline, Rectangle, Style, Text, Title};

const STYLE: &str = "text { font: 12px sans-serif; fill: #222 } .head { font-weight: bold } \
                     .small { font-size: 10.5px } .right { text-anchor: end } .middle { text-anchor: middle }";
/// The palette of Okabe and Ito, which is safe for colour-blind readers.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#222222"];
const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 280.0;
const LEFT: f64 = 76.0;
const TOP: f64 = 66.0;
const BETWEEN: f64 = 96.0;
const LEGEND: f64 = 150.0;

/// Lines over a number on a logarithmic axis, in panels side by side.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plot {
    /// The title.
    pub title: String,
    /// What the numbers on the horizontal axes are.
    pub horizontal: String,
    /// The panels, from the left.
    pub panels: Vec<Panel>,
    /// The title of the legend.
    pub legend: String,
    /// The names of the lines' colours.
    pub colours: Vec<String>,
}

/// A panel of a [`Plot`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// What its values are.
    pub axis: String,
    /// Its lines.
    pub lines: Vec<Series>,
}

/// A line of a [`Panel`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// The index in [`Plot::colours`].
    pub colour: usize,
    /// A limit: dashed, without points.
    pub is_limit: bool,
    /// Numbers, at least 1 and ascending, and their values.
    pub points: Vec<(usize, f64)>,
}

/// Plots a sweep as SVG. Two panels show jobs per cycle and agents per cycle over the number of agents in flight, on a
/// logarithmic axis, with a line for each memory latency. `agents` is the plural name of the agents, such as `rays`.
pub fn plot(sweep: &Sweep, title: &str, agents: &str) -> String {
    let mut latencies: Vec<u64> = sweep.points.iter().map(|point| point.environment.memory_latency).collect();
    latencies.sort_unstable();
    latencies.dedup();
    let panel = |axis: String, value: fn(&Point) -> f64| {
        let line = |(colour, latency): (usize, &u64)| {
            let points = sweep.points.iter().filter(|point| point.environment.memory_latency == *latency);
            let mut points: Vec<_> = points.map(|point| (point.environment.in_flight, value(point))).collect();
            points.sort_by_key(|(in_flight, _)| *in_flight);
            Series { colour, is_limit: false, points }
        };
        Panel { axis, lines: latencies.iter().enumerate().map(line).collect() }
    };
    let plot = Plot {
        title: title.to_string(),
        horizontal: format!("{agents} in flight"),
        panels: vec![
            panel("jobs per cycle".to_string(), |point| point.timing.jobs_per_cycle()),
            panel(format!("{agents} per cycle"), |point| point.timing.agents_per_cycle()),
        ],
        legend: "memory latency".to_string(),
        colours: latencies.iter().map(|latency| format!("{latency} cycles")).collect(),
    };
    plot.svg()
}

impl Plot {
    /// The plot as SVG.
    pub fn svg(&self) -> String {
        let panels = self.panels.len() as f64;
        let (width, height) = (LEFT + panels * WIDTH + (panels - 1.0) * BETWEEN + LEGEND, TOP + HEIGHT + 56.0);
        let mut picture = Document::new()
            .set("viewBox", (0, 0, width, height))
            .set("width", width)
            .set("height", height)
            .add(Title::new(self.title.as_str()))
            .add(Style::new(STYLE))
            .add(Rectangle::new().set("width", width).set("height", height).set("fill", "#ffffff"))
            .add(text(12.0, 24.0, "head", &self.title));
        for (place, panel) in self.panels.iter().enumerate() {
            picture = picture.add(self.panel(LEFT + place as f64 * (WIDTH + BETWEEN), panel));
        }
        let legend = width - LEGEND + 16.0;
        picture = picture.add(text(legend, TOP + 4.0, "small", &self.legend));
        for (index, name) in self.colours.iter().enumerate() {
            let y = TOP + 22.0 + 18.0 * index as f64;
            let sample = line((legend, y), (legend + 20.0, y), colour(index)).set("stroke-width", 2);
            picture = picture.add(sample).add(text(legend + 26.0, y + 4.0, "small", name));
        }
        picture.to_string() + "\n"
    }

    fn panel(&self, left: f64, Panel { axis, lines }: &Panel) -> Group {
        let bottom = TOP + HEIGHT;
        let numbers = self.panels.iter().flat_map(|panel| &panel.lines).flat_map(|line| &line.points);
        let numbers = numbers.map(|(number, _)| *number);
        let (fewest, most) = (numbers.clone().min().unwrap_or(1), numbers.max().unwrap_or(1));
        // The axis spans whole powers of two.
        let (first, last) = (fewest.max(1).ilog2(), most.max(2).next_power_of_two().ilog2());
        let powers = f64::from((last.saturating_sub(first)).max(1));
        let x = |number: usize| left + ((number as f64).log2() - f64::from(first)) / powers * WIDTH;
        let highest = lines.iter().flat_map(|line| &line.points).map(|(_, value)| *value).fold(0.0, f64::max);
        let step = step(highest);
        let top = step * (highest / step).ceil().max(1.0);
        let y = |value: f64| bottom - value / top * HEIGHT;

        let mut group = Group::new().add(text(left, TOP - 14.0, "small", axis)).add(text(
            left + WIDTH / 2.0,
            bottom + 40.0,
            "small middle",
            &self.horizontal,
        ));
        for number in 0..=(top / step).round() as u32 {
            let value = f64::from(number) * step;
            group = group
                .add(line((left, y(value)), (left + WIDTH, y(value)), if number == 0 { "#222222" } else { "#dddddd" }))
                .add(text(left - 6.0, y(value) + 4.0, "small right", &shown(value)));
        }
        let every = (last.saturating_sub(first) / 10 + 1) as usize;
        for power in (first..=last).step_by(every) {
            let at = x(1_usize.checked_shl(power).unwrap_or(usize::MAX));
            group = group.add(line((at, bottom), (at, bottom + 4.0), "#222222")).add(text(
                at,
                bottom + 18.0,
                "small middle",
                &format!("{}", 1_u128 << power),
            ));
        }
        for Series { colour: index, is_limit, points } in lines {
            let marks = points.iter().map(|(number, value)| (round(x(*number)), round(y(*value))));
            let joined: Vec<String> = marks.clone().map(|(x, y)| format!("{x},{y}")).collect();
            let stroke = Polyline::new().set("points", joined.join(" ")).set("fill", "none").set("stroke-width", 2);
            let stroke = stroke.set("stroke", colour(*index));
            if *is_limit {
                group = group.add(stroke.set("stroke-dasharray", "5 4").set("stroke-width", 1));
                continue;
            }
            group = group.add(stroke);
            let name = self.colours.get(*index).map_or("", String::as_str);
            for ((number, value), (x, y)) in points.iter().zip(marks) {
                let title = format!("{number} {}, {} {name}: {} {axis}", self.horizontal, self.legend, shown(*value));
                let circle = Circle::new().set("cx", x).set("cy", y).set("r", 3.5).set("fill", colour(*index));
                group = group.add(circle.add(Title::new(title)));
            }
        }
        group
    }
}

fn text(x: f64, y: f64, class: &str, content: &str) -> Text {
    Text::new(content).set("x", round(x)).set("y", round(y)).set("class", class)
}

fn line(from: (f64, f64), to: (f64, f64), colour: &str) -> Line {
    let line = Line::new().set("x1", round(from.0)).set("y1", round(from.1));
    line.set("x2", round(to.0)).set("y2", round(to.1)).set("stroke", colour)
}

fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// The grid step for an axis to `highest`: 1, 2 or 5 times a power of ten, for about five steps.
fn step(highest: f64) -> f64 {
    if highest <= 0.0 {
        return 1.0;
    }
    let rough = highest / 5.0;
    let ten = 10_f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * ten)
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(10.0 * ten)
}

/// The value with four significant digits.
fn shown(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

fn round(pixels: f64) -> f64 {
    (pixels * 10.0).round() / 10.0
}
