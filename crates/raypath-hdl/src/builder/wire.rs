//! Wires, registers and forward wires, and the operations on them.

use super::{Builder, Undriven, describe};
use crate::netlist::{Driver, Item, RegisterInfo, SignalId, fits, gate_instance, gated_clock};
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Not, Sub};

/// A signal of the module that `Builder` builds: a small copyable handle with operators.
#[derive(Clone, Copy)]
pub struct Wire<'m> {
    pub(super) builder: &'m Builder,
    pub(super) id: SignalId,
}

impl PartialEq for Wire<'_> {
    /// Whether both are the same signal of the same module.
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.builder, other.builder) && self.id == other.id
    }
}

/// A register whose next value is still to be given.
#[derive(Clone, Copy)]
pub struct Register<'m> {
    pub(super) wire: Wire<'m>,
    pub(super) index: usize,
}

/// A wire that is read before it is driven, for paths that run backwards.
#[derive(Clone, Copy)]
pub struct Forward<'m> {
    pub(super) wire: Wire<'m>,
}

/// A driver of two operands.
type Binary = fn(SignalId, SignalId) -> Driver;

impl<'m> Wire<'m> {
    /// The builder of the module that it belongs to.
    pub fn builder(self) -> &'m Builder {
        self.builder
    }

    /// Its width in bits.
    pub fn width(self) -> u32 {
        self.builder.state.borrow().module.signals[self.id.index()].width
    }

    /// The same value under a name, which the text uses.
    pub fn named(self, name: &str) -> Self {
        self.builder.claim(name);
        let taken = self.builder.state.borrow().module.signals[self.id.index()].name.is_some();
        let wire = if taken { self.builder.push(self.width(), Driver::Alias(self.id)) } else { self };
        self.builder.name(wire, name);
        self.builder.item(Item::Signal(wire.id));
        wire
    }

    /// Says what the value is: its name in the text, where an expression without a name needs one.
    pub fn hint(self, name: &str) -> Self {
        let signals = &mut self.builder.state.borrow_mut().module.signals;
        signals[self.id.index()].hint.get_or_insert_with(|| name.to_string());
        self
    }

    /// Adds a remark, which the text has beside the signal.
    pub fn comment(self, remark: impl Into<String>) -> Self {
        self.builder.state.borrow_mut().module.signals[self.id.index()].comment = Some(remark.into());
        self
    }

    /// One bit of it.
    pub fn bit(self, index: u32) -> Self {
        self.bits(index, index)
    }

    /// Bits `high` down to `low`, both included.
    pub fn bits(self, high: u32, low: u32) -> Self {
        let width = self.width();
        if high < low || high >= width {
            self.builder.fail_width(self.id, format!("bits [{high}:{low}] of {width}"));
            return self;
        }
        if low == 0 && high + 1 == width {
            return self;
        }
        self.builder.push_simplified(high - low + 1, Driver::Slice { source: self.id, low })
    }

    /// Its most significant bit.
    pub fn top(self) -> Self {
        self.bit(self.width() - 1)
    }

    /// Its `n` most significant bits.
    pub fn upper(self, n: u32) -> Self {
        let width = self.width();
        if n == 0 || n > width {
            self.builder.fail_width(self.id, format!("{n} upper bits of {width}"));
            return self;
        }
        self.bits(width - 1, width - n)
    }

    /// Its `n` least significant bits.
    pub fn lower(self, n: u32) -> Self {
        if n == 0 {
            self.builder.fail_width(self.id, "no lower bits".to_string());
            return self;
        }
        self.bits(n - 1, 0)
    }

    /// Extended with zeros to `width` bits.
    pub fn extend(self, width: u32) -> Self {
        let own = self.width();
        if width < own {
            self.builder.fail_width(self.id, format!("{own} bits extended to {width}"));
        }
        if width <= own { self } else { self.builder.concat(&[self.builder.constant(width - own, 0), self]) }
    }

    /// One bit: equal to `other`.
    pub fn equals(self, other: Self) -> Self {
        self.compare(other, Driver::Equal)
    }

    /// One bit: equal to a constant.
    pub fn is(self, value: u64) -> Self {
        self.equals(self.builder.constant(self.width(), value))
    }

    /// One bit: less than `other`, unsigned.
    pub fn less(self, other: Self) -> Self {
        self.compare(other, Driver::Less)
    }

    /// One bit: any bit is set.
    pub fn any(self) -> Self {
        if self.width() == 1 { self } else { self.builder.push(1, Driver::Any(self.id)) }
    }

    /// One bit: every bit is set.
    pub fn all(self) -> Self {
        if self.width() == 1 { self } else { self.builder.push(1, Driver::All(self.id)) }
    }

    /// Shifted left by `amount`, of 32 bits at most; zeros enter.
    pub fn shift_left(self, amount: Self) -> Self {
        self.shift(amount, Driver::ShiftLeft)
    }

    /// Shifted right by `amount`, of 32 bits at most; zeros enter.
    pub fn shift_right(self, amount: Self) -> Self {
        self.shift(amount, Driver::ShiftRight)
    }

    /// `self ? if_true : if_false`; `self` has one bit.
    pub fn mux(self, if_true: Self, if_false: Self) -> Self {
        let (yes, no) = (self.builder.own(if_true), self.builder.own(if_false));
        let driver = Driver::Mux { select: self.id, if_true: yes, if_false: no };
        let wire = self.builder.push_simplified(if_true.width(), driver);
        self.builder.expect_width(wire.id, self.width(), 1);
        self.builder.expect_width(wire.id, if_false.width(), if_true.width());
        wire
    }

    /// The value of this number, of at least one, by a tree of multiplexers. Numbers without a value select any.
    pub fn select(self, values: &[Self]) -> Self {
        let (mut layer, mut bit) = (values.to_vec(), 0);
        while layer.len() > 1 {
            let upper = self.bit(bit);
            let one = |pair: &[Self]| if let [low, high] = *pair { upper.mux(high, low) } else { pair[0] };
            layer = layer.chunks(2).map(one).collect();
            bit += 1;
        }
        layer[0]
    }

    /// `width` copies of this one bit.
    pub fn replicate(self, width: u32) -> Self {
        self.builder.expect_width(self.id, self.width(), 1);
        if width > 64 {
            self.builder.fail_width(self.id, format!("{width} copies, expected 1 to 64"));
            return self;
        }
        self.builder.concat(&vec![self; width as usize])
    }

    fn compare(self, other: Self, driver: Binary) -> Self {
        let wire = self.binary(1, other, driver);
        self.builder.expect_width(wire.id, other.width(), self.width());
        wire
    }

    fn same_width(self, other: Self, driver: Binary) -> Self {
        let wire = self.binary(self.width(), other, driver);
        self.builder.expect_width(wire.id, other.width(), self.width());
        wire
    }

    fn shift(self, amount: Self, driver: Binary) -> Self {
        let wire = self.binary(self.width(), amount, driver);
        // Verilator rejects a wider constant amount, and folds other expressions to constants.
        if amount.width() > 32 {
            self.builder.fail_width(wire.id, format!("shift amount of {} bits, expected 1 to 32", amount.width()));
        }
        wire
    }

    fn binary(self, width: u32, other: Self, driver: Binary) -> Self {
        self.builder.push_simplified(width, driver(self.id, self.builder.own(other)))
    }
}

