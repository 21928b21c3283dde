//! The fields of a recoded number.

use crate::Format;
use crate::units::constants::Class;
use raypath_hdl::Wire;

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

    pub fn is_zero(self) -> Wire<'m> {
        self.is(Class::Zero)
    }

    pub fn is_infinite(self) -> Wire<'m> {
        self.is(Class::Infinity)
    }

    pub fn is_nan(self) -> Wire<'m> {
        self.is(Class::Nan)
    }

    fn is(self, class: Class) -> Wire<'m> {
        self.word.upper(3).equals(class.wire(self.word.builder()))
    }
}
