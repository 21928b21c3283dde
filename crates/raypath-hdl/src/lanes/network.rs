//! A netlist as a network of gates on bits, with constants folded and equal gates shared.

use std::collections::HashMap;

/// A bit of every lane: a position in [`Network::gates`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bit(u32);

impl Bit {
    pub const ZERO: Self = Self(0);
    pub const ONE: Self = Self(1);

    pub fn index(self) -> usize {
        self.0 as usize
    }

    fn constant(self) -> Option<bool> {
        (self <= Self::ONE).then_some(self == Self::ONE)
    }
}

impl From<bool> for Bit {
    fn from(value: bool) -> Self {
        if value { Self::ONE } else { Self::ZERO }
    }
}

/// The function of a gate of the operands `a`, `b` and `c`. Unused operands are `ZERO`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The value of `a` at this point of the evaluation.
    Copy,
    /// `!a`
    Not,
    /// This function of `a` and `b`.
    Two(Two),
    /// The first function of `a` and `b`, then the second function of the result and `c`.
    Pair(Two, Two),
    /// `a ? b : c`
    Mux,
    /// Whether at least two of `a`, `b` and `c` are set.
    Majority,
}

/// A function of two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Two {
    /// `a & b`
    And,
    /// `a & !b`
    AndNot,
    /// `!a & b`
    NotAnd,
    /// `a | b`
    Or,
    /// `a ^ b`
    Xor,
}

