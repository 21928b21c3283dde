//! A job of any operation, and the rules that it exercises.

use super::rounded::Rounded;
use crate::layout::Field;
use raypath_rtl::Semantics;
use std::borrow::Cow;

/// A job with the meaning of its words.
#[derive(Clone, Copy)]
pub struct Job<'j> {
    pub name: &'j str,
    pub semantics: Semantics,
    pub fields: &'j [Field],
    pub words: &'j [u64],
}

impl Job<'_> {
    /// The fields with their words.
    pub fn each(&self) -> impl Iterator<Item = (Field, u64)> + '_ {
        self.fields.iter().copied().zip(self.words.iter().copied())
    }

    /// The word of a field, if the job has it.
    pub fn word(&self, wanted: Field) -> Option<u64> {
        self.each().find(|(field, _)| *field == wanted).map(|(_, word)| word)
    }

    /// The number of a field; 0 if the job does not have it.
    pub fn number(&self, wanted: Field) -> f64 {
        self.word(wanted).map_or(0.0, |word| self.rounded().value(word))
    }

    /// The numbers of a vector.
    pub fn vector(&self, field: fn(usize) -> Field) -> [f64; 3] {
        std::array::from_fn(|axis| self.number(field(axis)))
    }

    /// The arithmetic of the job's format.
    pub fn rounded(&self) -> Rounded {
        Rounded(self.semantics.format)
    }
}

/// Something that a job can exercise.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Its name in reports.
    pub name: Cow<'static, str>,
    /// Whether the job exercises it.
    pub is_exercised: bool,
    /// Whether no job of the datapath can.
    pub is_impossible: bool,
}

impl Rule {
    pub fn new(name: impl Into<Cow<'static, str>>, is_exercised: bool) -> Self {
        Self { name: name.into(), is_exercised, is_impossible: false }
    }

    pub fn impossible_if(self, is_impossible: bool) -> Self {
        Self { is_impossible, ..self }
    }
}

/// Rules without conditions on the datapath.
pub fn rules(of: impl IntoIterator<Item = (&'static str, bool)>) -> Vec<Rule> {
    of.into_iter().map(|(name, is_exercised)| Rule::new(name, is_exercised)).collect()
}
