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

use subjects::Subject;

use conversion::Conversion;
use design::Design;
use problem::Problem;
use raypath_float::Format;
use raypath_hdl::{Module, verilog, with_enables};
use raypath_rtl::{Config, Datapath};
use raypath_tools::{SmtSolver, ToolError, Yosys, YosysKind, pool, read, temporary_folder, write};
use raypath_verify::safety::{ModuleTexts, TextFault};
use raypath_verify::{Error, Level, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Proves the operations of the level's configurations, or of the one that the request names, with each of its added
/// operations by itself.
///
/// # Errors
/// A program is missing or fails; a configuration cannot be elaborated.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (level, shard) = (request.level, request.shard);
    // Bitwuzla takes several times as long as Z3.
    let with_bitwuzla = [level > Level::Regression, level > Level::Full];
    let [chosen, random] = match request.is_chosen {
        true => [subjects::of(request.config, &request.added), Vec::new()],
        false => [subjects::chosen(level), subjects::random(level, request.seed)],
    };
    let faults =
        FAULTS.iter().map(|fault| Work { subject: Subject::default(), fault: Some(*fault), is_repeated: false });
    let proofs = [chosen, random].into_iter().zip(with_bitwuzla).flat_map(|(subjects, is_repeated)| {
        subjects.into_iter().map(move |subject| Work { subject, fault: None, is_repeated })
    });
    let work: Vec<(u64, Work)> = (0..).zip(faults.chain(proofs)).filter(|(number, _)| shard.takes(*number)).collect();
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let prover = DataflowProver::find(level > Level::Regression)?;
        let results = pool::map(&work, pool::ALL_CORES, request.proceed, |(_, work), stop| prover.prove(work, stop))?;
        is_stopped = results.iter().any(Option::is_none);
        let results = work.iter().zip(results).filter_map(|((number, work), proved)| {
            let result = proved.map(|proved| Tried { subject: work.subject.to_string(), proved });
            result.map(|result| (*number, (result, work.fault.map(|fault| format!("{fault:?}")))))
        });
        Ok::<BTreeMap<u64, (Tried, Option<String>)>, Error>(results.collect())
    })?;
    let mut failures = Vec::new();
    let (mut proved, mut confirmed, mut configurations, mut refuted) = (0, 0, 0, 0);
    for (Tried { subject, proved: result }, fault) in shards.into_iter().flatten().map(|(_, result)| result) {
        match (fault, result.failures.is_empty()) {
            (Some(_), false) => refuted += 1,
            (Some(fault), true) => failures.push(format!("{subject}: not refuted: {fault}")),
            (None, _) => {
                configurations += 1;
                proved += result.problems;
                confirmed += result.confirmed;
                failures.extend(result.failures.into_iter().map(|failure| format!("{subject}: {failure}")));
            }
        }
    }
    failures.truncate(FAILURES_SHOWN);
    let mut covered = format!("{proved} operations and conversions of {configurations} configurations proved, ");
    if level > Level::Regression {
        covered += &format!("{confirmed} of them also by Bitwuzla, ");
    }
    covered += &format!("{refuted} faults refuted");
    Ok(Verdict { covered, failures, is_stopped, ..Verdict::default() })
}

/// Whether Z3 proves that a changed netlist of a configuration still computes all operations, one job at a time. The
/// control must be the one that `control` proves, and the units those of the configuration.
///
/// # Errors
/// A program is missing or fails; the configuration cannot be elaborated.
pub fn still_computes(config: Config, top: &Arc<Module>, limit: Duration) -> Result<bool, Error> {
    let prover = DataflowProver { whole_limit: limit, limit_by_output: None, ..DataflowProver::find(false)? };
    let (subject, stop) = (Subject::from(config), &AtomicBool::new(false));
    let datapath = subject.elaborate()?;
    let top = with_enables(top);
    let design = prover.design(&ModuleTexts::new(&top)?.with(top.name(), ""), top.name(), stop)?;
    for problem in subject.problems(&datapath, &design, true)? {
        if !matches!(prover.answer(&problem, false, stop)?, Answer::Proved { .. }) {
            return Ok(false);
        }
    }
    Ok(true)
}

const FAILURES_SHOWN: usize = 8;

/// The longest time for one question to Z3 about all outputs of an operation. After it, each output is a question of
/// its own: that takes longer for most operations, but not for those that sort many numbers.
const WHOLE_LIMIT: Duration = Duration::from_secs(120);

