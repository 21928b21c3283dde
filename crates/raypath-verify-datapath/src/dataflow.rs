//! Proofs that the emitted pipeline computes its operations, for all values of inputs, states and registers.
//!
//! Yosys takes the floating-point units out of the emitted SystemVerilog. Z3 compares what is left, over the cycles of
//! a job, with the operation's function: for each opcode, every output and every state. Units may be any functions of
//! their operands, with the laws that the module `units` states. The job is alone in the pipeline; that other jobs do
//! not change its outcome follows from the proofs of `control`: the stages are FIFOs, and all data loads with the
//! opcode.

mod conversion;
mod design;
mod problem;
mod reference;
mod script;
mod subjects;
mod units;
mod unrolled;

use conversion::Conversion;
use design::Design;
use problem::Problem;
use raypath_float::Format;
use raypath_hdl::{Module, verilog, with_enables};
use raypath_rtl::{Config, DatapathNetlist, PRESETS};
use raypath_tools::{Cache, Key, SmtSolver, ToolError, Yosys, YosysKind, read, temporary_folder, write};
use raypath_verify::safety::{ModuleTexts, TextFault};
use raypath_verify::{Error, Level, Request, Verdict};
use raypath_work::pool;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use subjects::ProvedDatapath;

/// Proves the operations of the level's configurations, or of the one that the request names, with each of its added
/// operations by itself.
///
/// # Errors
/// A program is missing or fails; a configuration cannot be elaborated.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let subjects = match request.is_chosen {
        true => subjects::of(request.config, &request.added),
        false => subjects::chosen(request.level)?,
    };
    let faults = FAULTS.iter().map(|fault| (ProvedDatapath::default(), Some(*fault)));
    let work: Vec<Work> = faults.chain(subjects.into_iter().map(|subject| (subject, None))).collect();
    let (level, shard, mut is_stopped) = (request.level, request.shard, false);
    let shards = request.parts.phase(|| {
        let prover = DataflowProver::find(level > Level::Regression)?;
        let own: Vec<&Work> = shard.of(&work).collect();
        let results = pool::map(&own, pool::ALL_CORES, request.proceed, |work, stop| prover.prove(work, stop))?;
        is_stopped = results.iter().any(Option::is_none);
        let mut found = Found::default();
        for ((subject, fault), result) in own.into_iter().zip(results) {
            match (fault, result) {
                (_, None) => {}
                (None, Some(result)) => found.join(Found { configurations: 1, ..result }.named(&subject.to_string())),
                // No answer within the limit refutes nothing.
                (Some(fault), Some(result)) if !result.failures.iter().any(|why| why.contains(CAN_DIFFER)) => {
                    found.failures.push(format!("not refuted: {fault:?}"));
                }
                (Some(_), Some(_)) => found.refuted += 1,
            }
        }
        Ok::<Found, Error>(found)
    })?;
    let mut all = Found::default();
    shards.into_iter().for_each(|found| all.join(found));
    let Found { configurations, problems, confirmed, refuted, mut failures } = all;
    failures.truncate(FAILURES_SHOWN);
    let covered = format!(
        "{problems} operations and conversions of {configurations} configurations proved, {confirmed} of them also by \
         Bitwuzla, {refuted} faults refuted"
    );
    Ok(Verdict { covered, failures, is_stopped, ..Verdict::default() })
}

/// Whether Z3 proves that a changed netlist of a configuration still computes all operations, one job at a time. The
/// control must be the one that `control` proves, and the units those of the configuration.
///
/// # Errors
/// A program is missing or fails; the configuration cannot be elaborated.
pub fn still_computes(config: Config, top: &Arc<Module>, limit: Duration) -> Result<bool, Error> {
    let prover = DataflowProver { whole_limit: limit, limit_by_output: None, ..DataflowProver::find(false)? };
    let (subject, stop) = (ProvedDatapath::from(config), &AtomicBool::new(false));
    let datapath = subject.elaborate()?;
    let top = with_enables(top);
    let design = prover.design(&ModuleTexts::new(&top)?.with(top.name(), ""), &top, stop)?;
    for problem in subject.problems(&datapath, &design, true)? {
        if prover.failure(&problem, true, stop)?.is_some() {
            return Ok(false);
        }
    }
    Ok(true)
}

const FAILURES_SHOWN: usize = 8;

const CAN_DIFFER: &str = "can differ from the operation's";

/// The folder of answers.
const PROOFS: &str = "build/proofs";

/// The longest time for one question to Z3 about all outputs of an operation. After it, each output is a question of
/// its own: that takes longer for most operations, but not for those that sort many numbers.
const WHOLE_LIMIT: Duration = Duration::from_secs(120);

/// The longest time for the questions about each output of an operation.
const LIMIT: Duration = Duration::from_secs(1200);

/// The longest time for a question to the second solver, without whose answer a proof by Z3 still counts.
const SECOND_LIMIT: Duration = Duration::from_secs(20);

