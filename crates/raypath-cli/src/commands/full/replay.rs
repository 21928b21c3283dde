//! `raypath replay`: runs recorded transactions through an engine and compares the outcomes with the recorded ones.

use crate::commands::full::{StreamArguments, ViewArguments, print, recording, write_and_name};
use crate::{CliError, DatapathArguments, Progress};
use clap::{Args, ValueEnum};
use raypath_float::Format;
use raypath_model::Elastic;
use raypath_ops::{PortKind, PortValue};
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::{CycleEngine, Engine, NetlistEngine, Run, Seen, evaluate, observe, shape};
use raypath_sim::lockstep::SideBySide;
use raypath_sim::transactions::Transaction;
use raypath_sim::{OperationId, WordModel, Words};
use raypath_timing::report::{Recorder, Recording};
use raypath_timing::{Observer, PortActivity};
use std::io::Write;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    stream: StreamArguments,
    /// The engine: the functional model, the cycle-exact model, the netlist, or the latter two in lockstep
    #[arg(long, value_enum, default_value_t = EngineKind::Model)]
    engine: EngineKind,
    /// The number of mismatches to show field by field
    #[arg(long, default_value_t = 3)]
    show: usize,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    datapath: DatapathArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineKind {
    Model,
    Cycle,
    Netlist,
    /// The netlist, with its ports compared in every cycle with the cycle-exact model's
    Both,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let (config, whole) = arguments.datapath.datapath()?;
    let model = whole.model();
    let stream = arguments.stream.read(&model, config)?;
    let begin = Instant::now();
    let mut progress = Progress::new("jobs", stream.len());
    let mut tally = Tally::new(&model, &stream, arguments.show);
    let mut differences = Vec::new();
    let datapath = whole.elaborate()?;
    let mut watcher = Watcher::new(&arguments.view, config, &datapath);
    let run =
        simulate(arguments, (model, config, &datapath), &stream, &mut watcher, &mut differences, |index, outcome| {
            tally.compare(index, outcome);
            progress.at(index + 1)
        })?;
    let stopped = progress.finish(run.jobs).map_err(CliError::from);
    tally.report(&run, begin, out)?;
    if arguments.view.is_wanted() {
        let recording = watcher.recording(config, &datapath, &run, &tally);
        writeln!(out)?;
        print(&recording, out)?;
        write_and_name(&arguments.view.files(&recording), out)?;
    }
    differences.iter().try_for_each(|difference| writeln!(out, "\n{difference}"))?;
    match differences.len() {
        0 => tally.verdict(&run, stopped),
        _ => Err(CliError::Mismatch("the netlist and the models differ".to_string())),
    }
}

/// Runs the stream through the selected engine until `on_outcome` returns false. `differences` is for lockstep.
fn simulate(
    arguments: &Arguments,
    (model, config, datapath): (WordModel, Config, &DatapathNetlist),
    stream: &[Transaction],
    watcher: &mut Watcher,
    differences: &mut Vec<String>,
    mut on_outcome: impl FnMut(usize, &Words) -> bool,
) -> Result<Run, CliError> {
    let mut traffic = arguments.stream.traffic()?;
    if arguments.view.is_wanted() && arguments.engine == EngineKind::Model {
        let problem = "--engine model has no cycles, expected cycle, netlist or both with --report or --konata";
        return Err(CliError::unusable(problem));
    }
    if arguments.stream.is_recorded() && arguments.engine == EngineKind::Model {
        let problem = "--engine model has no cycles, expected cycle, netlist or both with recorded handshakes";
        return Err(CliError::unusable(problem));
    }
    let jobs = stream.iter().map(|transaction| &transaction.job);
    let mut on_cycle = |seen: &Seen| {
        watcher.look(seen, |index| stream[index].job.kind().opcode());
        match (seen.left, &seen.shown.output) {
            (Some(index), Some(outcome)) => on_outcome(index, outcome),
            _ => true,
        }
    };
    let mut engine: Box<dyn Engine> = match arguments.engine {
        EngineKind::Model => return Ok(evaluate(model, jobs, |index, outcome| on_outcome(index, &outcome))),
        EngineKind::Cycle => Box::new(CycleEngine::new(model, &shape(config, datapath))),
        EngineKind::Netlist => Box::new(NetlistEngine::of(model, config, datapath, |_| false)?),
        EngineKind::Both => {
            let mut netlist = NetlistEngine::of(model.clone(), config, datapath, |_| false)?;
            let mut both = SideBySide::new(&mut netlist, model, |_| {});
            let run = observe(&mut both, jobs, &mut traffic, on_cycle);
            *differences = both.differences;
            return Ok(run);
        }
    };
    Ok(observe(engine.as_mut(), jobs, &mut traffic, &mut on_cycle))
}

/// Records the positions of jobs. They follow from the ports: a pipeline of the same shape gets the same handshakes.
struct Watcher {
    recorder: Recorder,
    pipeline: Elastic<()>,
    number: u64,
}

impl Watcher {
    fn new(view: &ViewArguments, config: Config, datapath: &DatapathNetlist) -> Self {
        let pipeline = Elastic::new(&shape(config, datapath));
        Self { recorder: view.recorder("transaction", datapath), pipeline, number: 0 }
    }

