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

/// Plots a sweep as SVG. Two panels show jobs per cycle and agents per cycle over the number of agents in flight, on a
/// logarithmic axis, with a line for each memory latency. `agents` is the plural name of the agents, such as `rays`.
pub fn plot(sweep: &Sweep, title: &str, agents: &str) -> String {
    let mut latencies: Vec<u64> = sweep.points.iter().map(|point| point.environment.memory_latency).collect();
    latencies.sort_unstable();
    latencies.dedup();
    let (width, height) = (LEFT + 2.0 * WIDTH + BETWEEN + LEGEND, TOP + HEIGHT + 56.0);
    let jobs = Panel { left: LEFT, axis: "jobs per cycle".to_string(), value: |point| point.timing.jobs_per_cycle() };
    let per_agent = Panel {
        left: LEFT + WIDTH + BETWEEN,
        axis: format!("{agents} per cycle"),
        value: |point| point.timing.agents_per_cycle(),
    };
    let mut picture = Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .add(Title::new(title))
        .add(Style::new(STYLE))
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", "#ffffff"))
        .add(text(12.0, 24.0, "head", title))
        .add(jobs.draw(sweep, &latencies, agents))
        .add(per_agent.draw(sweep, &latencies, agents));
    let legend = width - LEGEND + 16.0;
    picture = picture.add(text(legend, TOP + 4.0, "small", "memory latency"));
    for (index, latency) in latencies.iter().enumerate() {
        let y = TOP + 22.0 + 18.0 * index as f64;
        picture = picture.add(line((legend, y), (legend + 20.0, y), colour(index)).set("stroke-width", 2)).add(text(
            legend + 26.0,
            y + 4.0,
            "small",
            &format!("{latency} cycles"),
        ));
    }
    picture.to_string() + "\n"
}

/// One of the two panels.
struct Panel {
    left: f64,
    axis: String,
    value: fn(&Point) -> f64,
}

impl Panel {
    fn draw(&self, sweep: &Sweep, latencies: &[u64], agents: &str) -> Group {
        let (left, bottom) = (self.left, TOP + HEIGHT);
        let in_flight = sweep.points.iter().map(|point| point.environment.in_flight);
        let (fewest, most) = (in_flight.clone().min().unwrap_or(1), in_flight.max().unwrap_or(1));
        // The axis spans whole powers of two.
        let (first, last) = (fewest.max(1).ilog2(), most.max(2).next_power_of_two().ilog2());
        let powers = f64::from((last.saturating_sub(first)).max(1));
        let x = |in_flight: usize| left + ((in_flight as f64).log2() - f64::from(first)) / powers * WIDTH;
        let highest = sweep.points.iter().map(self.value).fold(0.0, f64::max);
        let step = step(highest);
        let top = step * (highest / step).ceil().max(1.0);
        let y = |value: f64| bottom - value / top * HEIGHT;

        let mut group = Group::new().add(text(left, TOP - 14.0, "small", &self.axis)).add(text(
            left + WIDTH / 2.0,
            bottom + 40.0,
            "small middle",
            &format!("{agents} in flight"),
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
        for (index, latency) in latencies.iter().enumerate() {
            let mut points: Vec<&Point> =
                sweep.points.iter().filter(|point| point.environment.memory_latency == *latency).collect();
            points.sort_by_key(|point| point.environment.in_flight);
            let marks =
                points.iter().map(|point| (round(x(point.environment.in_flight)), round(y((self.value)(point)))));
            let marks: Vec<(f64, f64)> = marks.collect();
            let joined: Vec<String> = marks.iter().map(|(x, y)| format!("{x},{y}")).collect();
            let stroke = Polyline::new().set("points", joined.join(" ")).set("fill", "none").set("stroke-width", 2);
            group = group.add(stroke.set("stroke", colour(index)));
            for (point, (x, y)) in points.iter().zip(marks) {
                let title = format!(
                    "{} {agents} in flight, memory {latency} cycles: {} {}",
                    point.environment.in_flight,
                    shown((self.value)(point)),
                    self.axis
                );
                let circle = Circle::new().set("cx", x).set("cy", y).set("r", 3.5).set("fill", colour(index));
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
