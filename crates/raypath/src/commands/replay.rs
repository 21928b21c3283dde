//! `raypath replay`: recorded transactions through an engine, compared with what was recorded.

use crate::commands::Failure;
use crate::commands::progress::Progress;
use crate::commands::stream::StreamArguments;
use clap::{Args, ValueEnum};
use raypath::engine::{CycleEngine, Engine, NetlistEngine, Run, drive, evaluate};
use raypath::ops::{JobKind, Outcome, PortKind, PortValue};
use raypath::rtl::Config;
use raypath::transactions::Transaction;
use std::io::Write;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    stream: StreamArguments,
    /// What runs the jobs: the functional model, the cycle-exact model, or the netlist
    #[arg(long, value_enum, default_value_t = EngineKind::Model)]
    engine: EngineKind,
    /// How many mismatches to show field by field
    #[arg(long, default_value_t = 3)]
    show: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineKind {
    Model,
    Cycle,
    Netlist,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), Failure> {
    let stream = arguments.stream.read()?;
    let begin = Instant::now();
    let mut progress = Progress::new("jobs", stream.len());
    let mut tally = Tally::new(&stream, arguments.show);
    let run = carry(arguments, &stream, |index, outcome| {
        tally.compare(index, outcome);
        progress.at(index + 1)
    })?;
    let stopped = progress.finish(run.jobs);
    tally.report(&run, begin, out)?;
    tally.verdict(&run, stopped)
}

/// Runs the stream through the engine that was asked for, until `on_outcome` says stop.
fn carry(
    arguments: &Arguments,
    stream: &[Transaction],
    on_outcome: impl FnMut(usize, Outcome) -> bool,
) -> Result<Run, Failure> {
    let rules = arguments.stream.rules;
    let jobs = stream.iter().map(|transaction| &transaction.job);
    let mut engine: Box<dyn Engine> = match arguments.engine {
        EngineKind::Model => return Ok(evaluate(rules, jobs, on_outcome)),
        EngineKind::Cycle => Box::new(CycleEngine::new(rules)),
        EngineKind::Netlist => Box::new(NetlistEngine::new(Config { rules, ..Config::default() }, |_| false)?),
    };
    Ok(drive(engine.as_mut(), jobs, &mut arguments.stream.traffic(), on_outcome))
}

/// Outcomes compared with the recorded ones.
struct Tally<'s> {
    stream: &'s [Transaction],
    show: usize,
    jobs: [usize; JobKind::ALL.len()],
    mismatches: [usize; JobKind::ALL.len()],
    shown: Vec<String>,
}

impl<'s> Tally<'s> {
    fn new(stream: &'s [Transaction], show: usize) -> Self {
        Self { stream, show, jobs: Default::default(), mismatches: Default::default(), shown: Vec::new() }
    }

    fn compare(&mut self, index: usize, outcome: Outcome) {
        let transaction = &self.stream[index];
        let kind = transaction.job.kind() as usize;
        self.jobs[kind] += 1;
        if outcome != transaction.expected {
            self.mismatches[kind] += 1;
            if self.shown.len() < self.show {
                self.shown.push(field_by_field(transaction, outcome));
            }
        }
    }

    fn report(&self, run: &Run, begin: Instant, out: &mut dyn Write) -> std::io::Result<()> {
        writeln!(out, "{:<10} {:>9} {:>11}", "operation", "jobs", "mismatches")?;
        for kind in JobKind::ALL {
            let (jobs, mismatches) = (self.jobs[kind as usize], self.mismatches[kind as usize]);
            if jobs > 0 {
                writeln!(out, "{:<10} {jobs:>9} {mismatches:>11}", kind.name())?;
            }
        }
        writeln!(out, "{:<10} {:>9} {:>11}", "all", run.jobs, self.mismatches.iter().sum::<usize>())?;
        if run.cycles > 0 {
            write!(out, "{} cycles, ", run.cycles)?;
        }
        writeln!(out, "{:.2} s", begin.elapsed().as_secs_f64())?;
        self.shown.iter().try_for_each(|text| writeln!(out, "\n{text}"))
    }

    /// What was found weighs more than that the user stopped the search.
    fn verdict(&self, run: &Run, stopped: Result<(), Failure>) -> Result<(), Failure> {
        let mismatches: usize = self.mismatches.iter().sum();
        if mismatches > 0 {
            let problem = format!("{mismatches} of {} outcomes differ from the recorded ones", run.jobs);
            return Err(Failure::Mismatch(problem));
        }
        stopped?;
        match self.stream.len() - run.jobs {
            0 => Ok(()),
            lost => Err(Failure::Mismatch(format!("{lost} jobs never came out"))),
        }
    }
}

/// A mismatch, with every field that was answered and recorded.
fn field_by_field(transaction: &Transaction, outcome: Outcome) -> String {
    let kind = transaction.job.kind();
    let mut text = format!("mismatch: {kind} job, seq {:06x}, cat {:x}", transaction.seq, transaction.category);
    text += &format!("\n    {:<24} {:<27} {:<27}", "field", "answered", "recorded");
    if outcome.kind() != kind {
        return text + &format!("\n  * answered as {} job", outcome.kind());
    }
    for (answered, recorded) in outcome.ports().iter().zip(transaction.expected.ports()) {
        let mark = if answered.bits == recorded.bits { ' ' } else { '*' };
        text += &format!("\n  {mark} {:<24} {:<27} {:<27}", answered.name, show(answered), show(&recorded));
    }
    text
}

fn show(port: &PortValue) -> String {
    match port.kind {
        PortKind::Number => format!("{:08x} {:e}", port.bits, f32::from_bits(port.bits as u32)),
        PortKind::Flags => format!("{:b}", port.bits),
        PortKind::Word => port.bits.to_string(),
    }
}