    fn look(&mut self, seen: &Seen, opcode: impl Fn(usize) -> u64) {
        let number = self.number;
        self.number += 1;
        if seen.cycle.resets {
            self.recorder.reset();
            return self.pipeline.reset();
        }
        let output_valid = seen.shown.output.is_some();
        let entering = seen.entered.map(opcode);
        // Of an offer that is not accepted, only its presence is recorded.
        let offered = seen.cycle.offers.then(|| (entering.unwrap_or(0), seen.entered.unwrap_or(0) as u64));
        let accepted = entering.is_some();
        let output_taken = output_valid && seen.cycle.takes;
        let ports = PortActivity { cycle: number, offered, accepted, output_valid, output_taken };
        self.recorder.observe(&ports, self.pipeline.positions());
        self.pipeline.cycle(entering.map(|opcode| (opcode, ())), seen.cycle.takes);
    }

    fn recording(self, config: Config, datapath: &DatapathNetlist, run: &Run, tally: &Tally<'_>) -> Recording {
        let mut recording = recording("Recorded transactions".to_string(), config, datapath, run.cycles, &tally.jobs);
        recording.counts = vec![
            ("cycles".to_string(), run.cycles.to_string()),
            ("jobs".to_string(), run.jobs.to_string()),
            ("mismatches".to_string(), tally.mismatches().to_string()),
            ("jobs per cycle".to_string(), format!("{:.3}", run.jobs as f64 / run.cycles.max(1) as f64)),
        ];
        recording.window = self.recorder.window();
        recording
    }
}

/// The comparison of outcomes with the recorded ones.
struct Tally<'s> {
    stream: &'s [Transaction],
    kinds: Vec<OperationId>,
    format: Format,
    show: usize,
    /// By opcode.
    jobs: Vec<u64>,
    /// By opcode.
    mismatches: Vec<u64>,
    shown: Vec<String>,
}

impl<'s> Tally<'s> {
    fn new(model: &WordModel, stream: &'s [Transaction], show: usize) -> Self {
        let kinds = model.kinds();
        let none = vec![0; kinds.iter().map(|kind| kind.opcode() as usize + 1).max().unwrap_or(0)];
        Self { stream, kinds, format: model.format(), show, jobs: none.clone(), mismatches: none, shown: Vec::new() }
    }

    fn compare(&mut self, index: usize, outcome: &Words) {
        let transaction = &self.stream[index];
        let opcode = transaction.job.kind().opcode() as usize;
        self.jobs[opcode] += 1;
        if *outcome != transaction.expected {
            self.mismatches[opcode] += 1;
            if self.shown.len() < self.show {
                self.shown.push(field_by_field(transaction, outcome, self.format));
            }
        }
    }

    fn mismatches(&self) -> u64 {
        self.mismatches.iter().sum()
    }

    fn report(&self, run: &Run, begin: Instant, out: &mut dyn Write) -> std::io::Result<()> {
        let wide = self.kinds.iter().map(|kind| kind.name().len()).max().unwrap_or(0).max(10);
        writeln!(out, "{:<wide$} {:>9} {:>11}", "operation", "jobs", "mismatches")?;
        for kind in &self.kinds {
            let opcode = kind.opcode() as usize;
            let (jobs, mismatches) = (self.jobs[opcode], self.mismatches[opcode]);
            if jobs > 0 {
                writeln!(out, "{:<wide$} {jobs:>9} {mismatches:>11}", kind.name())?;
            }
        }
        writeln!(out, "{:<wide$} {:>9} {:>11}", "all", run.jobs, self.mismatches())?;
        if run.cycles > 0 {
            write!(out, "{} cycles, ", run.cycles)?;
        }
        writeln!(out, "{:.2} s", begin.elapsed().as_secs_f64())?;
        self.shown.iter().try_for_each(|text| writeln!(out, "\n{text}"))
    }

    /// The result of the run. A mismatch takes precedence over a stop by the user.
    fn verdict(&self, run: &Run, stopped: Result<(), CliError>) -> Result<(), CliError> {
        let mismatches = self.mismatches();
        if mismatches > 0 {
            let problem = format!("{mismatches} of {} outcomes differ from the recorded ones", run.jobs);
            return Err(CliError::Mismatch(problem));
        }
        stopped?;
        if run.spurious > 0 {
            return Err(CliError::Mismatch(format!("{} outcomes belong to no job", run.spurious)));
        }
        match self.stream.len() - run.jobs - run.dropped {
            0 => Ok(()),
            lost => Err(CliError::Mismatch(format!("{lost} jobs have no outcome"))),
        }
    }
}

/// A mismatch as text: each field of the outcome and the recorded one.
fn field_by_field(transaction: &Transaction, outcome: &Words, format: Format) -> String {
    let kind = transaction.job.kind();
    let mut text = format!("mismatch: {kind} job, seq {:06x}, cat {:x}", transaction.seq, transaction.category);
    text += &format!("\n    {:<24} {:<27} {:<27}", "field", "found", "recorded");
    if outcome.kind() != kind {
        return text + &format!("\n  * outcome of a {} job", outcome.kind());
    }
    for (found, recorded) in outcome.ports().iter().zip(transaction.expected.ports()) {
        let mark = if found.bits == recorded.bits { ' ' } else { '*' };
        let (name, found, recorded) = (&found.name, show(found, format), show(&recorded, format));
        text += &format!("\n  {mark} {name:<24} {found:<27} {recorded:<27}");
    }
    text
}

fn show(port: &PortValue, format: Format) -> String {
    match port.kind {
        PortKind::Number => {
            let (bits, digits, number) =
                (port.bits, format.ieee_width().div_ceil(4) as usize, format.to_f64(port.bits));
            // A binary32 number is identified by fewer digits.
            match number as f32 {
                single if f64::from(single) == number => format!("{bits:0digits$x} {single:e}"),
                _ => format!("{bits:0digits$x} {number:e}"),
            }
        }
        PortKind::Flags => format!("{:b}", port.bits),
        PortKind::Word => port.bits.to_string(),
    }
}
