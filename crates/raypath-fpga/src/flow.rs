//! From a shell to a bitstream.

use crate::device::{Device, Target};
use crate::netlist;
use crate::products;
use crate::report::{Cells, Report};
use crate::shell::Shell;
use crate::timing::{self, Timing};
use raypath_hdl::{Module, verilog};
use raypath_tools::{Cache, Key, MAX_RESULT_BYTES, Nextpnr, ToolError, Yosys, read_within, temporary_folder, write};
use raypath_work::pool::{self, Progress};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The tools and a cache, with which shells are implemented.
#[derive(Debug)]
pub struct Flow {
    /// The synthesiser.
    pub yosys: Yosys,
    /// The program that places and routes.
    pub nextpnr: Nextpnr,
    /// The folder of cached results.
    pub cache: PathBuf,
}

/// A shell on a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Implementation {
    /// What it takes, and how fast it is.
    pub report: Report,
    /// nextpnr's textual configuration of the device.
    pub configuration: String,
    /// The bitstream.
    pub bitstream: Vec<u8>,
}

/// A synthesised shell.
#[derive(Serialize, Deserialize)]
struct Synthesis {
    cells: BTreeMap<String, Cells>,
    /// Yosys's JSON.
    netlist: String,
}

/// A placed and routed shell.
#[derive(Serialize, Deserialize)]
struct Layout {
    timing: Timing,
    configuration: String,
}

/// Names of files in the folders of the programs.
const DESIGN: &str = "design.sv";
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

/// Synthesis; place and route; the bitstream.
const STEPS: u64 = 3;

impl Flow {
    /// Synthesises, places and routes a shell, and makes the bitstream. `design` names it in the report.
    ///
    /// Synthesis and layout go into the cache and are not computed again, so that a stopped run resumes with the step
    /// that it was in. `proceed` gets the number of finished steps several times a second; if it returns false, the
    /// program that runs is ended.
    ///
    /// # Errors
    /// A tool is missing or fails, for example because the design does not fit the device; a file cannot be written;
    /// [`ToolError::Stopped`].
    pub fn implement(
        &self,
        design: &str,
        shell: &Shell,
        target: Target,
        mut proceed: impl FnMut(Progress) -> bool,
    ) -> Result<Implementation, ToolError> {
        let done = AtomicU64::new(0);
        let mut watch = |_: Progress| proceed(Progress { done: done.load(Ordering::Relaxed), total: STEPS });
        let run = |(): &(), stop: &AtomicBool| match self.steps(design, shell, target, &done, stop) {
            Err(ToolError::Stopped) => Ok(None),
            other => other.map(Some),
        };
        let mut finished = pool::map(&[()], 1, &mut watch, run)?;
        finished.pop().flatten().ok_or(ToolError::Stopped)
    }

    fn steps(
        &self,
        design: &str,
        shell: &Shell,
        target: Target,
        done: &AtomicU64,
        stop: &AtomicBool,
    ) -> Result<Implementation, ToolError> {
        let cache = Cache::new(&self.cache);
        let mut text = String::new();
        for source in verilog::sources(&shell.top, &[])? {
            text += &source.text;
        }
        let top = shell.top.name();
        let script = Script::new(&shell.top, target.device);
        let synthesis_key =
            Key::new("ecp5-synthesis", &[&text, &script.commands, script.map.unwrap_or_default(), &self.yosys.version]);
        let synthesis: Synthesis =
            cache.kept(&synthesis_key, |_| true, || self.synthesise(&text, &script, top, stop))?;
        done.store(1, Ordering::Relaxed);

        let arguments = arguments(target);
        let parts = [synthesis_key.as_str(), &arguments.join(" "), CLOCK_PIN, &self.nextpnr.version];
        let layout_key = Key::new("ecp5-layout", &parts);
        let lay_out = || self.lay_out(&synthesis.netlist, &arguments, design, stop);
        let Layout { timing, configuration } = cache.kept(&layout_key, |_| true, lay_out)?;
        done.store(2, Ordering::Relaxed);

        let bitstream = self.pack(&configuration, stop)?;
        let tools = [self.yosys.version.as_str(), self.nextpnr.version.as_str()];
        let report = Report::new(design, tools, target, &synthesis.cells, timing, &stages(shell));
        Ok(Implementation { report, configuration, bitstream })
    }

    fn synthesise(&self, text: &str, script: &Script, top: &str, stop: &AtomicBool) -> Result<Synthesis, ToolError> {
        let folder = temporary_folder()?;
        write(&folder.path().join(DESIGN), text)?;
        write(&folder.path().join(SCRIPT), &script.commands)?;
        if let Some(map) = script.map {
            write(&folder.path().join(PRODUCTS), map)?;
        }
        self.yosys.run(folder.path(), SCRIPT, top, stop)?;
        let netlist = text_of(folder.path(), NETLIST)?;
        Ok(Synthesis { cells: netlist::cells(&netlist, top)?, netlist })
    }

    fn lay_out(
        &self,
        netlist: &str,
        arguments: &[String],
        design: &str,
        stop: &AtomicBool,
    ) -> Result<Layout, ToolError> {
        let folder = temporary_folder()?;
        write(&folder.path().join(NETLIST), netlist)?;
        write(&folder.path().join(PINS), CLOCK_PIN)?;
        self.nextpnr.run(folder.path(), arguments, design, stop)?;
        let timing = timing::parse(&text_of(folder.path(), REPORT)?)?;
        Ok(Layout { timing, configuration: text_of(folder.path(), CONFIGURATION)? })
    }

    fn pack(&self, configuration: &str, stop: &AtomicBool) -> Result<Vec<u8>, ToolError> {
        let folder = temporary_folder()?;
        write(&folder.path().join(CONFIGURATION), configuration)?;
        self.nextpnr.pack(folder.path(), CONFIGURATION, BITSTREAM, stop)?;
        read_within(&folder.path().join(BITSTREAM), MAX_RESULT_BYTES)
    }
}

/// The commands for Yosys.
struct Script {
    commands: String,
    /// The text of [`PRODUCTS`], if the commands read it.
    map: Option<&'static str>,
}

impl Script {
    /// Products take fewer multipliers if the device has too few of them.
    fn new(shell: &Module, device: Device) -> Self {
        let top = shell.name();
        let map = (products::multipliers(shell) > device.multipliers()).then_some(products::MAP);
        let mut commands = format!("read_verilog -sv -DSYNTHESIS {DESIGN}\nhierarchy -check -top {top}\n");
        if map.is_some() {
            // The operands of a product in the text are as wide as the product.
            commands += &format!("proc\nflatten\nopt_expr\nwreduce\nopt_clean\ntechmap -map {PRODUCTS}\n");
        }
        commands += &format!("synth_ecp5 -top {top} -json {NETLIST}\n");
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

/// The names of the datapath's instances in reports, in order.
fn stages(shell: &Shell) -> Vec<String> {
    let datapath = shell.top.instances().iter().flat_map(|datapath| datapath.module.instances());
    datapath.map(|instance| instance.stem().to_string()).collect()
}

fn text_of(folder: &Path, name: &str) -> Result<String, ToolError> {
    let bytes = read_within(&folder.join(name), MAX_RESULT_BYTES)?;
    String::from_utf8(bytes).map_err(|_| ToolError::unexpected(name, "bytes that are not UTF-8", "text"))
}