/// The longest time for the questions about each output of an operation, and for the question what differs.
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
struct Work {
    subject: Subject,
    fault: Option<TextFault>,
    /// Bitwuzla repeats the proofs.
    is_repeated: bool,
}

/// What was tried of a configuration.
#[derive(Serialize, Deserialize)]
struct Tried {
    subject: String,
    proved: Proved,
}

/// The result of a configuration: how many problems it has, and what was not proved.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Proved {
    /// The proved operations, and units of one operand with a definition.
    problems: usize,
    /// How many of these the second solver proved too.
    confirmed: usize,
    /// What is not proved, a line each.
    failures: Vec<String>,
}

/// Yosys and Z3, and Bitwuzla as a second opinion.
struct DataflowProver {
    yosys: Yosys,
    z3: SmtSolver,
    second: Option<SmtSolver>,
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
        Ok(Self { yosys, z3, second, whole_limit: WHOLE_LIMIT, limit_by_output: Some(LIMIT) })
    }

    /// Proves all operations of a configuration; none if `stop` is set meanwhile. With a fault in the text, up to the
    /// first that is not proved.
    ///
    /// # Errors
    /// A program fails; the configuration cannot be elaborated.
    fn prove(&self, work: &Work, stop: &AtomicBool) -> Result<Option<Proved>, Error> {
        match self.proved(work, stop) {
            Err(Error::Tool(ToolError::Stopped)) => Ok(None),
            other => other.map(|proved| (!stop.load(Ordering::Relaxed)).then_some(proved)),
        }
    }

    fn proved(&self, work: &Work, stop: &AtomicBool) -> Result<Proved, Error> {
        let Work { subject, fault, is_repeated } = work;
        let datapath = subject.elaborate()?;
        // A clock gate is an enable here, because there is one clock.
        let top = with_enables(datapath.top());
        let mut texts = ModuleTexts::new(&top)?;
        if let Some(fault) = fault.filter(|fault| !texts.insert(*fault)) {
            return Err(
                ToolError::unexpected("raypath", format!("no '{}' in {}", fault.from, fault.module), "it").into()
            );
        }
        let design = self.design(&texts.with(top.name(), ""), top.name(), stop)?;
        let mut problems = subject.problems(&datapath, &design, false)?;
        let conversions: BTreeSet<Conversion> =
            problems.iter().flat_map(|problem| problem.conversions.clone()).collect();
        for conversion in conversions {
            problems.extend(self.conversion(&datapath, subject.config.semantics.format, conversion, stop)?);
        }
        let mut proved = Proved::default();
        for problem in &problems {
            match self.answer(problem, *is_repeated, stop)? {
                Answer::Proved { is_confirmed } => {
                    proved.problems += 1;
                    proved.confirmed += usize::from(is_confirmed);
                }
                Answer::Failed(why) => proved.failures.push(why),
            }
            // One operation is enough to refute a fault.
            if fault.is_some() && !proved.failures.is_empty() {
                break;
            }
        }
        Ok(proved)
    }

    /// The problem of a unit of one operand, if the datapath has it.
    fn conversion(
        &self,
        datapath: &Datapath,
        format: Format,
        conversion: Conversion,
        stop: &AtomicBool,
    ) -> Result<Option<Problem>, Error> {
        let name = conversion.module(format);
        let modules = verilog::modules(datapath.top())?;
        let Some(module) = modules.iter().find(|module| module.name() == name) else { return Ok(None) };
        let design = self.design(&verilog::text(module)?, &name, stop)?;
        Problem::conversion(&design, format, conversion).map(Some)
    }

    /// Reads a text with Yosys.
    fn design(&self, text: &str, top: &str, stop: &AtomicBool) -> Result<Design, Error> {
        let folder = temporary_folder()?;
        let folder = folder.path();
        write(&folder.join("design.sv"), text)?;
        let script = format!("read_verilog -sv design.sv\nhierarchy -check -top {top}\n{TO_DESIGN}");
        write(&folder.join("script"), &script)?;
        self.yosys.run(folder, "script", top, stop)?;
        let text = |name: &str| Ok::<_, Error>(String::from_utf8_lossy(&read(&folder.join(name))?).into_owned());
        Design::read(&text("design.btor")?, &text("flat.json")?, top)
    }

    /// Asks Z3, and with `is_repeated` the second solver. That one may give no answer in time, but no other answer.
    fn answer(&self, problem: &Problem, is_repeated: bool, stop: &AtomicBool) -> Result<Answer, Error> {
        let folder = temporary_folder()?;
        let questions = problem.questions();
        let name = &problem.name;
        let failed = |why: String| Ok(Answer::Failed(format!("{name}: {why}")));
        match (self.z3.run(folder.path(), &questions, self.whole_limit, stop)?, self.limit_by_output) {
            (Some(answers), _) => match answers.split_whitespace().collect::<Vec<_>>()[..] {
                ["sat", "unsat"] => {}
                ["sat", "sat"] => return failed(self.differences(problem, folder.path(), stop)?),
                _ => return failed(format!("Z3 answered '{}'", answers.trim())),
            },
            (None, None) => return failed(format!("no answer within {} s", self.whole_limit.as_secs())),
            (None, Some(limit)) => {
                if let Some(why) = self.not_proved_by_output(problem, folder.path(), limit, stop)? {
                    return failed(why);
                }
            }
        }
        let Some(second) = self.second.as_ref().filter(|_| is_repeated) else {
            return Ok(Answer::Proved { is_confirmed: false });
        };
        match second.run(folder.path(), &questions, SECOND_LIMIT, stop)? {
            None => Ok(Answer::Proved { is_confirmed: false }),
            Some(answers) if answers.split_whitespace().eq(["sat", "unsat"]) => {
                Ok(Answer::Proved { is_confirmed: true })
            }
            Some(answers) => failed(format!("Z3 proves it, but {} answered '{}'", second.version, answers.trim())),
        }
    }

    /// Asks Z3 about each output by itself. Returns what is not proved, in words.
    fn not_proved_by_output(
        &self,
        problem: &Problem,
        folder: &Path,
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Option<String>, Error> {
        let questions = problem.questions_by_output();
        let Some(answers) = self.z3.run(folder, &questions, limit, stop)? else {
            return Ok(Some(format!("no answer within {} s", limit.as_secs())));
        };
        let is_answer = |answer: &&str| ["sat", "unsat"].contains(answer);
        match answers.split_whitespace().collect::<Vec<_>>()[..] {
            ["sat", ref outputs @ ..] if outputs.len() + 1 == questions.len() && outputs.iter().all(is_answer) => {
                let differ: Vec<&str> = problem
                    .names()
                    .zip(outputs)
                    .filter(|(_, answer)| **answer == "sat")
                    .map(|(name, _)| name)
                    .collect();
                Ok((!differ.is_empty()).then(|| can_differ(&differ)))
            }
            _ => Ok(Some(format!("Z3 answered '{}'", answers.trim()))),
        }
    }

    /// What can differ, in words.
    fn differences(&self, problem: &Problem, folder: &Path, stop: &AtomicBool) -> Result<String, Error> {
        let answer = self.z3.run(folder, &[problem.differences()], LIMIT, stop)?.unwrap_or_default();
        let differs = |number: usize| answer.contains(&format!("(d{number} true)"));
        let names = (0..).zip(problem.names());
        Ok(can_differ(&names.filter(|(number, _)| differs(*number)).map(|(_, name)| name).collect::<Vec<_>>()))
    }
}

fn can_differ(names: &[&str]) -> String {
    format!("{} can differ from the operation's", names.join(", "))
}

/// The answer of the solvers to a problem.
enum Answer {
    /// Proved; also by the second solver, if there is one and it came to an end.
    Proved { is_confirmed: bool },
    /// Not proved, and why.
    Failed(String),
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::Lanes;

    /// Otherwise an operation for which one question is too hard would have no proof.
    #[test]
    fn outputs_are_compared_one_by_one_where_one_question_is_too_hard() {
        let prover =
            DataflowProver { whole_limit: Duration::ZERO, ..DataflowProver::find(false).expect("Yosys and Z3") };
        let tried = |fault: Option<TextFault>| {
            let subject = Subject::from(Config::DEFAULT.lanes(Lanes::None));
            let work = Work { subject, fault, is_repeated: false };
            prover.proved(&work, &AtomicBool::new(false)).expect("a result")
        };
        let right = tried(None);
        assert_eq!((right.problems, right.failures), (2, vec![]));
        // A job that leaves early.
        let failures = tried(Some(FAULTS[9])).failures;
        assert!(failures.iter().any(|why| why.contains("output_valid_o after 11 cycles")), "{failures:?}");
    }
}