impl<'m> Register<'m> {
    /// Its value.
    pub fn wire(self) -> Wire<'m> {
        self.wire
    }

    /// Gives it a value that it has while `rst_ni` is 0.
    pub fn reset_to(self, value: u64) -> Self {
        self.info(|info| info.reset = Some(value));
        if !fits(self.wire.width(), value) {
            self.wire.builder.fail_width(self.wire.id, format!("reset value {value} does not fit"));
        }
        self
    }

    /// Takes `next` at every edge.
    pub fn next(self, next: Wire<'m>) {
        self.wire.builder.drive(Undriven::Signal(self.wire.id));
        self.wire.builder.expect_width(self.wire.id, next.width(), self.wire.width());
        let next = self.wire.builder.own(next);
        self.info(|info| info.next = next);
    }

    /// Takes `next` at edges where `enable` is 1.
    pub fn next_when(self, enable: Wire<'m>, next: Wire<'m>) {
        self.next(next);
        self.wire.builder.expect_width(self.wire.id, enable.width(), 1);
        let enable = self.wire.builder.own(enable);
        self.info(|info| info.enable = Some(enable));
    }

    /// Takes `next` at edges where `enable` is 1; the text has a clock gate for it. `enable` must have a name, from
    /// which the names of the gate and its clock are made.
    pub fn next_gated(self, enable: Wire<'m>, next: Wire<'m>) {
        self.next_when(enable, next);
        let builder = self.wire.builder;
        let (name, known) = {
            let module = &builder.state.borrow().module;
            let name = module.signals[enable.id.index()].name.clone();
            let known = name.as_deref().is_some_and(|name| module.gates().any(|gate| gate == name));
            (name, known)
        };
        match name {
            None => {
                let signal = describe(&builder.state.borrow().module, enable.id);
                builder.fail_drive(&signal, "gates a clock, expected a name");
            }
            Some(name) if !known => {
                [gated_clock(&name), gate_instance(&name)].iter().for_each(|name| builder.claim(name))
            }
            Some(_) => {}
        }
        self.info(|info| info.gated = true);
    }

    fn info(self, change: impl FnOnce(&mut RegisterInfo)) {
        change(&mut self.wire.builder.state.borrow_mut().module.registers[self.index]);
    }
}

impl<'m> Forward<'m> {
    /// Its value.
    pub fn wire(self) -> Wire<'m> {
        self.wire
    }

    /// Drives it.
    pub fn drive(self, wire: Wire<'m>) {
        self.wire.builder.drive(Undriven::Signal(self.wire.id));
        self.wire.builder.expect_width(self.wire.id, wire.width(), self.wire.width());
        let driver = Driver::Alias(self.wire.builder.own(wire));
        self.wire.builder.state.borrow_mut().module.signals[self.wire.id.index()].driver = driver;
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $driver:ident) => {
        impl<'m> $trait for Wire<'m> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.same_width(other, Driver::$driver)
            }
        }
    };
}

operator!(Add, add, Add);
operator!(Sub, sub, Sub);
operator!(BitAnd, bitand, And);
operator!(BitOr, bitor, Or);
operator!(BitXor, bitxor, Xor);

/// Unsigned; the product is as wide as both factors together.
impl Mul for Wire<'_> {
    type Output = Self;
    #[expect(clippy::suspicious_arithmetic_impl, reason = "the widths add up")]
    fn mul(self, other: Self) -> Self {
        self.binary(self.width() + other.width(), other, Driver::Mul)
    }
}

impl Not for Wire<'_> {
    type Output = Self;
    fn not(self) -> Self {
        self.builder.push_simplified(self.width(), Driver::Not(self.id))
    }
}
