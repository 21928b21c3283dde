//! The question whether a fault changes an outcome, for Z3: in its theory of floating-point numbers, with sums and
//! products as functions of which a few laws are known.

use super::evaluate::behind;
use super::graph::{Graph, Id, Kind, Node, Op};
use raypath_ops::{Direction, Narrowing, Relation, Test};
use raypath_tools::{SmtSolver, ToolError, temporary_folder};
use raypath_verify::Error;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Z3.
pub struct Solver {
    z3: SmtSolver,
}

/// Z3's limit for a question, in its units of work, so that its answers do not depend on the machine: about a second,
/// and three times what the longest known proof needs.
const WORK: u32 = 2_000_000;

/// The bits of a binary32 significand.
const SIGNIFICAND: u32 = 24;

/// The longest time for all questions of one run of Z3.
const LIMIT: Duration = Duration::from_secs(600);

impl Solver {
    /// Finds Python's module `z3`.
    ///
    /// # Errors
    /// It is missing.
    pub fn find() -> Result<Self, Error> {
        Ok(Self { z3: SmtSolver::z3()? })
    }

    /// For each question, whether its answer is `unsat`: no job can show the fault. Anything else is no proof. None if
    /// `stop` is set meanwhile.
    ///
    /// # Errors
    /// Z3 refuses a question.
    pub fn prove(&self, questions: Vec<String>, stop: &AtomicBool) -> Result<Option<Vec<bool>>, Error> {
        let folder = temporary_folder()?;
        let answers = match self.z3.run(folder.path(), &questions, LIMIT, stop) {
            Ok(answers) => answers.unwrap_or_default(),
            Err(ToolError::Stopped) => return Ok(None),
            Err(other) => return Err(other.into()),
        };
        let mut answers = answers.lines().map(|answer| answer.trim() == "unsat");
        Ok(Some(questions.iter().map(|_| answers.next().unwrap_or(false)).collect()))
    }
}

/// Functions of numbers, and their laws. A product has the sign of its operands' signs; the functions are of
/// magnitudes.
const PREAMBLE: &str = "(define-sort Number () (_ FloatingPoint 8 24))
(declare-fun sum_of (Number Number) Number)
(declare-fun product_of (Number Number) Number)
(define-fun product ((a Number) (b Number)) Number
  (let ((m (product_of (fp.abs a) (fp.abs b)))) (ite (xor (fp.isNegative a) (fp.isNegative b)) (fp.neg m) m)))
(define-fun is_at_least_zero ((a Number)) Bool (or (fp.isZero a) (fp.isPositive a)))
(define-fun is_at_most_zero ((a Number)) Bool (or (fp.isZero a) (fp.isNegative a)))
(define-fun sum_laws ((a Number) (b Number)) Bool (let ((r (sum_of a b)) (n (sum_of (fp.neg a) (fp.neg b)))) (and
  (= r (sum_of b a))
  (= (fp.isNaN r) (or (fp.isNaN a) (fp.isNaN b) (and (fp.isInfinite a) (= b (fp.neg a)))))
  (=> (and (is_at_least_zero a) (is_at_least_zero b)) (and (fp.geq r a) (fp.geq r b)))
  (=> (and (is_at_most_zero a) (is_at_most_zero b)) (and (fp.leq r a) (fp.leq r b)))
  (=> (fp.isZero r) (fp.eq a (fp.neg b)))
  (=> (and (fp.eq a (fp.neg b)) (not (fp.isInfinite a))) (fp.isZero r))
  (=> (fp.isZero r) (= (fp.isNegative r) (and (fp.isNegative a) (fp.isNegative b))))
  (=> (and (fp.isZero b) (not (fp.isZero a))) (= r a))
  (=> (and (fp.isZero a) (not (fp.isZero b))) (= r b))
  (= (fp.isZero n) (fp.isZero r))
  (=> (not (fp.isZero r)) (= n (fp.neg r))))))
(define-fun narrow_laws ((a Number) (r Number)) Bool (and
  (= (fp.isNaN r) (fp.isNaN a))
  (= (fp.isNegative r) (fp.isNegative a))
  (=> (fp.isZero a) (fp.isZero r))
  (=> (fp.isInfinite a) (= r a))))
