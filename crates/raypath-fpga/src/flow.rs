//! From a design to its cells, and to a bitstream.

use crate::device::{Device, Target};
use crate::netlist::{self, Netlist};
use crate::products;
use crate::report::{Report, Run};
use crate::shell::INSTANCE;
use crate::timing::{self, Timing};
use raypath_hdl::{Module, verilog};
use raypath_tools::{Cache, Key, MAX_RESULT_BYTES, Nextpnr, ToolError, Yosys, read_within, temporary_folder, write};
use raypath_work::pool::{self, Progress};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The tools and a cache, with which designs are implemented.
#[derive(Debug)]
pub struct Flow {
    /// The synthesiser.
    pub yosys: Yosys,
    /// The folder of cached results.
    pub cache: PathBuf,
}

/// A design on a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Implementation {
    /// What it takes, and how fast it is.
    pub report: Report,
    /// nextpnr's textual configuration of the device; empty for Xilinx's.
    pub configuration: String,
    /// The bitstream; empty for Xilinx's.
    pub bitstream: Vec<u8>,
}

/// A placed and routed design.
#[derive(Serialize, Deserialize)]
struct Layout {
    timing: Timing,
    configuration: String,
}

/// Names of files in the folders of the programs.
pub(crate) const DESIGN: &str = "design.sv";
const SCRIPT: &str = "script.ys";
const PRODUCTS: &str = "products.v";
const NETLIST: &str = "netlist.json";
const REPORT: &str = "report.json";
const PINS: &str = "pins.lpf";
const CONFIGURATION: &str = "shell.config";
const BITSTREAM: &str = "shell.bit";

/// The clock's pin, in the package CABGA381: G2 leads to the clock network. From a pin that nextpnr chooses freely, the
/// clock sometimes cannot be routed.
const CLOCK_PIN: &str = "LOCATE COMP \"clk_i\" SITE \"G2\";\nIOBUF PORT \"clk_i\" IO_TYPE=LVCMOS33;\n";

impl Flow {
    /// Synthesises a design. For an ECP5, for which it has few pins, such as a shell, also places and routes it for
    /// each target, and makes the bitstream of the fastest of those with the first target's speed grade. The targets
    /// have one device. `name` names the design in the report.
    ///
    /// Synthesis and layouts go into the cache and are not computed again, so that a stopped run resumes with the step
    /// that it was in. `proceed` gets the number of finished steps several times a second; if it returns false, the
    /// program that runs is ended.
    ///
    /// # Errors
    /// No target; a tool is missing or fails, for example because the design does not fit the device; a file cannot be
    /// written; [`ToolError::Stopped`].
    pub fn implement(
        &self,
        name: &str,
        top: &Arc<Module>,
        targets: &[Target],
        mut proceed: impl FnMut(Progress) -> bool,
    ) -> Result<Implementation, ToolError> {
        let (done, total) = (AtomicU64::new(0), targets.len() as u64 + 2);
        let mut watch = |_: Progress| proceed(Progress { done: done.load(Ordering::Relaxed), total });
        let run = |(): &(), stop: &AtomicBool| match self.steps(name, top, targets, &done, stop) {
            Err(ToolError::Stopped) => Ok(None),
            other => other.map(Some),
        };
        let mut finished = pool::map(&[()], 1, &mut watch, run)?;
        finished.pop().flatten().ok_or(ToolError::Stopped)
    }

    fn steps(
        &self,
        name: &str,
        top: &Arc<Module>,
        targets: &[Target],
        done: &AtomicU64,
        stop: &AtomicBool,
    ) -> Result<Implementation, ToolError> {
        let none = || ToolError::unexpected("nextpnr", "no target", "at least one");
        let Target { device, speed, .. } = *targets.first().ok_or_else(none)?;
        let nextpnr = (!device.is_xilinx()).then(Nextpnr::find).transpose()?;
        let synthesised = self.synthesised(top, device, stop)?;
        let report = |place_and_route: &str, routed| {
            Report::new(name, [&self.yosys.version, place_and_route], device, &synthesised.netlist, routed)
        };
        done.fetch_add(1, Ordering::Relaxed);
        let Some(nextpnr) = nextpnr else {
            let report = report("", None);
            return Ok(Implementation { report, configuration: String::new(), bitstream: Vec::new() });
        };
        let mut runs = Vec::new();
        let mut best: Option<(Target, Layout)> = None;
        for target in targets {
            let layout = self.layout(&nextpnr, name, &synthesised, *target, stop)?;
            done.fetch_add(1, Ordering::Relaxed);
            let clock_mhz = layout.timing.clock_mhz;
            runs.push(Run { speed: target.speed, seed: target.seed, clock_mhz });
            let is_best = best.as_ref().is_none_or(|(_, best)| clock_mhz > best.timing.clock_mhz);
            if target.speed == speed && is_best {
                best = Some((*target, layout));
            }
        }
        let (target, Layout { timing, configuration }) = best.ok_or_else(none)?;
        let bitstream = pack(&nextpnr, &configuration, stop)?;
        Ok(Implementation { report: report(&nextpnr.version, Some((target, timing, runs))), configuration, bitstream })
    }