/// Deliberate faults in the default configuration, each of which must be refuted.
const FAULTS: &[TextFault] = &[
    // A unit bound to the wrong operand.
    fault("raypath_stage_8", ".b_i (data_i.num[2])", ".b_i (data_i.num[3])"),
    // A multiplexer that selects another operation's operand.
    fault("raypath_stage_8", "add_0_a = euclidean_sum_4_0;", "add_0_a = angular_dot_sum_2_1;"),
    // A value in another register than the one that it was placed in.
    fault("raypath_stage_10", "= data_i.num[1];", "= data_i.num[2];"),
    // A sum instead of a difference.
    fault("raypath_stage_2", "{~add_1_b[32], add_1_b[31:0]}", "add_1_b"),
    // A constant that is printed wrongly.
    fault("raypath_stage_10", "quadbox_sort_swap_1 ? 2'd1 : 2'd3", "quadbox_sort_swap_1 ? 2'd1 : 2'd2"),
    // A state that is not reset after the last beat.
    fault("raypath_stage_10", "euclidean_reset_accum ? 33'd0 : euclidean_accumulator", "euclidean_accumulator"),
    // A state that jobs of other operations change.
    fault("raypath_stage_10", "advance & (data_i.opcode == raypath_pkg::OpEuclidean)", "advance"),
    // Outputs that are exchanged.
    fault("raypath_output", "t_num        = data_i.num[1];", "t_num        = data_i.num[0];"),
    // A register that takes the wrong word.
    fault("raypath_skid", "arrives ? data_i : data_spare_q", "arrives ? data_spare_q : data_i"),
    // A job that leaves early.
    fault("raypath_stage_5", ".valid_i, .ready_i", ".valid_i (1'b1), .ready_i"),
];

const fn fault(module: &'static str, from: &'static str, to: &'static str) -> TextFault {
    TextFault { module, from, to }
}

/// A proof, or a fault to refute.
type Work = (ProvedDatapath, Option<TextFault>);

/// What was tried.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Found {
    configurations: usize,
    /// The proved operations, and units of one operand with a definition.
    problems: usize,
    /// How many of these the second solver proved too.
    confirmed: usize,
    refuted: usize,
    /// What is not proved, a line each.
    failures: Vec<String>,
}

impl Found {
    fn named(mut self, subject: &str) -> Self {
        self.failures.iter_mut().for_each(|failure| *failure = format!("{subject}: {failure}"));
        self
    }

    fn join(&mut self, other: Self) {
        self.configurations += other.configurations;
        self.problems += other.problems;
        self.confirmed += other.confirmed;
        self.refuted += other.refuted;
        self.failures.extend(other.failures);
    }
}

/// Yosys and Z3, and the answers of earlier runs.
struct DataflowProver {
    yosys: Yosys,
    z3: SmtSolver,
    /// A second opinion on the presets, from level full on; it takes several times as long.
    second: Option<SmtSolver>,
    answers: Cache,
    /// The longest time for one question about all outputs.
    whole_limit: Duration,
    /// The longest time for the questions about each output, which are asked after that.
    limit_by_output: Option<Duration>,
}

/// The commands that take the units out of a text and write the rest. The words of memories become registers.
const TO_DESIGN: &str = "proc; flatten; memory; opt_clean; async2sync; dffunmap; opt_clean\n\
                         setundef -undriven -anyseq\n\
                         write_json flat.json\n\
                         expose -evert t:raypath_fp_* t:raypath_narrow_*\n\
                         opt_clean\n\
                         write_btor design.btor\n";

impl DataflowProver {
    /// Finds Python's modules `pyosys` and `z3`, and `bitwuzla` for a second opinion.
    ///
    /// # Errors
    /// One is missing.
    fn find(has_second: bool) -> Result<Self, Error> {
        let second = if has_second { Some(SmtSolver::bitwuzla()?) } else { None };
        let (yosys, z3) = (Yosys::find(Some(YosysKind::Python))?, SmtSolver::z3()?);
        let answers = Cache::new(Path::new(PROOFS));
        Ok(Self { yosys, z3, second, answers, whole_limit: WHOLE_LIMIT, limit_by_output: Some(LIMIT) })
    }

    /// Proves all operations of a configuration; none if `stop` is set meanwhile. With a fault in the text, up to the
    /// first that is not proved.
    ///
    /// # Errors
    /// A program fails; the configuration cannot be elaborated.
    fn prove(&self, work: &Work, stop: &AtomicBool) -> Result<Option<Found>, Error> {
        match self.proved(work, stop) {
            Err(Error::Tool(ToolError::Stopped)) => Ok(None),
            other => other.map(|found| (!stop.load(Ordering::Relaxed)).then_some(found)),
        }
    }