(define-fun product_laws ((a Number) (b Number)) Bool (let ((x (fp.abs a)) (y (fp.abs b)))
  (let ((m (product_of x y))) (and
  (= m (product_of y x))
  (= (fp.isNaN m) (or (fp.isNaN a) (fp.isNaN b) (and (fp.isInfinite a) (fp.isZero b))
    (and (fp.isZero a) (fp.isInfinite b))))
  (=> (not (fp.isNaN m)) (fp.isPositive m))
  (=> (and (not (fp.isNaN m)) (or (fp.isZero a) (fp.isZero b))) (fp.isZero m))
  (=> (and (not (fp.isNaN m)) (or (fp.isInfinite a) (fp.isInfinite b))) (fp.isInfinite m))))))
";

/// Where two dataflows are compared, and what is known there. A proof with less is a proof, and is found sooner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// At the last value that all effects of the fault pass, else at the outputs. Numbers that the fault does not
    /// affect may be any but NaN, where a lemma says so.
    Near,
    /// At that value. Only sums and products that the fault does not affect may be any.
    Cut,
    /// At the outputs and next states, with the laws of all sums, products and roundings.
    Laws,
}

impl Scope {
    /// In the order in which they are tried.
    pub const ALL: [Self; 3] = [Self::Near, Self::Cut, Self::Laws];
}

/// A dataflow, and what is known of it.
#[derive(Clone, Copy)]
pub struct Known<'g> {
    pub graph: &'g Graph,
    /// Numbers that are never NaN, each proved from those before.
    pub lemmas: &'g BTreeSet<Id>,
}

impl Solver {
    /// The greatest set of numbers among these that are never NaN, each because those before are not.
    ///
    /// # Errors
    /// Z3 refuses a question.
    pub fn lemmas(
        &self,
        graph: &Graph,
        mut candidates: BTreeSet<Id>,
        stop: &AtomicBool,
    ) -> Result<BTreeSet<Id>, Error> {
        loop {
            let questions: Vec<String> = candidates.iter().map(|&id| lemma(graph, &candidates, id)).collect();
            // One script, because each question is small.
            let all: String = questions.iter().map(|text| format!("(push)\n{text}(pop)\n")).collect();
            let all = format!("(set-option :rlimit {WORK})\n{PREAMBLE}{all}");
            let folder = temporary_folder()?;
            let answers = match self.z3.run(folder.path(), &[all], LIMIT, stop) {
                Ok(answers) => answers.unwrap_or_default(),
                Err(ToolError::Stopped) => return Ok(BTreeSet::new()),
                Err(other) => return Err(other.into()),
            };
            let mut answers = answers.lines().map(|answer| answer.trim() == "unsat");
            let proved: BTreeSet<Id> = candidates.iter().copied().filter(|_| answers.next().unwrap_or(false)).collect();
            if proved == candidates {
                return Ok(proved);
            }
            candidates = proved;
        }
    }
}

/// The question whether a number can be NaN if those before that have a lemma are not.
fn lemma(graph: &Graph, lemmas: &BTreeSet<Id>, id: Id) -> String {
    let mut script = Script { text: String::new(), declared: BTreeSet::new(), graph };
    let mut needed = vec![false; id + 1];
    needed[id] = true;
    let is_free = |other: Id| other != id && is_free_number(graph, other);
    for other in (0..=id).rev().filter(|&other| !is_free(other)) {
        if needed[other] {
            graph.nodes[other].operands.iter().for_each(|&operand| needed[operand] = true);
        }
    }
    for other in (0..=id).filter(|&other| needed[other]) {
        script.value(other, is_free(other), lemmas);
    }
    let _ = writeln!(script.text, "(assert (fp.isNaN n{id}))\n(check-sat)");
    script.text
}

/// A number that is no constant.
fn is_free_number(graph: &Graph, id: Id) -> bool {
    let op = graph.nodes[id].op;
    op.kind() == Kind::Number && !op.is_constant() && !matches!(op, Op::Input(..) | Op::State(_))
}

