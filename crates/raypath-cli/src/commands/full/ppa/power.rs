//! Workloads for `ppa --power`: 64 streams of jobs side by side, with the outputs that the models expect.

use super::jobs::{JobArguments, Jobs};
use crate::CliError;
use raypath_hdl::Module;
use raypath_model::{Shape, WordModel, Words};
use raypath_ppa::{Frame, STREAMS, Workload};
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::Datapath;
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Cycle, Stimulus};
use raypath_sim::traffic::Traffic;
use std::sync::Arc;

/// Cycles without a job for which idle power is measured.
const IDLE_CYCLES: usize = 64;

/// The workloads of a datapath: idle, and all jobs that it has operations for.
pub fn workloads(arguments: &JobArguments, config: Config, whole: &Datapath) -> Result<Vec<Workload>, CliError> {
    let netlist = whole.elaborate()?;
    let streams = Streams::new(&netlist, config, whole, arguments.stream);
    let all = arguments.jobs(&streams.model, config, STREAMS * arguments.stream)?;
    let Some(first) = all.first() else {
        return Err(CliError::unusable("--power: a datapath without operations, expected at least one"));
    };
    let mut workloads = vec![streams.idle(first)?];
    for jobs in &all {
        workloads.push(streams.busy(jobs)?);
    }
    Ok(workloads)
}

/// The jobs of the built-in picture as a workload.
pub fn picture(config: Config) -> Result<Workload, CliError> {
    let whole = Datapath::paper(config);
    let netlist = whole.elaborate()?;
    let arguments = JobArguments::built_in();
    let streams = Streams::new(&netlist, config, &whole, arguments.stream);
    let jobs = arguments.picture(&streams.model, config)?;
    streams.busy(&Jobs { name: "picture".to_string(), jobs })
}

/// The pipeline that streams of jobs go through.
struct Streams<'d> {
    top: &'d Arc<Module>,
    shape: Shape,
    encoding: PortEncoding,
    model: WordModel,
    /// The number of jobs in a stream.
    length: usize,
}

impl<'d> Streams<'d> {
    fn new(netlist: &'d DatapathNetlist, config: Config, whole: &Datapath, length: usize) -> Self {
        let (shape, encoding) = (shape(config, netlist), PortEncoding::of(config));
        Self { top: netlist.top(), shape, encoding, model: whole.model(), length }
    }

    /// Jobs back to back. Stream i begins at 1/64 of the jobs times i, and starts over at the end.
    fn busy(&self, jobs: &Jobs) -> Result<Workload, CliError> {
        let cycles = self.cycles(&jobs.jobs, self.length);
        // The pipeline is full from the first outcome on, up to the last job that enters.
        let warm_up = self.shape.latency + 1;
        let last = |cycles: &Vec<Cycle>| cycles.iter().rposition(|cycle| self.accepts(cycle)).unwrap_or(0);
        let end = cycles.iter().map(last).min().unwrap_or(0) + 1;
        let measured = cycles.iter().map(|cycles| &cycles[warm_up.min(end)..end]);
        let accepted = measured.flatten().filter(|cycle| self.accepts(cycle)).count();
        Ok(self.workload(jobs.name.clone(), accepted as u64, warm_up, end, cycles))
    }

    /// No job, after some of the jobs have left. The last one stays at the ports.
    fn idle(&self, jobs: &Jobs) -> Result<Workload, CliError> {
        let mut cycles = self.cycles(&jobs.jobs, self.shape.latency + 4);
        let longest = cycles.iter().map(Vec::len).max().unwrap_or(0);
        let (warm_up, end) = (longest + 4, longest + 4 + IDLE_CYCLES);
        let valid = self.position("input_valid_i")? + 1;
        for stream in &mut cycles {
            let Some(last) = stream.last().map(|cycle| cycle.inputs.clone()) else { continue };
            let idle = || {
                let mut inputs = last.clone();
                inputs[valid] = 0;
                Cycle { inputs, expected: None, job: None }
            };
            stream.resize_with(end, idle);
        }
        Ok(self.workload("idle".to_string(), 0, warm_up, end, cycles))
    }

    /// The cycles of each stream after the reset.
    fn cycles(&self, jobs: &[Words], length: usize) -> Vec<Vec<Cycle>> {
        let firsts = (0..STREAMS).map(|stream| stream * jobs.len() / STREAMS);
        firsts.map(|first| self.stream(jobs.iter().cycle().skip(first).take(length).cloned().collect())).collect()
    }

    /// The cycles of a stream of these jobs after the reset.
    fn stream(&self, jobs: Vec<Words>) -> Vec<Cycle> {
        let stimulus = Stimulus {
            shape: self.shape.clone(),
            encoding: self.encoding,
            jobs: &jobs,
            answers: Answers::Model(self.model.clone()),
            traffic: Traffic::always(),
            resets: Vec::new(),
        };
        stimulus.cycles(self.top).into_iter().skip_while(|cycle| cycle.inputs[0] == 0).collect()
    }

    fn accepts(&self, cycle: &Cycle) -> bool {
        let is_offered = self.position("input_valid_i").is_ok_and(|at| cycle.inputs[at + 1] == 1);
        is_offered && cycle.expected.as_ref().is_some_and(|expected| expected.input_ready)
    }

    fn position(&self, port: &str) -> Result<usize, CliError> {
        let found = self.top.inputs().iter().position(|input| input.name == port);
        found.ok_or_else(|| CliError::unusable(format!("--power: no port {port}, expected the ports of a datapath")))
    }

    fn workload(&self, name: String, jobs: u64, warm_up: usize, end: usize, cycles: Vec<Vec<Cycle>>) -> Workload {
        let frame = |number: usize| -> Frame {
            let port = |port: usize| std::array::from_fn(|stream| cycles[stream][number].inputs[port + 1]);
            (0..self.top.inputs().len()).map(port).collect()
        };
        let frames = (0..end).map(frame).collect();
        let top = self.top.clone();
        let check = move |stream: usize, number: usize, values: &[u64]| {
            cycles[stream][number].expected.as_ref()?.fault(&top, values)
        };
        Workload { name, jobs, warm_up, frames, check: Box::new(check) }
    }
}
