//! The question whether a fault changes an outcome, for Z3: in its theory of floating-point numbers, with sums and
//! products as functions of which a few laws are known.

use super::evaluate::behind;
use super::graph::{Graph, Id, Kind, Node, Op};
use crate::Error;
use raypath_ops::{Relation, Test};
use raypath_tools::{ToolError, Z3, temporary_folder};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Z3.
pub struct Solver {
    z3: Z3,
}

/// The longest time for a question.
const LIMIT: Duration = Duration::from_secs(20);

impl Solver {
    /// Finds Python's module `z3`.
    ///
    /// # Errors
    /// It is missing.
    pub fn find() -> Result<Self, Error> {
        Ok(Self { z3: Z3::find()? })
    }

    /// Whether no job can show a fault: the answer `unsat`. Anything else is no proof.
    ///
    /// # Errors
    /// Z3 refuses the question.
    pub fn proves_equal(&self, graph: &Graph, faulty: &Graph, stop: &AtomicBool) -> Result<bool, Error> {
        let folder = temporary_folder()?;
        match self.z3.run(folder.path(), &[question(graph, faulty)], LIMIT, stop) {
            Ok(answer) => Ok(answer.is_some_and(|answer| answer.trim() == "unsat")),
            Err(ToolError::Stopped) => Ok(false),
            Err(other) => Err(other.into()),
        }
    }
}

/// Functions of numbers, and their laws. A product has the sign of its operands' signs; the functions are of magnitudes.
const PREAMBLE: &str = "(set-logic ALL)
(define-sort Number () (_ FloatingPoint 8 24))
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
(define-fun product_laws ((a Number) (b Number)) Bool (let ((x (fp.abs a)) (y (fp.abs b)))
  (let ((m (product_of x y))) (and
  (= m (product_of y x))
  (= (fp.isNaN m) (or (fp.isNaN a) (fp.isNaN b) (and (fp.isInfinite a) (fp.isZero b)) (and (fp.isZero a) (fp.isInfinite b))))
  (=> (not (fp.isNaN m)) (fp.isPositive m))
  (=> (and (not (fp.isNaN m)) (or (fp.isZero a) (fp.isZero b))) (fp.isZero m))
  (=> (and (not (fp.isNaN m)) (or (fp.isInfinite a) (fp.isInfinite b))) (fp.isInfinite m))))))
";

/// The script: `unsat` if the fault changes no output and no next state.
pub fn question(graph: &Graph, faulty: &Graph) -> String {
    let mut script = Script { text: PREAMBLE.to_string(), declared: BTreeSet::new(), graph };
    let (live, is_behind) = (graph.live(), behind(graph, faulty));
    let needed = faulty.live();
    for (id, node) in graph.nodes.iter().enumerate().filter(|(id, _)| live[*id] || needed[*id]) {
        script.node(id, node, 'n', &|_| 'n');
    }
    for (id, node) in faulty.nodes.iter().enumerate() {
        // A state is what it was before the job.
        if is_behind[id] && !matches!(node.op, Op::State(_)) {
            let is_state = |operand: Id| matches!(faulty.nodes[operand].op, Op::State(_));
            script.node(id, node, 'f', &|operand| if is_behind[operand] && !is_state(operand) { 'f' } else { 'n' });
        }
    }
    let value = |id: Id| {
        let is_state = matches!(faulty.nodes[id].op, Op::State(_));
        format!("{}{id}", if is_behind[id] && !is_state { 'f' } else { 'n' })
    };
    let outputs = graph.outputs.iter().map(|leaf| leaf.node).zip(faulty.outputs.iter().map(|leaf| leaf.node));
    let states = graph.states.iter().map(|state| state.1).zip(faulty.states.iter().map(|state| state.1));
    let mut differs = String::new();
    for (right, wrong) in outputs.chain(states) {
        let _ = write!(differs, " (distinct n{right} {})", value(wrong));
    }
    let _ = writeln!(script.text, "(assert (or false{differs}))\n(check-sat)");
    script.text
}

struct Script<'g> {
    /// The dataflow without the fault.
    graph: &'g Graph,
    text: String,
    declared: BTreeSet<String>,
}

impl Script<'_> {
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
                Some(format!("({function} {})", terms.join(" ")))
            }
            Op::Negate => Some(format!("(fp.neg {})", operand(0))),
            Op::Narrow(to) => {
                let function = format!("narrow_{}_{:?}_{}", to.bits, to.direction, to.margin);
                self.declare(&function, &format!("(declare-fun {function} (Number) Number)"));
                Some(format!("({function} {})", operand(0)))
            }
            // Relations read the operands.
            Op::Compare => {
                let _ = writeln!(self.text, "(define-fun {own}{id}a () Number {})", operand(0));
                let _ = writeln!(self.text, "(define-fun {own}{id}b () Number {})", operand(1));
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

    fn declare(&mut self, function: &str, declaration: &str) {
        if self.declared.insert(function.to_string()) {
            let _ = writeln!(self.text, "{declaration}");
        }
    }
}

fn bits(value: f32) -> String {
    format!("((_ to_fp 8 24) #x{:08x})", value.to_bits())
}