/// The script: `unsat` if the fault changes no output and no next state. None if the effects of the fault pass no
/// single value.
pub fn question(known: Known<'_>, faulty: &Graph, scope: Scope) -> Option<String> {
    let Known { graph, lemmas } = known;
    let is_behind = behind(graph, faulty);
    // A state is what it was before the job.
    let is_other = |id: Id| is_behind[id] && !matches!(faulty.nodes[id].op, Op::State(_));
    let cut = cut(graph, faulty, &is_behind).map(|id| vec![(id, id)]);
    let outputs = ends(graph).into_iter().zip(ends(faulty)).collect();
    let pairs: Vec<(Id, Id)> = match scope {
        Scope::Near => cut.unwrap_or(outputs),
        Scope::Cut => cut?,
        Scope::Laws => outputs,
    };
    let is_free = |id: Id| {
        let op = graph.nodes[id].op;
        let computes = matches!(op, Op::Add | Op::Sum | Op::Subtract | Op::Multiply);
        !is_behind[id]
            && match scope {
                Scope::Near => is_free_number(graph, id),
                Scope::Cut => computes,
                Scope::Laws => false,
            }
    };
    // The values that are needed without and with the fault.
    let (mut right, mut wrong) = (vec![false; graph.nodes.len()], vec![false; graph.nodes.len()]);
    for &(a, b) in &pairs {
        right[a] = true;
        *(if is_other(b) { &mut wrong } else { &mut right }).get_mut(b)? = true;
    }
    for id in (0..graph.nodes.len()).rev() {
        if wrong[id] {
            for &operand in &faulty.nodes[id].operands {
                *(if is_other(operand) { &mut wrong } else { &mut right }).get_mut(operand)? = true;
            }
        }
        if right[id] && !is_free(id) {
            graph.nodes[id].operands.iter().for_each(|&operand| right[operand] = true);
        }
    }
    let text = format!("(set-option :rlimit {WORK})\n(set-logic ALL)\n{PREAMBLE}");
    let mut script = Script { text, declared: BTreeSet::new(), graph };
    for (id, node) in graph.nodes.iter().enumerate() {
        if right[id] || matches!(node.op, Op::Input(..) | Op::State(_)) {
            script.value(id, is_free(id) && right[id], lemmas);
        }
    }
    for (id, node) in faulty.nodes.iter().enumerate().filter(|(id, _)| wrong[*id]) {
        script.node(id, node, 'f', &|operand| if is_other(operand) { 'f' } else { 'n' });
    }
    let mut differs = String::new();
    for (a, b) in pairs.into_iter().filter(|(a, b)| a != b || is_other(*b)) {
        let _ = write!(differs, " (distinct n{a} {}{b})", if is_other(b) { 'f' } else { 'n' });
    }
    let _ = writeln!(script.text, "(assert (or false{differs}))\n(check-sat)");
    Some(script.text)
}

/// The values at the outputs, and the next ones of the state.
fn ends(graph: &Graph) -> Vec<Id> {
    let states = graph.states.iter().map(|state| state.1);
    graph.outputs.iter().map(|leaf| leaf.node).chain(states).collect()
}

/// The last value that all effects of a fault pass, if it is not the changed one. No order, because it has no value.
fn cut(graph: &Graph, faulty: &Graph, is_behind: &[bool]) -> Option<Id> {
    if ends(graph) != ends(faulty) {
        return None;
    }
    // The last reader of each value.
    let mut last: Vec<Id> = (0..faulty.nodes.len()).collect();
    for (id, node) in faulty.nodes.iter().enumerate().filter(|(id, _)| is_behind[*id]) {
        node.operands.iter().for_each(|&operand| last[operand] = id);
    }
    ends(faulty).into_iter().for_each(|id| last[id] = usize::MAX);
    let first = is_behind.iter().position(|is_behind| *is_behind)?;
    let mut found = None;
    for id in (0..faulty.nodes.len()).filter(|&id| is_behind[id]) {
        let passes = |before: &Id| is_behind[*before] && last[*before] > id;
        if (first..id).all(|before| !passes(&before)) && faulty.nodes[id].op.kind() != Kind::Order && id != first {
            found = Some(id);
        }
    }
    let is_changed = |id: Id| faulty.nodes[id] != graph.nodes[id];
    found.filter(|&id| !(id + 1..faulty.nodes.len()).any(is_changed))
}

struct Script<'g> {
    /// The dataflow without the fault.
    graph: &'g Graph,
    text: String,
    declared: BTreeSet<String>,
}