    fn proved(&self, (subject, fault): &Work, stop: &AtomicBool) -> Result<Found, Error> {
        let datapath = subject.elaborate()?;
        // A clock gate is an enable here, because there is one clock.
        let top = with_enables(datapath.top());
        let mut texts = ModuleTexts::new(&top)?;
        if let Some(fault) = fault.filter(|fault| !texts.insert(*fault)) {
            return Err(
                ToolError::unexpected("raypath", format!("no '{}' in {}", fault.from, fault.module), "it").into()
            );
        }
        let design = self.design(&texts.with(top.name(), ""), &top, stop)?;
        let mut problems = subject.problems(&datapath, &design, false)?;
        let conversions: BTreeSet<Conversion> =
            problems.iter().flat_map(|problem| problem.conversions.clone()).collect();
        for conversion in conversions {
            problems.extend(self.conversion(&datapath, subject.config.semantics.format, conversion, stop)?);
        }
        let is_preset = fault.is_none() && PRESETS.iter().any(|preset| ProvedDatapath::from(preset.config) == *subject);
        let mut found = Found::default();
        for problem in &problems {
            match self.failure(problem, fault.is_some(), stop)? {
                None => found.problems += 1,
                Some(why) => found.failures.push(format!("{}: {why}", problem.name)),
            }
            // The second solver may give no answer in time, but no other answer.
            let second = self.second.as_ref().filter(|_| is_preset && found.failures.is_empty());
            let answers = second.map(|second| self.answers(second, &problem.questions(), SECOND_LIMIT, stop));
            match answers.transpose()?.flatten() {
                None => {}
                Some(answers) if answers == ["sat", "unsat"] => found.confirmed += 1,
                Some(answers) => found.failures.push(format!("{}: Bitwuzla answered {answers:?}", problem.name)),
            }
            // One operation is enough to refute a fault.
            if fault.is_some() && !found.failures.is_empty() {
                break;
            }
        }
        Ok(found)
    }

    /// The problem of a unit of one operand, if the datapath has it.
    fn conversion(
        &self,
        datapath: &DatapathNetlist,
        format: Format,
        conversion: Conversion,
        stop: &AtomicBool,
    ) -> Result<Option<Problem>, Error> {
        let name = conversion.module(format);
        let modules = verilog::modules(datapath.top())?;
        let Some(module) = modules.iter().find(|module| module.name() == name) else { return Ok(None) };
        let design = self.design(&verilog::text(module)?, module, stop)?;
        Problem::conversion(&design, format, conversion).map(Some)
    }

    /// Reads a module's text with Yosys.
    fn design(&self, text: &str, module: &Arc<Module>, stop: &AtomicBool) -> Result<Design, Error> {
        let top = module.name();
        let folder = temporary_folder()?;
        let folder = folder.path();
        write(&folder.join("design.sv"), text)?;
        let script = format!("read_verilog -sv design.sv\nhierarchy -check -top {top}\n{TO_DESIGN}");
        write(&folder.join("script"), &script)?;
        self.yosys.run(folder, "script", top, stop)?;
        let text = |name: &str| Ok::<_, Error>(String::from_utf8_lossy(&read(&folder.join(name))?).into_owned());
        Design::read(&text("design.btor")?, &text("flat.json")?, module)
    }

    /// Asks Z3 about a problem. Returns why it is not proved, if it is not; for a fault without the outputs that differ.
    fn failure(&self, problem: &Problem, is_fault: bool, stop: &AtomicBool) -> Result<Option<String>, Error> {
        let answers = self.answers(&self.z3, &problem.questions(), self.whole_limit, stop)?;
        match answers.as_deref() {
            Some([possible, differs]) if possible == "sat" && differs == "unsat" => return Ok(None),
            Some([possible, differs]) if possible == "sat" && differs == "sat" && is_fault => {
                return Ok(Some(format!("an output {CAN_DIFFER}")));
            }
            _ => {}
        }
        let Some(limit) = self.limit_by_output else { return Ok(Some(format!("Z3 answered {answers:?}"))) };
        let questions = problem.questions_by_output();
        let Some(answers) = self.answers(&self.z3, &questions, limit, stop)? else {
            return Ok(Some(format!("no answer within {} s", limit.as_secs())));
        };
        let is_complete = answers.len() == questions.len() && answers[0] == "sat";
        if !is_complete || answers.iter().any(|answer| !["sat", "unsat"].contains(&answer.as_str())) {
            return Ok(Some(format!("Z3 answered {answers:?}")));
        }
        let differ = problem.names().zip(&answers[1..]).filter(|(_, answer)| *answer == "sat").map(|(name, _)| name);
        let differ: Vec<&str> = differ.collect();
        Ok((!differ.is_empty()).then(|| format!("{} {CAN_DIFFER}", differ.join(", "))))
    }

    /// A solver's answers to these questions, those of an earlier run of the same version if there are; none if it has
    /// none within the limit.
    fn answers(
        &self,
        solver: &SmtSolver,
        questions: &[String],
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Option<Vec<String>>, Error> {
        let parts: Vec<&str> = std::iter::once(&solver.version).chain(questions).map(String::as_str).collect();
        let key = Key::new("smt", &parts);
        self.answers.kept(&key, Option::is_some, || {
            let answers = solver.run(temporary_folder()?.path(), questions, limit, stop)?;
            Ok(answers.map(|text| text.split_whitespace().map(str::to_string).collect()))
        })
    }
}
