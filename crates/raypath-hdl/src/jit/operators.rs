//! Code for the operators of a netlist on words of 64 bits.
//!
//! The bits of a word above its signal's width may be undefined. They are cleared only before a reader that depends on
//! them, so a sum that is only an operand of another sum costs one instruction.

use super::Body;
use crate::netlist::{Arm, Driver, SignalId, mask};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{InstBuilder, Value};

/// A word and how many of its lowest bits can be other than zero.
#[derive(Clone, Copy)]
pub struct Word {
    pub value: Value,
    pub bits: u32,
}

impl Body<'_> {
    pub fn operator(&mut self, driver: &Driver, width: u32) -> Word {
        match driver {
            Driver::Constant(value) => Word { value: self.constant(*value), bits: 64 - value.leading_zeros() },
            Driver::Not(a) => {
                let a = self.word(*a).value;
                Word { value: self.builder.ins().bnot(a), bits: 64 }
            }
            Driver::And(a, b) | Driver::Or(a, b) | Driver::Xor(a, b) | Driver::Add(a, b) | Driver::Sub(a, b) => {
                let (a, b) = (self.word(*a), self.word(*b));
                let (ins, most) = (self.builder.ins(), a.bits.max(b.bits));
                let (value, bits) = match driver {
                    Driver::And(..) => (ins.band(a.value, b.value), a.bits.min(b.bits)),
                    Driver::Or(..) => (ins.bor(a.value, b.value), most),
                    Driver::Xor(..) => (ins.bxor(a.value, b.value), most),
                    Driver::Add(..) => (ins.iadd(a.value, b.value), (most + 1).min(64)),
                    _ => (ins.isub(a.value, b.value), 64),
                };
                Word { value, bits }
            }
            Driver::Mul(a, b) => {
                let (a, b) = (self.clean(*a), self.clean(*b));
                Word { value: self.builder.ins().imul(a, b), bits: width }
            }
            Driver::Equal(a, b) => self.compare(IntCC::Equal, *a, *b),
            Driver::Less(a, b) => self.compare(IntCC::UnsignedLessThan, *a, *b),
            Driver::Any(a) => {
                let (a, zero) = (self.clean(*a), self.constant(0));
                self.bit(IntCC::NotEqual, a, zero)
            }
            Driver::All(a) => {
                let ones = self.constant(mask(self.width(*a)));
                let a = self.clean(*a);
                self.bit(IntCC::Equal, a, ones)
            }
            Driver::ShiftLeft(a, amount) => {
                let (value, by) = (self.word(*a).value, self.clean(*amount));
                let shifted = self.builder.ins().ishl(value, by);
                Word { value: self.unless_too_far(shifted, *amount), bits: 64 }
            }
            Driver::ShiftRight(a, amount) => {
                let (value, by) = (self.clean(*a), self.clean(*amount));
                let shifted = self.builder.ins().ushr(value, by);
                Word { value: self.unless_too_far(shifted, *amount), bits: width }
            }
            Driver::Mux { select, if_true, if_false } => {
                let (select, if_true, if_false) = (self.clean(*select), self.word(*if_true), self.word(*if_false));
                let value = self.builder.ins().select(select, if_true.value, if_false.value);
                Word { value, bits: if_true.bits.max(if_false.bits) }
            }
            Driver::Case { selector, arms, default } => self.case(*selector, arms, *default),
            Driver::Concat(parts) => self.concat(parts),
            Driver::Slice { source, low } => {
                let source = self.word(*source);
                Word { value: self.shifted_right(source.value, *low), bits: source.bits.saturating_sub(*low) }
            }
            Driver::Alias(a) => self.word(*a),
            Driver::Input | Driver::Register(_) | Driver::Instance { .. } | Driver::Memory { .. } => {
                unreachable!("the graph makes operations of their own of these")
            }
        }
    }

    /// A signal's value with zeros above its width; made once.
    pub fn clean(&mut self, id: SignalId) -> Value {
        let (word, width) = (self.word(id), self.width(id));
        if word.bits <= width {
            return word.value;
        }
        let value = match self.driver(id) {
            // Instead of a complement and a mask.
            Some(&Driver::Not(a)) => {
                let (a, ones) = (self.clean(a), self.constant(mask(width)));
                self.builder.ins().bxor(a, ones)
            }
            _ => {
                let ones = self.constant(mask(width));
                self.builder.ins().band(word.value, ones)
            }
        };
        self.values[id.index()] = Word { value, bits: width };
        value
    }

    fn compare(&mut self, condition: IntCC, a: SignalId, b: SignalId) -> Word {
        let (a, b) = (self.clean(a), self.clean(b));
        self.bit(condition, a, b)
    }

    fn bit(&mut self, condition: IntCC, a: Value, b: Value) -> Word {
        let bit = self.builder.ins().icmp(condition, a, b);
        Word { value: self.builder.ins().uextend(I64, bit), bits: 1 }
    }

    /// The machine shifts by `amount` modulo 64: an amount that can be more needs a test.
    fn unless_too_far(&mut self, shifted: Value, amount: SignalId) -> Value {
        if self.width(amount) <= 6 {
            return shifted;
        }
        let (amount, limit, zero) = (self.clean(amount), self.constant(64), self.constant(0));
        let near = self.builder.ins().icmp(IntCC::UnsignedLessThan, amount, limit);
        self.builder.ins().select(near, shifted, zero)
    }

    fn case(&mut self, selector: SignalId, arms: &[Arm], default: SignalId) -> Word {
        let selector = self.clean(selector);
        let mut word = self.word(default);
        // Labels are distinct: an arm that is the default needs no test.
        for arm in arms.iter().filter(|arm| arm.value != default) {
            let (label, chosen) = (self.constant(arm.label.value), self.word(arm.value));
            let matches = self.builder.ins().icmp(IntCC::Equal, selector, label);
            let value = self.builder.ins().select(matches, chosen.value, word.value);
            word = Word { value, bits: word.bits.max(chosen.bits) };
        }
        word
    }

    fn concat(&mut self, parts: &[SignalId]) -> Word {
        let pieces = self.pieces(parts);
        let whole: u32 = pieces.iter().map(|piece| piece.width).sum();
        let mut constant = 0;
        let mut word: Option<Word> = None;
        let mut position = 0;
        for piece in &pieces {
            let at = position;
            position += piece.width;
            let part = match piece.from {
                From::Constant(value) => {
                    constant |= value << at;
                    continue;
                }
                From::Bit(bit) => self.replicated(bit, at, piece.width, position == whole),
                From::Bits { source, low } => self.placed(source, low, piece.width, at, position == whole),
            };
            word = Some(match word {
                Some(rest) => {
                    Word { value: self.builder.ins().bor(rest.value, part.value), bits: rest.bits.max(part.bits) }
                }
                None => part,
            });
        }
        let Some(word) = word else {
            return Word { value: self.constant(constant), bits: 64 - constant.leading_zeros() };
        };
        if constant == 0 {
            return word;
        }
        let ones = self.constant(constant);
        let bits = word.bits.max(64 - constant.leading_zeros());
        Word { value: self.builder.ins().bor(word.value, ones), bits }
    }

    /// Parts, least significant first. Adjacent bits of one signal are one part.
    fn pieces(&self, parts: &[SignalId]) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        for &id in parts.iter().rev() {
            let width = self.width(id);
            let from = match self.driver(id) {
                Some(&Driver::Constant(value)) => From::Constant(value),
                Some(&Driver::Slice { source, low }) => From::Bits { source, low },
                _ => From::Bits { source: id, low: 0 },
            };
            let last = pieces.last_mut();
            let Some(last) = last else {
                pieces.push(Piece { from, width });
                continue;
            };
            match (last.from, from) {
                (From::Bits { source: a, low: la }, From::Bits { source: b, low: lb })
                    if a == b && la + last.width == lb =>
                {
                    last.width += width;
                }
                (From::Bits { .. }, From::Bits { .. }) if last.from == from && width == 1 && last.width == 1 => {
                    *last = Piece { from: From::Bit(id), width: 2 };
                }
                (From::Bit(bit), From::Bits { .. }) if bit == id => last.width += 1,
                _ => pieces.push(Piece { from, width }),
            }
        }
        pieces
    }

    /// A bit `width` times, from bit `at` on. Where it is the `top`, with copies above as well.
    fn replicated(&mut self, bit: SignalId, at: u32, width: u32, top: bool) -> Word {
        let ones = match self.driver(bit) {
            Some(&Driver::Slice { source, low }) => {
                let source = self.word(source).value;
                let highest = self.shifted_left(source, 63 - low);
                self.builder.ins().sshr_imm_u(highest, 63)
            }
            _ => {
                let bit = self.clean(bit);
                self.builder.ins().ineg(bit)
            }
        };
        if top {
            return Word { value: self.shifted_left(ones, at), bits: 64 };
        }
        let mask = self.constant(mask(width) << at);
        Word { value: self.builder.ins().band(ones, mask), bits: at + width }
    }

    /// Bits `low` to `low + width - 1` of a signal as bits `at` and above. If they are the `top`, the bits above
    /// them may be undefined.
    fn placed(&mut self, source: SignalId, low: u32, width: u32, at: u32, top: bool) -> Word {
        let word = if low == 0 && width == self.width(source) && !top {
            let value = self.clean(source);
            Word { value, bits: width }
        } else {
            self.word(source)
        };
        let value =
            if at >= low { self.shifted_left(word.value, at - low) } else { self.shifted_right(word.value, low - at) };
        let bits = (word.bits + at).saturating_sub(low).min(64);
        let nothing_below = low == 0 || at == 0;
        if nothing_below && (top || bits <= at + width) {
            return Word { value, bits };
        }
        let bits = at + width;
        let mask = self.constant(mask(width) << at);
        Word { value: self.builder.ins().band(value, mask), bits }
    }

    fn shifted_left(&mut self, value: Value, by: u32) -> Value {
        if by == 0 { value } else { self.builder.ins().ishl_imm_u(value, i64::from(by)) }
    }

    fn shifted_right(&mut self, value: Value, by: u32) -> Value {
        if by == 0 { value } else { self.builder.ins().ushr_imm_u(value, i64::from(by)) }
    }
}

/// A part of a concatenation.
struct Piece {
    from: From,
    width: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum From {
    Constant(u64),
    /// One bit, as often as the piece is wide.
    Bit(SignalId),
    /// Bits of a signal from `low` on.
    Bits {
        source: SignalId,
        low: u32,
    },
}
