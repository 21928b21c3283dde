//! Expressions as text.
//!
//! Verilog extends operands to the greatest width of the expression. Here all operands have equal widths; selects,
//! shift amounts and parts of concatenations are self-determined; and factors are extended to the width of their
//! product. An expression therefore has the same value alone and inside another.

use super::layout::width_text;
use super::plan::Rendering;
use crate::netlist::{Driver, Module, Signal, SignalId, mask};
use crate::text::PAYLOAD;

/// Text, and the properties that decide about parentheses around it.
#[derive(Debug, Clone)]
pub struct Expression {
    /// The expression.
    pub text: String,
    /// Levels of operators in it.
    pub depth: u32,
    shape: Shape,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// A name, constant, select or replication: needs no parentheses anywhere.
    Primary,
    Concat,
    Not,
    /// A reduction.
    Reduce,
    Binary(&'static str),
    Conditional,
}

/// The expression that drives a signal.
pub fn render(module: &Module, renderings: &[Rendering], id: SignalId) -> Expression {
    let width = module.signal(id).width;
    let read = |id: SignalId| read(renderings, id);
    let binary = |a: &SignalId, operator, b: &SignalId| {
        let (a, b) = (read(*a), read(*b));
        let text = format!("{} {operator} {}", a.beside(operator), b.beside(operator));
        Expression { text, depth: 1 + a.depth.max(b.depth), shape: Shape::Binary(operator) }
    };
    let unary = |operator: &str, a: &SignalId, shape| {
        let a = read(*a);
        Expression { text: format!("{operator}{}", a.alone()), depth: a.depth + u32::from(shape != Shape::Not), shape }
    };
    match &module.signal(id).driver {
        Driver::Input | Driver::Register(_) | Driver::Instance { .. } | Driver::Memory { .. } | Driver::Case { .. } => {
            read(id)
        }
        Driver::Constant(_) if module.signal(id).name.is_some() => read(id),
        Driver::Constant(0) if module.text().has_width_parameter && width == PAYLOAD => {
            Expression::primary("'0".to_string())
        }
        Driver::Constant(value) => {
            let label = module.hinted_label(module.signal(id), *value, Some(width));
            Expression::primary(label.unwrap_or_else(|| constant(width, *value)))
        }
        Driver::Not(a) => match (&renderings[a.index()], &module.signal(*a).driver) {
            (Rendering::Inline(_), Driver::Equal(x, y)) => binary(x, "!=", y),
            _ => unary("~", a, Shape::Not),
        },
        Driver::Any(a) => unary("|", a, Shape::Reduce),
        Driver::All(a) => unary("&", a, Shape::Reduce),
        Driver::And(a, b) => binary(a, "&", b),
        Driver::Or(a, b) => binary(a, "|", b),
        Driver::Xor(a, b) => binary(a, "^", b),
        Driver::Add(a, b) => binary(a, "+", b),
        Driver::Sub(a, b) => binary(a, "-", b),
        Driver::Equal(a, b) => binary(a, "==", b),
        Driver::Less(a, b) => binary(a, "<", b),
        Driver::ShiftLeft(a, b) => binary(a, "<<", b),
        Driver::ShiftRight(a, b) => binary(a, ">>", b),
        Driver::Mul(a, b) => {
            let (wide, other) = (module.signal(*b).width, module.signal(*a).width);
            let (a, b) = (read(*a), read(*b));
            let text = format!("{} * {}", a.extended(width, wide), b.extended(width, other));
            Expression { text, depth: 1 + a.depth.max(b.depth), shape: Shape::Binary("*") }
        }
        Driver::Mux { select, if_true, if_false } => {
            let (select, yes, no) = (read(*select), read(*if_true), read(*if_false));
            let text = format!("{} ? {} : {}", select.beside("?"), yes.branch(), no.branch());
            let depth = 1 + select.depth.max(yes.depth).max(no.depth);
            Expression { text, depth, shape: Shape::Conditional }
        }
        Driver::Concat(parts) => concat(module, parts, read),
        Driver::Slice { source, low } => {
            let (root, low) = slice_root(module, *source, *low);
            select(module, renderings, module.signal(id), root, low)
        }
        Driver::Alias(source) => read(*source),
    }
}

/// A constant of `width` bits: small values in decimal, others in hexadecimal.
pub fn constant(width: u32, value: u64) -> String {
    if width == 1 {
        return format!("1'b{value}");
    }
    if value < 1000 {
        return format!("{width}'d{value}");
    }
    let digits = format!("{value:0count$x}", count = width.div_ceil(4) as usize);
    let first = digits.len() % 4;
    let mut groups: Vec<&str> = if first == 0 { Vec::new() } else { vec![&digits[..first]] };
    groups.extend((first..digits.len()).step_by(4).map(|at| &digits[at..at + 4]));
    format!("{width}'h{}", groups.join("_"))
}

/// The signal and the lowest bit with which a slice of `source` is printed: a slice of a slice is one slice.
pub fn slice_root(module: &Module, source: SignalId, low: u32) -> (SignalId, u32) {
    let (mut root, mut from) = (source, low);
    while let (None, None, Driver::Slice { source, low }) =
        (&module.signal(root).name, &module.signal(root).comment, &module.signal(root).driver)
    {
        (root, from) = (*source, from + low);
    }
    (root, from)
}

/// Parts of a concatenation with repetitions counted.
pub fn repetitions(parts: &[SignalId]) -> Vec<(SignalId, usize)> {
    let mut counted: Vec<(SignalId, usize)> = Vec::new();
    for &part in parts {
        match counted.last_mut() {
            Some((last, count)) if *last == part => *count += 1,
            _ => counted.push((part, 1)),
        }
    }
    counted
}

impl Expression {
    fn primary(text: String) -> Self {
        Self { text, depth: 0, shape: Shape::Primary }
    }

