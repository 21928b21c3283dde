//! Throughput of a unit over what it holds at a time, memory latencies and widths, as a table and a plot.

use crate::CliError;
use raypath_timing::{Panel, Plot, Series};
use std::collections::BTreeSet;
use std::io::Write;

/// A simulated point.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Bits of a beat of the memory.
    pub width: u32,
    /// Cycles of the memory.
    pub latency: u64,
    /// What the unit holds at a time.
    pub contexts: u32,
    /// What was reached in a cycle.
    pub reached: f64,
    /// The most in a cycle.
    pub bound: f64,
}

/// The points of a sweep, and what they are called.
pub struct UnitSweep {
    /// What has throughput.
    pub title: &'static str,
    /// What is held at a time.
    pub contexts: &'static str,
    /// What is done in a cycle.
    pub work: &'static str,
    pub points: Vec<Point>,
}

/// All combinations, in order: width, latency, contexts.
pub fn grid<const N: usize>(widths: [u32; 3], latencies: [u64; 3], contexts: [u32; N]) -> Vec<(u32, u64, u32)> {
    let of_width =
        |width: u32| latencies.into_iter().flat_map(move |latency| contexts.map(|contexts| (width, latency, contexts)));
    widths.into_iter().flat_map(of_width).collect()
}

impl UnitSweep {
    /// Prints a line for each point.
    pub fn print(&self, out: &mut dyn Write) -> Result<(), CliError> {
        let (contexts, work) = (self.contexts, format!("{}/cycle", self.work));
        writeln!(out, "\n  bits  latency  {contexts}  {work}  bound  ratio")?;
        for Point { width, latency, contexts: count, reached, bound } in &self.points {
            let (first, second) = (contexts.len() + 1, work.len() + 1);
            let ratio = reached / bound;
            writeln!(out, "{width:>6} {latency:>8} {count:>first$} {reached:>second$.3} {bound:>6.3} {ratio:>6.3}")?;
        }
        Ok(())
    }

    /// An SVG with a panel for each width and a colour for each latency.
    pub fn svg(&self) -> String {
        let (widths, latencies) = (self.distinct(|point| point.width), self.distinct(|point| point.latency));
        let panel = |width: &u32| {
            let line = |(colour, latency): (usize, &u64), is_limit: bool| {
                let here = self.points.iter().filter(|point| (point.width, point.latency) == (*width, *latency));
                let value = |point: &Point| if is_limit { point.bound } else { point.reached };
                let points = here.map(|point| (point.contexts as usize, value(point))).collect();
                Series { colour, is_limit, points }
            };
            let of = |is_limit: bool| latencies.iter().enumerate().map(move |latency| line(latency, is_limit));
            let axis = format!("{} per cycle, {width} bits a beat", self.work);
            Panel { axis, lines: of(false).chain(of(true)).collect() }
        };
        let plot = Plot {
            title: format!("Throughput of {}; dashed: bound", self.title),
            horizontal: self.contexts.to_string(),
            panels: widths.iter().map(panel).collect(),
            legend: "memory latency".to_string(),
            colours: latencies.iter().map(|latency| format!("{latency} cycles")).collect(),
        };
        plot.svg()
    }

    fn distinct<T: Ord>(&self, of: fn(&Point) -> T) -> BTreeSet<T> {
        self.points.iter().map(of).collect()
    }
}
