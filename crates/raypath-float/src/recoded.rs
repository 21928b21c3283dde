//! Taking a recoded number apart, and putting a result together.

use crate::Format;
use raypath_hdl::{Builder, Wire};

/// Exponent and fraction of a recoded number. As words, magnitudes of finite numbers are in the order of their values.
#[derive(Clone, Copy)]
pub(crate) struct Magnitude<'m> {
    /// Exponent, then fraction.
    pub word: Wire<'m>,
    format: Format,
}

impl<'m> Magnitude<'m> {
    pub fn of(format: Format, number: Wire<'m>) -> Self {
        Self { word: number.lower(format.recoded_width() - 1), format }
    }

    pub fn exponent(self) -> Wire<'m> {
        self.word.upper(self.format.exponent() + 1)
    }

    pub fn fraction(self) -> Wire<'m> {
        self.word.lower(self.format.fraction_width())
    }

    /// The fraction with its hidden bit; zero for zero, whose fraction the format says is zero.
    pub fn significand(self) -> Wire<'m> {
        self.word.builder().concat(&[!self.is_zero(), self.fraction()])
    }

    pub fn is_zero(self) -> Wire<'m> {
        self.word.upper(3).is(0b000)
    }

    pub fn is_infinite(self) -> Wire<'m> {
        self.word.upper(3).is(0b110)
    }

    pub fn is_nan(self) -> Wire<'m> {
        self.word.upper(3).is(0b111)
    }
}

/// A result before it is brought into canonical form. Of the three flags, the first that is set counts.
pub(crate) struct Outcome<'m> {
    pub nan: Wire<'m>,
    pub infinite: Wire<'m>,
    pub zero: Wire<'m>,
    pub sign: Wire<'m>,
    pub exponent: Wire<'m>,
    pub fraction: Wire<'m>,
}

impl<'m> Outcome<'m> {
    /// The canonical recoded number.
    pub fn pack(self, m: &'m Builder) -> Wire<'m> {
        let special = (self.nan | self.infinite).named("special");
        let ordinary = (!(special | self.zero)).named("ordinary");
        let class = m.concat(&[special, special, self.nan, m.constant(self.exponent.width() - 3, 0)]);
        let nan_fraction = m.concat(&[self.nan, m.constant(self.fraction.width() - 1, 0)]);
        m.concat(&[
            (self.sign & !self.nan).named("result_sign"),
            ordinary.mux(self.exponent, class).named("result_exponent"),
            ordinary.mux(self.fraction, nan_fraction).named("result_fraction"),
        ])
    }
}