    /// As the operand of a unary operator.
    fn alone(&self) -> String {
        match self.shape {
            Shape::Primary | Shape::Concat => self.text.clone(),
            _ => format!("({})", self.text),
        }
    }

    /// As an operand of a binary operator, or the condition of `?`.
    fn beside(&self, operator: &str) -> String {
        match self.shape {
            Shape::Primary | Shape::Concat | Shape::Not => self.text.clone(),
            Shape::Binary(own) if own == operator && ["&", "|", "^", "+"].contains(&own) => self.text.clone(),
            _ => format!("({})", self.text),
        }
    }

    /// As a branch of a conditional.
    fn branch(&self) -> String {
        if self.shape == Shape::Conditional { format!("({})", self.text) } else { self.text.clone() }
    }

    /// As a factor of a product of `width` bits, `more` than its own. A cast of an expression would be correct by the
    /// standard, but Verilator 5.006 computes `64'(a + b)` in 64 bits and so keeps a carry.
    fn extended(&self, width: u32, more: u32) -> String {
        match self.shape {
            Shape::Primary => format!("{width}'({})", self.text),
            _ => format!("{{{}, {}}}", constant(more, 0), self.part()),
        }
    }

    /// As a part of a concatenation; a nested concatenation needs no braces.
    fn part(&self) -> &str {
        let bare = self.text.strip_prefix('{').and_then(|t| t.strip_suffix('}'));
        bare.filter(|_| self.shape == Shape::Concat).unwrap_or(&self.text)
    }
}

fn read(renderings: &[Rendering], id: SignalId) -> Expression {
    match &renderings[id.index()] {
        Rendering::Name(name) => Expression::primary(name.clone()),
        Rendering::Inline(expression) => expression.clone(),
        Rendering::Unread => Expression::primary(String::new()),
    }
}

fn concat(module: &Module, parts: &[SignalId], read: impl Fn(SignalId) -> Expression) -> Expression {
    let parts: Vec<(Expression, usize)> = repetitions(parts).into_iter().map(|(id, n)| (read(id), n)).collect();
    let depth = 1 + parts.iter().map(|(part, _)| part.depth).max().unwrap_or(0);
    let print = |(part, count): &(Expression, usize)| match count {
        1 => part.part().to_string(),
        _ => format!("{{{}{{{}}}}}", width_text(module, *count as u32), part.part()),
    };
    let texts: Vec<String> = parts.iter().map(print).collect();
    match parts.as_slice() {
        [(_, 2..)] => Expression { text: texts.concat(), depth, shape: Shape::Primary },
        _ => Expression { text: format!("{{{}}}", texts.join(", ")), depth, shape: Shape::Concat },
    }
}

fn select(module: &Module, renderings: &[Rendering], slice: &Signal, root: SignalId, low: u32) -> Expression {
    let (signal, width) = (module.signal(root), slice.width);
    let high = low + width - 1;
    match (&renderings[root.index()], &signal.driver) {
        (Rendering::Inline(_), Driver::Constant(value)) => {
            Expression::primary(constant(width, (value >> low) & mask(width)))
        }
        (rendering, _) if width == signal.width => match rendering {
            Rendering::Inline(expression) => expression.clone(),
            _ => read(renderings, root),
        },
        _ => {
            let root = read(renderings, root).text;
            // A range of a range is no SystemVerilog: the bits are those of the whole.
            if let Some((whole, offset)) = range(&root) {
                return Expression::primary(format!("{whole}[{}:{}]", offset + high, offset + low));
            }
            // Yosys 0.23 crashes on one bit of an array's element in a structure, but not on a range of one bit.
            if width > 1 || root.ends_with(']') {
                return Expression::primary(format!("{root}[{high}:{low}]"));
            }
            let place = module.hinted_label(slice, low.into(), None).unwrap_or_else(|| low.to_string());
            Expression::primary(format!("{root}[{place}]"))
        }
    }
}

/// What a text with a range at its end is a range of, and its lowest bit.
fn range(text: &str) -> Option<(&str, u32)> {
    let (whole, range) = text.strip_suffix(']')?.rsplit_once('[')?;
    Some((whole, range.split_once(':')?.1.parse().ok()?))
}