impl Script<'_> {
    /// The value of a node without the fault, or any number; not NaN where a lemma says so.
    fn value(&mut self, id: Id, is_free: bool, lemmas: &BTreeSet<Id>) {
        if !is_free {
            return self.node(id, &self.graph.nodes[id].clone(), 'n', &|_| 'n');
        }
        let _ = writeln!(self.text, "(declare-fun n{id} () Number)");
        if lemmas.contains(&id) {
            let _ = writeln!(self.text, "(assert (not (fp.isNaN n{id})))");
        }
    }

    /// Defines the value of a node. Names of operands begin with what `of` says.
    fn node(&mut self, id: Id, node: &Node, own: char, of: &dyn Fn(Id) -> char) {
        let kind = node.op.kind();
        let name = |operand: Id| format!("{}{operand}", of(operand));
        let operand = |place: usize| name(node.operands[place]);
        let both = |function: &str| format!("({function} {} {})", operand(0), operand(1));
        let expression = match node.op {
            Op::Input(..) | Op::State(_) if own == 'n' => None,
            // An input that is exchanged with another is the value at the other's port.
            Op::Input(..) | Op::State(_) => {
                let port = self.graph.nodes.iter().position(|other| other.op == node.op);
                Some(format!("n{}", port.unwrap_or(id)))
            }
            Op::Constant(value) => Some(bits(value)),
            Op::OnePlusUlps(ulps) => Some(bits(f32::from_bits(1.0_f32.to_bits() + ulps))),
            Op::Add => Some(self.sum(&operand(0), &operand(1))),
            Op::Subtract => Some(self.sum(&operand(0), &format!("(fp.neg {})", operand(1)))),
            Op::Multiply => {
                let _ = writeln!(self.text, "(assert {})", both("product_laws"));
                Some(both("product"))
            }
            Op::Sum => {
                let function = format!("sum_{}", node.operands.len());
                let numbers = " Number".repeat(node.operands.len());
                self.declare(&function, &format!("(declare-fun {function} ({numbers}) Number)"));
                let terms: Vec<String> = node.operands.iter().map(|&id| name(id)).collect();
                let sum = format!("({function} {})", terms.join(" "));
                self.sum_once(&sum, &terms);
                Some(sum)
            }
            Op::Negate => Some(format!("(fp.neg {})", operand(0))),
            Op::Narrow(to) => {
                let function = self.narrow(to);
                let (a, narrow) = (operand(0), format!("({function} {})", operand(0)));
                let relation = if to.direction == Direction::TowardZero { "fp.leq" } else { "fp.geq" };
                let _ = writeln!(self.text, "(assert (narrow_laws {a} {narrow}))");
                // A number below twice the least normal one becomes zero, whatever the direction.
                let _ = writeln!(
                    self.text,
                    "(assert (or (fp.isNaN {a}) (fp.isZero {narrow}) ({relation} (fp.abs {narrow}) (fp.abs {a}))))"
                );
                Some(narrow)
            }
            // Relations read the operands.
            Op::Compare => {
                let _ = writeln!(self.text, "(define-fun {own}{id}a () Number {})", operand(0));
                let _ = writeln!(self.text, "(define-fun {own}{id}b () Number {})", operand(1));
                for [other, rounded] in [[0, 1], [1, 0]] {
                    let id = node.operands[rounded];
                    // A value behind the fault may be another rounding than the one that the dataflow has there.
                    if of(id) == 'n' {
                        self.order_of_rounded(&operand(other), id);
                    }
                }
                return;
            }
            Op::Relation(relation) => {
                let function = match relation {
                    Relation::Less => "fp.lt",
                    Relation::LessOrEqual => "fp.leq",
                    Relation::Equal => "fp.eq",
                    Relation::GreaterOrEqual => "fp.geq",
                    Relation::Greater => "fp.gt",
                };
                Some(format!("({function} {0}a {0}b)", operand(0)))
            }
            Op::NumberOf(_) => Some(format!("((_ to_fp_unsigned 8 24) RNE {})", operand(0))),
            Op::Test(test) => Some(match test {
                // The sign of a NaN may be any.
                Test::SignBit => {
                    let _ = writeln!(self.text, "(declare-fun {own}{id}s () Bool)");
                    format!("(ite (fp.isNaN {0}) {own}{id}s (fp.isNegative {0}))", operand(0))
                }
                Test::Zero => format!("(fp.isZero {})", operand(0)),
                Test::Nan => format!("(fp.isNaN {})", operand(0)),
                Test::AtLeastZero => format!("(is_at_least_zero {})", operand(0)),
                Test::AboveZero => format!("(and (fp.isPositive {0}) (not (fp.isZero {0})))", operand(0)),
                Test::AtMostZero => format!("(is_at_most_zero {})", operand(0)),
                Test::BelowZero => format!("(and (fp.isNegative {0}) (not (fp.isZero {0})))", operand(0)),
            }),
            Op::Bit(value) => Some(value.to_string()),
            Op::Word(width, value) => Some(format!("(_ bv{value} {width})")),
            Op::And => Some(both("and")),
            Op::Or => Some(both("or")),
            Op::Not => Some(format!("(not {})", operand(0))),
            Op::WordEqual => Some(both("=")),
            Op::WordLess => Some(both("bvult")),
            Op::Select(_) => Some(format!("(ite {} {} {})", operand(0), operand(1), operand(2))),
            Op::Same(_) => Some(operand(0)),
        };
        let sort = match kind {
            Kind::Number => "Number".to_string(),
            Kind::Word(width) => format!("(_ BitVec {width})"),
            Kind::Bit | Kind::Order => "Bool".to_string(),
        };
        let _ = match expression {
            None => writeln!(self.text, "(declare-fun {own}{id} () {sort})"),
            Some(expression) if node.inverted => {
                writeln!(self.text, "(define-fun {own}{id} () {sort} (not {expression}))")
            }
            Some(expression) => writeln!(self.text, "(define-fun {own}{id} () {sort} {expression})"),
        };
    }

    fn sum(&mut self, a: &str, b: &str) -> String {
        let _ = writeln!(self.text, "(assert (sum_laws {a} {b}))");
        format!("(sum_of {a} {b})")
    }

    /// The function of a rounding. Where it keeps all bits, its direction makes no difference.
    fn narrow(&mut self, to: Narrowing) -> String {
        let Narrowing { bits, direction, margin } = to;
        let is_exact = bits == SIGNIFICAND && margin == 0;
        let function =
            if is_exact { "narrow_none".to_string() } else { format!("narrow_{bits}_{direction:?}_{margin}") };
        self.declare(&function, &format!("(declare-fun {function} (Number) Number)"));
        function
    }

    /// The law of a comparison with a rounded number: a rounding without margin keeps the order, and keeps numbers that
    /// are rounded already.
    fn order_of_rounded(&mut self, a: &str, rounded: Id) {
        if let Op::Narrow(to) = self.graph.nodes[rounded].op
            && to.margin == 0
        {
            let function = self.narrow(to);
            for relation in ["fp.leq", "fp.geq"] {
                let _ = writeln!(
                    self.text,
                    "(assert (=> ({relation} {a} n{rounded}) ({relation} ({function} {a}) n{rounded})))"
                );
            }
        }
    }

    /// The laws of a sum that rounds once.
    fn sum_once(&mut self, sum: &str, terms: &[String]) {
        let all = |condition: &str| -> String { terms.iter().map(|term| format!(" ({condition} {term})")).collect() };
        let bounds =
            |relation: &str| -> String { terms.iter().map(|term| format!(" ({relation} {sum} {term})")).collect() };
        let signed = |sign: &str| -> String {
            terms.iter().map(|term| format!(" (and (fp.isInfinite {term}) ({sign} {term}))")).collect()
        };
        let _ = writeln!(
            self.text,
            "(assert (= (fp.isNaN {sum}) (or{} (and (or{}) (or{})))))\n\
             (assert (=> (and{}) (and{})))\n(assert (=> (and{}) (and{})))",
            all("fp.isNaN"),
            signed("fp.isPositive"),
            signed("fp.isNegative"),
            all("is_at_least_zero"),
            bounds("fp.geq"),
            all("is_at_most_zero"),
            bounds("fp.leq"),
        );
    }

    fn declare(&mut self, function: &str, declaration: &str) {
        if self.declared.insert(function.to_string()) {
            let _ = writeln!(self.text, "{declaration}");
        }
    }
}

fn bits(value: f32) -> String {
    format!("((_ to_fp 8 24) #x{:08x})", value.to_bits())
}
