//! `raypath box-bits`: what boxes in fewer bits add to the visits of rays, and what they take off the area.

use crate::commands::full::MemoryArguments;
use crate::commands::full::measuring::BenchArguments;
use crate::commands::full::ppa::design;
use crate::commands::full::visits::{SIZE, scenes, visits};
use crate::{CliError, ConfigArguments, Progress, whole};
use clap::Args;
use raypath_float::Format;
use raypath_ops::{BoxBits, Rules};
use raypath_ppa::{Design, Report};
use raypath_rtl::Config;
use raypath_sim::files::write_all;
use raypath_timing::{Panel, Plot, Series};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Meshes beside the built-in scene: .obj, .gltf, .glb, .ply or .stl
    scenes: Vec<PathBuf>,
    /// The bits to compare with the rules paper [default: 8 to 24]
    #[arg(long, value_delimiter = ',', value_name = "N,...")]
    bits: Vec<BoxBits>,
    /// Ambient-occlusion rays per hit, besides a shadow ray
    #[arg(long, default_value_t = 2, value_parser = whole(0..=64u32), value_name = "N")]
    ao: u32,
    /// Measure the area of each number of bits too, with Yosys and OpenSTA
    #[arg(long)]
    area: bool,
    #[command(flatten)]
    memory: MemoryArguments,
    #[command(flatten)]
    bench: BenchArguments,
    #[command(flatten)]
    config: ConfigArguments,
    /// The plot to write: visits added, over the area with --area, otherwise over the bits
    #[arg(long, default_value = "build/box-bits.svg", value_name = "FILE.svg")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.config.paper()?;
    if config.semantics.rules != Rules::Paper || config.semantics.format != Format::BINARY32 {
        return Err(CliError::unusable(format!(
            "{config}: expected rules paper and format fp32, which are compared with"
        )));
    }
    if !arguments.area && arguments.bench.is_chosen() {
        let problem = "options of the measurement (--liberty, --period and others) have no effect, expected --area too";
        return Err(CliError::unusable(problem));
    }
    let all = || (BoxBits::MIN.0..=BoxBits::MAX.0).map(BoxBits).collect();
    let bits: Vec<BoxBits> = if arguments.bits.is_empty() { all() } else { arguments.bits.clone() };
    let scenes = scenes(&arguments.scenes, arguments.memory.limit)?;
    let mut progress = Progress::new("pictures", (bits.len() + 1) * scenes.len());
    let rules: Vec<Rules> = [Rules::Paper].into_iter().chain(bits.iter().copied().map(Rules::Bounds)).collect();
    let mut counts = vec![vec![0; scenes.len()]; rules.len()];
    let mut done = 0;
    for (row, &rules) in counts.iter_mut().zip(&rules) {
        for (count, shown) in row.iter_mut().zip(&scenes) {
            if progress.at(done) {
                *count = visits(shown, rules, arguments.ao)?;
                done += 1;
            }
        }
    }
    progress.finish(done)?;
    let added = |row: usize, scene: usize| 100.0 * (counts[row][scene] as f64 / counts[0][scene] as f64 - 1.0);
    let areas = if arguments.area { Some(areas(&arguments.bench, config, &bits)?) } else { None };

    let names = scenes.iter().map(|shown| shown.name.as_str()).collect::<Vec<_>>().join(" | ");
    let area_columns = if areas.is_some() { " area, µm² | of that with rules paper |" } else { "" };
    let (width, height) = SIZE;
    writeln!(
        out,
        "Visits of nodes and leaves added to those with rules paper, {width} x {height} pixels, per hit a shadow"
    )?;
    writeln!(out, "ray and {} ambient-occlusion rays.\n\n| bits | {names} |{area_columns}", arguments.ao)?;
    writeln!(out, "|{}", " --- |".repeat(1 + scenes.len() + if areas.is_some() { 2 } else { 0 }))?;
    for (row, bits) in bits.iter().enumerate() {
        let cells: Vec<String> = (0..scenes.len()).map(|scene| format!("{:+.2} %", added(row + 1, scene))).collect();
        let area = areas.as_ref().map(|areas| format!(" {:.0} | {:.3} |", areas[row + 1], areas[row + 1] / areas[0]));
        writeln!(out, "| {bits} | {} |{}", cells.join(" | "), area.unwrap_or_default())?;
    }

    let number = |row: usize| areas.as_ref().map_or(bits[row].0 as usize, |areas| (areas[row + 1] / 1000.0) as usize);
    let line = |scene: usize| {
        let mut points: Vec<(usize, f64)> = (0..bits.len()).map(|row| (number(row), added(row + 1, scene))).collect();
        points.sort_by_key(|(number, _)| *number);
        Series { colour: scene, is_limit: false, points }
    };
    let plot = Plot {
        title: format!("Boxes in fewer bits: {config}"),
        horizontal: if areas.is_some() { "area in 1000 µm²" } else { "bits of a significand" }.to_string(),
        panels: vec![Panel { axis: "visits added, %".to_string(), lines: (0..scenes.len()).map(line).collect() }],
        legend: "scene".to_string(),
        colours: scenes.into_iter().map(|shown| shown.name).collect(),
    };
    write_all(&[(arguments.out.clone(), plot.svg())])?;
    writeln!(out, "\nWrote {}.", arguments.out.display())?;
    Ok(())
}

/// The areas with rules paper and with each number of bits.
fn areas(bench: &BenchArguments, config: Config, bits: &[BoxBits]) -> Result<Vec<f64>, CliError> {
    let narrow = |bits: &BoxBits| config.rules(Rules::Bounds(*bits)).box_bits(*bits);
    let configs = [config].into_iter().chain(bits.iter().map(narrow));
    let designs = configs.map(design).collect::<Result<Vec<Design>, CliError>>()?;
    let reports: Vec<Report> = bench.measure(&designs)?;
    Ok(reports.iter().map(|report| report.area.total).collect())
}
