//! The question whether a fault changes an outcome, for Z3: in its theory of floating-point numbers, with sums and
//! products as functions of which a few laws are known.

use super::evaluate::Dataflow;
use raypath_ops::{Direction, Narrowing, Relation, Test};
use raypath_rtl::dataflow::{Kind, NodeId, Op};
use raypath_tools::{SmtSolver, ToolError, temporary_folder};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Z3's limit for a question, in its units of work, so that its answers do not depend on the machine: about a second,
/// and three times what the longest known proof needs.
const WORK: u32 = 2_000_000;

/// The bits of a binary32 significand.
const SIGNIFICAND: u32 = 24;

/// The longest time for all questions of one run of Z3.
const LIMIT: Duration = Duration::from_secs(600);

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

/// For each question, whether its answer is `unsat`: no job can show the fault. Anything else is no proof.
///
/// # Errors
/// Z3 refuses a question, or `stop` is set meanwhile.
pub fn answers(z3: &SmtSolver, questions: &[String], stop: &AtomicBool) -> Result<Vec<bool>, ToolError> {
    let scripts: Vec<String> = questions
        .iter()
        .map(|text| format!("(set-option :rlimit {WORK})\n(set-logic ALL)\n{PREAMBLE}{text}"))
        .collect();
    let answers = z3.run(temporary_folder()?.path(), &scripts, LIMIT, stop)?.unwrap_or_default();
    let mut answers = answers.lines().map(|answer| answer.trim() == "unsat");
    Ok(questions.iter().map(|_| answers.next().unwrap_or(false)).collect())
}

/// A dataflow without a fault, and what is known of it.
pub struct Known<'g> {
    pub flow: &'g Dataflow,
    /// Numbers that are never NaN, each proved from those before.
    lemmas: BTreeSet<NodeId>,
}

impl<'g> Known<'g> {
    /// Finds the greatest set of numbers among `lemmas` that are never NaN, each because those before are not.
    ///
    /// # Errors
    /// Z3 refuses a question, or `stop` is set meanwhile.
    pub fn new(
        z3: &SmtSolver,
        flow: &'g Dataflow,
        lemmas: BTreeSet<NodeId>,
        stop: &AtomicBool,
    ) -> Result<Self, ToolError> {
        let mut known = Self { flow, lemmas };
        loop {
            let questions: Vec<String> = known.lemmas.iter().map(|&id| known.lemma(id)).collect();
            let answers = answers(z3, &questions, stop)?;
            let mut proved = answers.iter();
            let before = known.lemmas.len();
            known.lemmas.retain(|_| proved.next() == Some(&true));
            if known.lemmas.len() == before {
                return Ok(known);
            }
        }
    }

    /// The question whether a number can be NaN if those before that have a lemma are not.
    fn lemma(&self, id: NodeId) -> String {
        let mut script = Script { text: String::new(), declared: BTreeSet::new(), known: self };
        let is_free = |other: NodeId| other != id && self.flow.is_computed_number(other);
        let needed = needed(self.flow, [id], &is_free);
        for other in self.flow.graph.ids().filter(|other| needed[other.index()]) {
            script.value(other, is_free(other));
        }
        let _ = writeln!(script.text, "(assert (fp.isNaN n{}))\n(check-sat)", id.0);
        script.text
    }

