//! Simplification while a module is built, so that no gate has a constant operand and no inverter follows another.

use super::Builder;
use crate::netlist::{Driver, SignalId, mask};

/// What replaces a driver.
pub(super) enum Simplified {
    /// A signal that exists.
    Signal(SignalId),
    /// A driver, which may be the one given.
    Driver(Driver),
}

use Simplified::Signal;

impl Builder {
    /// A simpler driver with the same value, or a signal that already has it. Operands of unequal widths are an error,
    /// which the caller reports; they are left as they are.
    pub(super) fn simplify(&self, width: u32, driver: Driver) -> Simplified {
        let kept = Simplified::Driver;
        let ones = if (1..=64).contains(&width) { mask(width) } else { return kept(driver) };
        let fits = |id: SignalId| self.width_of(id) == width;
        match driver {
            Driver::Not(a) => match self.driver_of(a) {
                Driver::Not(inner) if !self.is_named(a) => Signal(inner),
                Driver::Constant(value) => kept(Driver::Constant(!value & ones)),
                _ => kept(Driver::Not(a)),
            },
            Driver::And(a, b) | Driver::Or(a, b) if fits(a) && fits(b) => {
                let (dominant, neutral) = if matches!(driver, Driver::And(..)) { (0, ones) } else { (ones, 0) };
                match [a, b].map(|operand| self.constant_of(operand)) {
                    [Some(value), _] if value == dominant => Signal(a),
                    [_, Some(value)] if value == dominant => Signal(b),
                    [Some(value), _] if value == neutral => Signal(b),
                    [_, Some(value)] if value == neutral => Signal(a),
                    _ if a == b => Signal(a),
                    _ => kept(driver),
                }
            }
            Driver::Xor(a, b) if fits(a) && fits(b) => match (self.constant_of(a), self.constant_of(b)) {
                (Some(0), _) => Signal(b),
                (_, Some(0)) => Signal(a),
                (Some(value), _) if value == ones => self.simplify(width, Driver::Not(b)),
                (_, Some(value)) if value == ones => self.simplify(width, Driver::Not(a)),
                _ => kept(Driver::Xor(a, b)),
            },
            Driver::Mux { select, if_true, if_false }
                if self.width_of(select) == 1 && fits(if_true) && fits(if_false) =>
            {
                self.simplify_mux(width, select, if_true, if_false)
            }
            Driver::Equal(a, b) if self.width_of(a) == 1 && self.width_of(b) == 1 => match self.constant_of(b) {
                Some(0) => self.simplify(1, Driver::Not(a)),
                Some(_) => Signal(a),
                None => kept(Driver::Equal(a, b)),
            },
            Driver::Equal(a, b) | Driver::Less(a, b) if self.width_of(a) == self.width_of(b) => {
                let is_less = matches!(driver, Driver::Less(..));
                match (self.constant_of(a), self.constant_of(b)) {
                    (Some(a), Some(b)) => kept(Driver::Constant(u64::from(if is_less { a < b } else { a == b }))),
                    _ => kept(driver),
                }
            }
            Driver::Slice { source, low } => match self.driver_of(source) {
                Driver::Constant(value) => kept(Driver::Constant(value >> low & ones)),
                _ => kept(Driver::Slice { source, low }),
            },
            Driver::Concat(parts) => kept(Driver::Concat(self.join_constants(parts))),
            other => kept(other),
        }
    }

    fn simplify_mux(&self, width: u32, select: SignalId, if_true: SignalId, if_false: SignalId) -> Simplified {
        match self.constant_of(select) {
            Some(0) => return Signal(if_false),
            Some(_) => return Signal(if_true),
            None if if_true == if_false => return Signal(if_true),
            None => {}
        }
        let (of_true, of_false) = (self.constant_of(if_true), self.constant_of(if_false));
        if of_true.is_some() && of_true == of_false {
            return Signal(if_true);
        }
        let unchanged = Simplified::Driver(Driver::Mux { select, if_true, if_false });
        if width != 1 {
            return unchanged;
        }
        let not = |id| self.push(1, Driver::Not(id)).id;
        match (of_true, of_false) {
            (Some(1), Some(_)) => Signal(select),
            (Some(_), Some(_)) => self.simplify(1, Driver::Not(select)),
            (Some(1), None) => Simplified::Driver(Driver::Or(select, if_false)),
            (Some(_), None) => Simplified::Driver(Driver::And(not(select), if_false)),
            (None, Some(0)) => Simplified::Driver(Driver::And(select, if_true)),
            (None, Some(_)) => Simplified::Driver(Driver::Or(not(select), if_true)),
            _ if self.driver_of(if_true) == Driver::Not(if_false) => Simplified::Driver(Driver::Xor(select, if_false)),
            _ if self.driver_of(if_false) == Driver::Not(if_true) => {
                let differ = self.push(1, Driver::Xor(select, if_true));
                Simplified::Driver(Driver::Not(differ.id))
            }
            _ => unchanged,
        }
    }

    /// Neighbouring constants as one.
    fn join_constants(&self, parts: Vec<SignalId>) -> Vec<SignalId> {
        let mut joined: Vec<SignalId> = Vec::with_capacity(parts.len());
        for part in parts {
            let before = joined.last().copied();
            let pair = before.and_then(|before| Some((before, self.constant_of(before)?, self.constant_of(part)?)));
            match pair {
                Some((before, high, low)) if self.width_of(before) + self.width_of(part) <= 64 => {
                    let width = self.width_of(part);
                    let value = (high << (width % 64)) | low;
                    let constant = self.push(self.width_of(before) + width, Driver::Constant(value));
                    joined.pop();
                    joined.push(constant.id);
                }
                _ => joined.push(part),
            }
        }
        joined
    }

    fn driver_of(&self, id: SignalId) -> Driver {
        self.state.borrow().module.signals[id.index()].driver.clone()
    }

    fn is_named(&self, id: SignalId) -> bool {
        self.state.borrow().module.signals[id.index()].name.is_some()
    }

    fn width_of(&self, id: SignalId) -> u32 {
        self.state.borrow().module.signals[id.index()].width
    }

    /// The value of a constant without a name; a forward wire has a name, and is one only until it is driven.
    fn constant_of(&self, id: SignalId) -> Option<u64> {
        let state = self.state.borrow();
        let signal = &state.module.signals[id.index()];
        match signal.driver {
            Driver::Constant(value) if signal.name.is_none() => Some(value),
            _ => None,
        }
    }
}
