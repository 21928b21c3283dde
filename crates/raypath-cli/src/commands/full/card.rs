//! `raypath card`: the figures of a configuration for architecture simulators.

use crate::commands::full::ppa::Subject;
use crate::commands::unit::not_with_unit;
use crate::{Build, CliError};
use clap::{Args, ValueEnum};
use raypath_embed::{self as embed, Card};
use raypath_ppa::{Power, Report};
use raypath_tools::read_within;
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = not_with_unit())]
pub struct Arguments {
    #[command(flatten)]
    subject: Subject,
    /// Read this card instead of making one
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["preset", "config", "specs", "unit", "liberty", "power"])]
    from: Option<PathBuf>,
    /// Print what this simulator reads instead of JSON
    #[arg(long = "as", value_name = "SIMULATOR")]
    reader: Option<Reader>,
}

/// Who reads the figures.
#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Reader {
    /// Parameters for the component `system` of an AccelWattch file
    Accelwattch,
    /// Parameters and counts for the component `system` of a McPAT file
    Mcpat,
    /// The option -gpgpu_rt_intersection_latency of Vulkan-Sim
    GpgpuSim,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let card = match &arguments.from {
        None => card(&arguments.subject)?,
        Some(path) => {
            // A card has some ten kilobytes.
            let text = String::from_utf8_lossy(&read_within(path, 16 << 20)?).into_owned();
            Card::read(&text).map_err(|problem| CliError::unusable(format!("{}: {problem}", path.display())))?
        }
    };
    let text = match arguments.reader {
        None => card.to_json() + "\n",
        Some(Reader::GpgpuSim) => latencies(&card)?,
        Some(reader) => energies(&card, reader)?,
    };
    Ok(write!(out, "{text}")?)
}

fn card(subject: &Subject) -> Result<Card, CliError> {
    let config = subject.datapath.config()?;
    let mut card = if subject.unit {
        embed::Unit::new(config, subject.parameters.parameters())?.card()
    } else {
        subject.parameters.expect_none("--unit")?;
        let names: Vec<&str> = subject.datapath.specs.iter().map(|spec| spec.name()).collect();
        embed::Datapath::new(config, &names)?.card()
    };
    let Build { commit, is_clean, .. } = Build::current();
    if let Some(commit) = commit {
        card.set("raypath_commit", (commit.to_string() + if is_clean { "" } else { "-dirty" }).into());
    }
    if subject.bench.liberty.is_some() {
        let (report, _) = subject.measure(false)?;
        add(&mut card, &report)?;
    } else if subject.power || subject.bench.is_chosen() {
        let problem =
            "options of the measurement (--power, --period and others) have no effect, expected --liberty too";
        return Err(CliError::unusable(problem));
    }
    Ok(card)
}

/// Adds what was measured.
fn add(card: &mut Card, Report { setting, area, slowest, power, .. }: &Report) -> Result<(), CliError> {
    let measured = json!({
        "library": setting.library, "synthesis": setting.synthesis, "timing": setting.timing,
        "target_ns": setting.period_ns, "area_um2": area.total, "clock_ns": slowest.ns,
    });
    card.set("measured", measured);
    let Some(Power { workloads, .. }) = power else { return Ok(()) };
    let find = |name: String| workloads.iter().find(|workload| workload.name == name);
    card.set("idle_pj_per_cycle", find("idle".to_string()).map(|idle| idle.picojoules_per_cycle).into());
    let mut operations = card.at("/operations")?.clone();
    for (name, operation) in operations.as_object_mut().into_iter().flatten() {
        // Real jobs rather than random ones.
        let workloads = [" of the picture", " of the search", ", random"].map(|jobs| name.clone() + jobs);
        let Some(workload) = workloads.into_iter().find_map(find) else { continue };
        operation["pj_per_job"] = workload.picojoules_per_job.into();
        operation["workload"] = workload.name.clone().into();
    }
    card.set("operations", operations);
    Ok(())
}

/// A line for the configuration of Vulkan-Sim, whose nodes have six boxes and whose leaves have a triangle.
fn latencies(card: &Card) -> Result<String, CliError> {
    let (latency, _) = (card.number("/latency_cycles")?, card.at("/operations/triangle")?);
    let node = latency + card.number("/operations/quadbox/interval_cycles")?;
    Ok(format!(
        "# {}\n# Internal node: two quadbox jobs. Quad leaf and its hit: a triangle job. The others are not raypath's: 4 \
         and 8\n# are those of Vulkan-Sim's own configurations.\n\
         -gpgpu_rt_intersection_latency 4,{node},8,4,{latency},{latency},8\n",
        origin(card)?
    ))
}

/// The energy of a job above idle in joules, and idle power in watts, in the form of McPAT's files.
fn energies(card: &Card, reader: Reader) -> Result<String, CliError> {
    let [clock_ns, area_um2] = [card.number("/measured/clock_ns")?, card.number("/measured/area_um2")?];
    let idle = card.number("/idle_pj_per_cycle")?;
    let tool = |name| card.at(&format!("/measured/{name}"));
    let mut lines = vec![format!(
        "<!-- {}\n     {}, {}, {}\n     power in W = raypath_idle_power + (J of a job) x (jobs) / (seconds), summed over the \
         operations\n     The parser ignores these names: the host reads them, counts jobs and adds the power. -->",
        origin(card)?,
        tool("library")?,
        tool("synthesis")?,
        tool("timing")?
    )];
    let param =
        |name: &str, value: f64, unit: &str| format!("<param name=\"{name}\" value=\"{value:.5e}\"/> <!-- {unit} -->");
    for name in card.at("/operations")?.as_object().into_iter().flat_map(|operations| operations.keys()) {
        let figure = |field: &str| card.number(&format!("/operations/{name}/{field}"));
        let joules = (figure("pj_per_job")? - idle * figure("interval_cycles")?) * 1e-12;
        if reader == Reader::Accelwattch {
            lines.push(param(&format!("RAYPATH_{}_ACC", name.to_uppercase()), joules, "J"));
        } else {
            lines.push(param(&format!("raypath_{name}_energy_per_access"), joules, "J"));
            lines.push(format!("<stat name=\"raypath_{name}_accesses\" value=\"0\"/>"));
        }
    }
    lines.push(param("raypath_idle_power", idle / clock_ns * 1e-3, "W, at the clock rate"));
    lines.push(param("raypath_clock_rate", 1e3 / clock_ns, "MHz"));
    lines.push(param("raypath_area", area_um2 * 1e-6, "mm2"));
    Ok(lines.join("\n") + "\n")
}

/// Where figures come from, for a comment, in which XML has no two dashes.
fn origin(card: &Card) -> Result<String, CliError> {
    let [version, design] =
        [card.at("/raypath_version")?, card.at("/design")?].map(|value| value.as_str().unwrap_or("?"));
    let commit = card.at("/raypath_commit").ok().and_then(Value::as_str).unwrap_or("commit unknown");
    Ok(format!("raypath {version} ({commit}): {design}").replace("--", "- -"))
}