    /// The question: `unsat` if the fault changes no output and no next state. `is_near` asks at the last value that
    /// all effects of the fault pass, and lets numbers that the fault does not affect be any: a proof with less is a
    /// proof, and is found sooner. Otherwise it asks at the outputs, with the laws of all sums, products and roundings.
    pub fn question(&self, faulty: &Dataflow, is_near: bool) -> String {
        let (graph, is_behind) = (&self.flow.graph, faulty.behind(self.flow));
        // A state is what it was before the job.
        let is_other = |id: NodeId| is_behind[id.index()] && !matches!(faulty.graph.node(id).op, Op::State(_));
        let outputs = self.flow.ends().into_iter().zip(faulty.ends()).collect();
        let cut = cut(self.flow, faulty, &is_behind).filter(|_| is_near);
        let pairs: Vec<(NodeId, NodeId)> = cut.map_or(outputs, |id| vec![(id, id)]);
        let is_free = |id: NodeId| is_near && !is_behind[id.index()] && self.flow.is_computed_number(id);
        // The values that are needed with and without the fault.
        let wrong = pairs.iter().map(|pair| pair.1).filter(|id| is_other(*id));
        let wrong = needed(faulty, wrong, &|id| !is_other(id));
        let shared = faulty.graph.ids().filter(|id| wrong[id.index()] && !is_other(*id));
        let ends = pairs.iter().flat_map(|&(a, b)| [Some(a), Some(b).filter(|id| !is_other(*id))]).flatten();
        let right = needed(self.flow, ends.chain(shared), &is_free);

        let mut script = Script { text: String::new(), declared: BTreeSet::new(), known: self };
        for id in graph.ids() {
            if right[id.index()] || matches!(graph.node(id).op, Op::Input(_) | Op::State(_)) {
                script.value(id, is_free(id));
            }
        }
        for id in faulty.graph.ids().filter(|id| wrong[id.index()] && is_other(*id)) {
            script.node(faulty, id, 'f', &|operand| if is_other(operand) { 'f' } else { 'n' });
        }
        let mut differs = String::new();
        for (a, b) in pairs.into_iter().filter(|(a, b)| a != b || is_other(*b)) {
            let _ = write!(differs, " (distinct n{} {}{})", a.0, if is_other(b) { 'f' } else { 'n' }, b.0);
        }
        let _ = writeln!(script.text, "(assert (or false{differs}))\n(check-sat)");
        script.text
    }
}

/// The values that these follow from, up to those that are free.
fn needed(flow: &Dataflow, ends: impl IntoIterator<Item = NodeId>, is_free: &dyn Fn(NodeId) -> bool) -> Vec<bool> {
    let mut needed = vec![false; flow.graph.nodes.len()];
    let mut open: Vec<NodeId> = ends.into_iter().collect();
    while let Some(id) = open.pop() {
        if !std::mem::replace(&mut needed[id.index()], true) && !is_free(id) {
            open.extend(flow.graph.operands(id));
        }
    }
    needed
}

/// The last value that all effects of a fault pass, if it is not the changed one. No order, because it has no value.
fn cut(right: &Dataflow, faulty: &Dataflow, is_behind: &[bool]) -> Option<NodeId> {
    if right.ends() != faulty.ends() {
        return None;
    }
    let graph = &faulty.graph;
    let behind: Vec<NodeId> = graph.ids().filter(|id| is_behind[id.index()]).collect();
    // The last reader of each value.
    let mut last: Vec<u32> = graph.ids().map(|id| id.0).collect();
    for &id in &behind {
        graph.operands(id).iter().for_each(|operand| last[operand.index()] = id.0);
    }
    faulty.ends().into_iter().for_each(|id| last[id.index()] = u32::MAX);
    let passes_all = |(place, id): (usize, &NodeId)| behind[..place].iter().all(|before| last[before.index()] <= id.0);
    let is_value = |id: &NodeId| graph.node(*id).kind != Kind::Order;
    let found = behind.iter().enumerate().skip(1).filter(|(_, id)| is_value(id)).rfind(|it| passes_all(*it));
    let is_changed = |id: &NodeId| graph.node(*id).op != right.graph.node(*id).op || faulty.inverted == Some(*id);
    let (_, &found) = found?;
    (!behind.iter().any(|id| *id > found && is_changed(id))).then_some(found)
}

struct Script<'g> {
    known: &'g Known<'g>,
    text: String,
    declared: BTreeSet<String>,
}