impl Kind {
    pub fn operands(self) -> usize {
        match self {
            Self::Copy | Self::Not => 1,
            Self::Two(_) => 2,
            Self::Pair(..) | Self::Mux | Self::Majority => 3,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gate {
    /// The content of this place at the start of the evaluation.
    Source(u32),
    /// The call of this position in [`Network::calls`].
    Call(u32),
    /// A bit of the results of the call at this gate.
    Result(Bit, u32),
    Operation(Kind, [Bit; 3]),
}

/// A call of a function of which all bits are given.
pub struct Call {
    pub function: usize,
    pub arguments: Vec<Bit>,
}

/// Gates, operands before readers.
pub struct Network {
    pub gates: Vec<Gate>,
    pub calls: Vec<Call>,
    known: HashMap<Gate, Bit>,
}

impl Network {
    /// A network of the two constants, which are in the first two places.
    pub fn new() -> Self {
        let mut network = Self { gates: Vec::new(), calls: Vec::new(), known: HashMap::new() };
        network.source(0);
        network.source(1);
        network
    }

    pub fn source(&mut self, place: u32) -> Bit {
        self.gate(Gate::Source(place))
    }

    /// Calls a function. Pass the returned bit to [`result`](Self::result).
    pub fn call(&mut self, function: usize, arguments: Vec<Bit>) -> Bit {
        self.calls.push(Call { function, arguments });
        self.gate(Gate::Call(self.calls.len() as u32 - 1))
    }

    pub fn result(&mut self, call: Bit, bit: u32) -> Bit {
        self.gate(Gate::Result(call, bit))
    }

    /// The operands of a gate.
    pub fn operands<'a>(&'a self, gate: &'a Gate) -> &'a [Bit] {
        match gate {
            Gate::Source(_) => &[],
            Gate::Call(call) => &self.calls[*call as usize].arguments,
            Gate::Result(call, _) => std::slice::from_ref(call),
            Gate::Operation(kind, operands) => &operands[..kind.operands()],
        }
    }

    /// A copy of a bit in a place of its own, which keeps its value when registers and inputs change.
    pub fn kept(&mut self, a: Bit) -> Bit {
        match self.gates[a.index()] {
            Gate::Source(_) if a != Bit::ZERO => self.operation(Kind::Copy, [a, Bit::ZERO, Bit::ZERO]),
            _ => a,
        }
    }

    pub fn not(&mut self, a: Bit) -> Bit {
        match (a.constant(), self.complemented(a)) {
            (Some(value), _) => Bit::from(!value),
            (_, Some(inside)) => inside,
            _ => self.operation(Kind::Not, [a, Bit::ZERO, Bit::ZERO]),
        }
    }

    pub fn and(&mut self, a: Bit, b: Bit) -> Bit {
        match (a.constant(), b.constant()) {
            (Some(false), _) | (_, Some(true)) => a,
            (_, Some(false)) | (Some(true), _) => b,
            _ if a == b => a,
            _ => match (self.complemented(a), self.complemented(b)) {
                (_, Some(b)) => self.and_not(a, b),
                (Some(a), _) => self.and_not(b, a),
                _ => self.symmetric(Two::And, a, b),
            },
        }
    }

    /// `a & !b`
    pub fn and_not(&mut self, a: Bit, b: Bit) -> Bit {
        match (a.constant(), b.constant()) {
            (Some(false), _) | (_, Some(false)) => a,
            (_, Some(true)) => Bit::ZERO,
            (Some(true), _) => self.not(b),
            _ if a == b => Bit::ZERO,
            _ => match self.complemented(b) {
                Some(b) => self.and(a, b),
                None => self.operation(Kind::Two(Two::AndNot), [a, b, Bit::ZERO]),
            },
        }
    }

    pub fn or(&mut self, a: Bit, b: Bit) -> Bit {
        match (a.constant(), b.constant()) {
            (Some(true), _) | (_, Some(false)) => a,
            (_, Some(true)) | (Some(false), _) => b,
            _ if a == b => a,
            _ => self.disjunction(a, b),
        }
    }

    pub fn xor(&mut self, a: Bit, b: Bit) -> Bit {
        match (a.constant(), b.constant()) {
            (Some(false), _) => b,
            (_, Some(false)) => a,
            (Some(true), _) => self.not(b),
            (_, Some(true)) => self.not(a),
            _ if a == b => Bit::ZERO,
            _ => match (self.pair(Two::Xor, a), self.pair(Two::Xor, b)) {
                (Some([x, y]), _) => self.xor3(x, y, b),
                (_, Some([x, y])) => self.xor3(x, y, a),
                _ => self.symmetric(Two::Xor, a, b),
            },
        }
    }

    pub fn mux(&mut self, select: Bit, if_true: Bit, if_false: Bit) -> Bit {
        if if_true == if_false {
            return if_true;
        }
        match (select.constant(), if_true.constant(), if_false.constant()) {
            (Some(true), ..) => if_true,
            (Some(false), ..) => if_false,
            (_, Some(true), _) => self.or(select, if_false),
            (_, Some(false), _) => self.and_not(if_false, select),
            (_, _, Some(false)) => self.and(select, if_true),
            (_, _, Some(true)) => {
                let neither = self.and_not(select, if_true);
                self.not(neither)
            }
            _ => match (self.complemented(select), self.pair(Two::Xor, select)) {
                (Some(select), _) => self.mux(select, if_false, if_true),
                // A common form of the carry of a full adder.
                (_, Some([a, b])) if if_false == a || if_false == b => self.majority(a, b, if_true),
                _ => self.operation(Kind::Mux, [select, if_true, if_false]),
            },
        }
    }

    /// The sum's bit of a full adder.
    pub fn xor3(&mut self, a: Bit, b: Bit, c: Bit) -> Bit {
        let operands = sorted([a, b, c]);
        let [a, b, c] = operands;
        if a == b || b == c {
            return if a == b { c } else { a };
        }
        if a.constant().is_some() {
            let pair = self.xor(b, c);
            return self.xor(a, pair);
        }
        self.operation(Kind::Pair(Two::Xor, Two::Xor), operands)
    }

    /// The carry of a full adder.
    pub fn majority(&mut self, a: Bit, b: Bit, c: Bit) -> Bit {
        let operands = sorted([a, b, c]);
        let [a, b, c] = operands;
        match a.constant() {
            Some(false) => self.and(b, c),
            Some(true) => self.or(b, c),
            None if a == b || b == c => b,
            None => self.operation(Kind::Majority, operands),
        }
    }

    /// Whether any bit is set, as a tree of gates.
    pub fn any(&mut self, bits: &[Bit]) -> Bit {
        self.tree(bits, Self::or).unwrap_or(Bit::ZERO)
    }

    /// Whether every bit is set.
    pub fn all(&mut self, bits: &[Bit]) -> Bit {
        self.tree(bits, Self::and).unwrap_or(Bit::ONE)
    }

    fn tree(&mut self, bits: &[Bit], join: fn(&mut Self, Bit, Bit) -> Bit) -> Option<Bit> {
        let mut row = bits.to_vec();
        while row.len() > 1 {
            row = row.chunks(2).map(|pair| if let &[a, b] = pair { join(self, a, b) } else { pair[0] }).collect();
        }
        row.first().copied()
    }

    /// The operand of `a`, if `a` is a complement.
    fn complemented(&self, a: Bit) -> Option<Bit> {
        match self.gates[a.index()] {
            Gate::Operation(Kind::Not, [inside, ..]) => Some(inside),
            _ => None,
        }
    }

    /// The operands of `a`, if it is this function of two operands.
    fn pair(&self, two: Two, a: Bit) -> Option<[Bit; 2]> {
        match self.gates[a.index()] {
            Gate::Operation(kind, [a, b, _]) if kind == Kind::Two(two) => Some([a, b]),
            _ => None,
        }
    }

    /// `a | b`, which may be a selection.
    fn disjunction(&mut self, a: Bit, b: Bit) -> Bit {
        for (chosen, other) in [(a, b), (b, a)] {
            if let (Some([x, y]), Some([if_false, select])) =
                (self.pair(Two::And, chosen), self.pair(Two::AndNot, other))
                && (x == select || y == select)
            {
                return self.mux(select, if x == select { y } else { x }, if_false);
            }
        }
        self.symmetric(Two::Or, a, b)
    }

    fn symmetric(&mut self, two: Two, a: Bit, b: Bit) -> Bit {
        self.operation(Kind::Two(two), [a.min(b), a.max(b), Bit::ZERO])
    }

    fn operation(&mut self, kind: Kind, operands: [Bit; 3]) -> Bit {
        self.gate(Gate::Operation(kind, operands))
    }

    fn gate(&mut self, gate: Gate) -> Bit {
        *self.known.entry(gate).or_insert_with(|| {
            self.gates.push(gate);
            Bit(self.gates.len() as u32 - 1)
        })
    }
}

/// In the order of their places: constants first.
fn sorted(mut operands: [Bit; 3]) -> [Bit; 3] {
    operands.sort();
    operands
}