    /// The design after synthesis, from the cache if it is there.
    fn synthesised(&self, top: &Arc<Module>, device: Device, stop: &AtomicBool) -> Result<Synthesised, ToolError> {
        let mut text = String::new();
        for source in verilog::sources(top, &[])? {
            let is_primitive = source.name == products::MULTIPLIER && !device.is_xilinx();
            text += if is_primitive { products::PRIMITIVE } else { &source.text };
        }
        let script = Script::new(top, device);
        let key = if device.is_xilinx() { "xilinx-synthesis" } else { "ecp5-synthesis" };
        let key = Key::new(key, &[&text, &script.commands, script.map.unwrap_or_default(), &self.yosys.version]);
        let run = || self.run_yosys(&text, &script, top.name(), stop);
        let json: String = Cache::new(&self.cache).kept(&key, |_| true, run)?;
        let shell = top.instances().iter().find(|instance| instance.name == INSTANCE);
        let stages = netlist::stages(shell.map_or(top, |shell| &shell.module));
        let netlist = Netlist::parse(&json, top.name(), &text, stages, shell.is_some())?;
        Ok(Synthesised { key, json, netlist })
    }

    /// The layout of a design, from the cache if it is there.
    fn layout(
        &self,
        nextpnr: &Nextpnr,
        name: &str,
        synthesised: &Synthesised,
        target: Target,
        stop: &AtomicBool,
    ) -> Result<Layout, ToolError> {
        let arguments = arguments(target);
        let parts = [synthesised.key.as_str(), &arguments.join(" "), CLOCK_PIN, &nextpnr.version];
        let run = || {
            let folder = temporary_folder()?;
            write(&folder.path().join(NETLIST), &synthesised.json)?;
            write(&folder.path().join(PINS), CLOCK_PIN)?;
            nextpnr.run(folder.path(), &arguments, name, stop)?;
            let timing = timing::parse(&text_of(folder.path(), REPORT)?, &synthesised.netlist)?;
            Ok(Layout { timing, configuration: text_of(folder.path(), CONFIGURATION)? })
        };
        Cache::new(&self.cache).kept(&Key::new("ecp5-layout", &parts), |_| true, run)
    }

    fn run_yosys(&self, text: &str, script: &Script, top: &str, stop: &AtomicBool) -> Result<String, ToolError> {
        let folder = temporary_folder()?;
        write(&folder.path().join(DESIGN), text)?;
        write(&folder.path().join(SCRIPT), &script.commands)?;
        if let Some(map) = script.map {
            write(&folder.path().join(PRODUCTS), map)?;
        }
        self.yosys.run(folder.path(), SCRIPT, top, stop)?;
        text_of(folder.path(), NETLIST)
    }
}

fn pack(nextpnr: &Nextpnr, configuration: &str, stop: &AtomicBool) -> Result<Vec<u8>, ToolError> {
    let folder = temporary_folder()?;
    write(&folder.path().join(CONFIGURATION), configuration)?;
    nextpnr.pack(folder.path(), CONFIGURATION, BITSTREAM, stop)?;
    read_within(&folder.path().join(BITSTREAM), MAX_RESULT_BYTES)
}

/// A design after synthesis.
struct Synthesised {
    key: Key,
    /// Yosys's JSON.
    json: String,
    netlist: Netlist,
}

/// The commands for Yosys.
struct Script {
    commands: String,
    /// The text of [`PRODUCTS`], if the commands read it.
    map: Option<&'static str>,
}

impl Script {
    /// Products take fewer multipliers if the device has too few of them.
    fn new(design: &Module, device: Device) -> Self {
        let top = design.name();
        let lacks = |multipliers| products::multipliers(design) > multipliers;
        let map = device.multipliers().is_some_and(lacks).then_some(products::MAP);
        // `synth_ecp5` looks for modules that are missing, with its primitives.
        let mut commands = format!("read_verilog -sv -DSYNTHESIS {DESIGN}\nhierarchy -top {top}\n");
        if map.is_some() {
            // The operands of a product in the text are as wide as the product.
            commands += &format!("proc\nflatten\nopt_expr\nwreduce\nopt_clean\ntechmap -map {PRODUCTS}\n");
        }
        commands += &match device.is_xilinx() {
            false => format!("synth_ecp5 -top {top}"),
            true => format!("synth_xilinx -family {} -flatten -noiopad -noclkbuf -top {top}", device.of_tools()),
        };
        // `synth_ecp5` does the first one itself: it names cells by what they drive.
        commands += &format!("\n{}write_json {NETLIST}\n", if device.is_xilinx() { "autoname\n" } else { "" });
        Self { commands, map }
    }
}

/// The arguments for nextpnr. Pins but the clock's are placed freely, and a clock below the aim is no failure. The
/// default router rips up three of four wires of a datapath in binary32 again.
fn arguments(target: Target) -> Vec<String> {
    let files = ["--json", NETLIST, "--lpf", PINS, "--report", REPORT, "--textcfg", CONFIGURATION];
    let options = ["--detailed-timing-report", "--lpf-allow-unconstrained", "--timing-allow-fail", "--quiet"];
    let router = ["--router", "router2"];
    let fixed = files.into_iter().chain(options).chain(router).map(str::to_string);
    target.arguments().into_iter().chain(fixed).collect()
}

fn text_of(folder: &Path, name: &str) -> Result<String, ToolError> {
    let bytes = read_within(&folder.join(name), MAX_RESULT_BYTES)?;
    String::from_utf8(bytes).map_err(|_| ToolError::unexpected(name, "bytes that are not UTF-8", "text"))
}