impl Script<'_> {
    /// The value of a node without the fault, or any number; not NaN where a lemma says so.
    fn value(&mut self, id: NodeId, is_free: bool) {
        if !is_free {
            return self.node(self.known.flow, id, 'n', &|_| 'n');
        }
        self.line(&format!("(declare-fun n{} () Number)", id.0));
        if self.known.lemmas.contains(&id) {
            self.line(&format!("(assert (not (fp.isNaN n{})))", id.0));
        }
    }

    fn line(&mut self, text: &str) {
        self.text += text;
        self.text.push('\n');
    }

    /// Defines the value of a node. Names of operands begin with what `of` says.
    fn node(&mut self, flow: &Dataflow, id: NodeId, own: char, of: &dyn Fn(NodeId) -> char) {
        let node = flow.graph.node(id);
        let operands = flow.graph.operands(id);
        let all: Vec<String> = operands.iter().map(|&operand| format!("{}{}", of(operand), operand.0)).collect();
        let a = all.first().map_or("", String::as_str);
        let apply = |function: &str| format!("({function} {})", all.join(" "));
        let own_name = format!("{own}{}", id.0);
        let sort = match node.kind {
            Kind::Number | Kind::Cut(..) => "Number".to_string(),
            Kind::Word(1) | Kind::Order => "Bool".to_string(),
            Kind::Word(width) => format!("(_ BitVec {width})"),
        };
        let expression = match &node.op {
            Op::Input(_) | Op::State(_) | Op::Flags(_) if own == 'n' => {
                return self.line(&format!("(declare-fun {own_name} () {sort})"));
            }
            // An input that is exchanged with another is the value at the other's port.
            Op::Input(_) | Op::State(_) | Op::Flags(_) => {
                let graph = &self.known.flow.graph;
                format!("n{}", graph.ids().find(|other| graph.node(*other).op == node.op).unwrap_or(id).0)
            }
            Op::Number(bits) => number(*bits),
            Op::Ulps(ulps) => number((*ulps as f32 * f32::EPSILON).to_bits()),
            Op::Add(..) => self.sum(a, &all[1]),
            Op::Subtract(..) => self.sum(a, &format!("(fp.neg {})", all[1])),
            Op::Multiply(..) => {
                self.line(&format!("(assert {})", apply("product_laws")));
                apply("product")
            }
            Op::Sum(_) => {
                let function = format!("sum_{}", all.len());
                self.declare(&function, &" Number".repeat(all.len()), "Number");
                self.sum_once(&apply(&function), &all);
                apply(&function)
            }
            Op::Residue(..) => {
                self.declare("residue", "Number Number Number", &sort);
                apply("residue")
            }
            Op::Negate(_) => apply("fp.neg"),
            Op::Narrow(_, to) => {
                let function = self.narrow(*to);
                let narrow = apply(&function);
                let relation = if to.direction == Direction::TowardZero { "fp.leq" } else { "fp.geq" };
                self.line(&format!("(assert (narrow_laws {a} {narrow}))"));
                // A number below twice the least normal one becomes zero, whatever the direction.
                self.line(&format!(
                    "(assert (or (fp.isNaN {a}) (fp.isZero {narrow}) ({relation} (fp.abs {narrow}) (fp.abs {a}))))"
                ));
                narrow
            }
            // Relations read the operands.
            Op::Compare(..) => {
                self.line(&format!("(define-fun {own_name}a () Number {a})"));
                self.line(&format!("(define-fun {own_name}b () Number {})", all[1]));
                for [other, rounded] in [[0, 1], [1, 0]] {
                    // A value behind the fault may be another rounding than the one that the dataflow has there.
                    if of(operands[rounded]) == 'n' {
                        self.order_of_rounded(&all[other], operands[rounded]);
                    }
                }
                return;
            }
            Op::Relation(_, relation) => {
                let function = match relation {
                    Relation::Less => "fp.lt",
                    Relation::LessOrEqual => "fp.leq",
                    Relation::Equal => "fp.eq",
                    Relation::GreaterOrEqual => "fp.geq",
                    Relation::Greater => "fp.gt",
                };
                format!("({function} {a}a {a}b)")
            }
            Op::NumberOf(word) if flow.graph.node(*word).kind == Kind::Word(1) => {
                format!("(ite {a} {} {})", number(1.0_f32.to_bits()), number(0))
            }
            Op::NumberOf(_) => format!("((_ to_fp_unsigned 8 24) RNE {a})"),
            Op::Test(test, _) => match test {
                // The sign of a NaN may be any.
                Test::SignBit => {
                    self.line(&format!("(declare-fun {own_name}s () Bool)"));
                    format!("(ite (fp.isNaN {a}) {own_name}s (fp.isNegative {a}))")
                }
                Test::Zero => apply("fp.isZero"),
                Test::Nan => apply("fp.isNaN"),
                Test::AtLeastZero => apply("is_at_least_zero"),
                Test::AboveZero => format!("(and (fp.isPositive {a}) (not (fp.isZero {a})))"),
                Test::AtMostZero => apply("is_at_most_zero"),
                Test::BelowZero => format!("(and (fp.isNegative {a}) (not (fp.isZero {a})))"),
            },
            Op::Bit(value) => value.to_string(),
            Op::Word(value) if node.kind == Kind::Word(1) => (*value == 1).to_string(),
            Op::Word(value) => sort.replace("BitVec", &format!("bv{value}")),
            Op::And(..) => apply("and"),
            Op::Or(..) => apply("or"),
            Op::WordOr(..) => apply("bvor"),
            Op::Not(_) => apply("not"),
            Op::WordEqual(..) => apply("="),
            Op::WordLess(word, _) if flow.graph.node(*word).kind == Kind::Word(1) => {
                format!("(and (not {a}) {})", all[1])
            }
            Op::WordLess(..) => apply("bvult"),
            Op::Select(..) => apply("ite"),
            Op::Continue(_) => a.to_string(),
        };
        let expression = if flow.inverted == Some(id) { format!("(not {expression})") } else { expression };
        self.line(&format!("(define-fun {own_name} () {sort} {expression})"));
    }

    fn sum(&mut self, a: &str, b: &str) -> String {
        self.line(&format!("(assert (sum_laws {a} {b}))"));
        format!("(sum_of {a} {b})")
    }

    /// The function of a rounding. Where it keeps all bits, its direction makes no difference.
    fn narrow(&mut self, to: Narrowing) -> String {
        let Narrowing { bits, direction, margin } = to;
        let is_exact = bits == SIGNIFICAND && margin == 0;
        let function =
            if is_exact { "narrow_none".to_string() } else { format!("narrow_{bits}_{direction:?}_{margin}") };
        self.declare(&function, "Number", "Number");
        function
    }

    /// The law of a comparison with a rounded number: a rounding without margin keeps the order, and keeps numbers that
    /// are rounded already.
    fn order_of_rounded(&mut self, a: &str, rounded: NodeId) {
        if let Op::Narrow(_, to) = self.known.flow.graph.node(rounded).op
            && to.margin == 0
        {
            let (function, rounded) = (self.narrow(to), rounded.0);
            for order in ["fp.leq", "fp.geq"] {
                self.line(&format!("(assert (=> ({order} {a} n{rounded}) ({order} ({function} {a}) n{rounded})))"));
            }
        }
    }

    /// The laws of a sum that rounds once.
    fn sum_once(&mut self, sum: &str, terms: &[String]) {
        let all = |condition: &str, rest: &str| -> String {
            terms.iter().map(|term| format!(" ({condition} {term}{rest})")).collect()
        };
        let signed = |sign: &str| -> String {
            terms.iter().map(|term| format!(" (and (fp.isInfinite {term}) ({sign} {term}))")).collect()
        };
        self.line(&format!(
            "(assert (= (fp.isNaN {sum}) (or{} (and (or{}) (or{})))))",
            all("fp.isNaN", ""),
            signed("fp.isPositive"),
            signed("fp.isNegative"),
        ));
        for (sign, order) in [("is_at_least_zero", "fp.leq"), ("is_at_most_zero", "fp.geq")] {
            self.line(&format!("(assert (=> (and{}) (and{})))", all(sign, ""), all(order, &format!(" {sum}"))));
        }
    }

    fn declare(&mut self, function: &str, numbers: &str, result: &str) {
        if self.declared.insert(function.to_string()) {
            self.line(&format!("(declare-fun {function} ({numbers}) {result})"));
        }
    }
}

fn number(bits: u32) -> String {
    format!("((_ to_fp 8 24) #x{bits:08x})")
}
