//! Saving and restoring the state of models, word by word.

use raypath_ops::{Binary32, Bundle, from_words, to_words};
use std::collections::VecDeque;
use std::mem::take;

/// What changes from cycle to cycle in a model. A model that was made for the same configuration can take it over.
pub trait State {
    /// Passes each word of the state, always in the same order.
    fn pass(&mut self, words: &mut StateWords<'_>);
}

/// Receives the words of a state to save them, or replaces them by saved ones.
pub struct StateWords<'w>(Way<'w>);

enum Way<'w> {
    Save(Vec<u64>),
    Restore(&'w [u64]),
    /// The saved words are not those of such a state.
    Wrong,
}

/// The words of a state.
pub fn saved_state(state: &(impl State + Clone)) -> Vec<u64> {
    let mut words = StateWords(Way::Save(Vec::new()));
    state.clone().pass(&mut words);
    if let Way::Save(words) = words.0 { words } else { Vec::new() }
}

/// Replaces a state by a saved one. Returns false, and changes nothing, if the words are not those of such a state.
#[must_use]
pub fn restore_state(state: &mut (impl State + Clone), words: &[u64]) -> bool {
    let (mut next, mut words) = (state.clone(), StateWords(Way::Restore(words)));
    next.pass(&mut words);
    let is_whole = matches!(words.0, Way::Restore([]));
    if is_whole {
        *state = next;
    }
    is_whole
}

impl StateWords<'_> {
    /// Passes a word.
    pub fn word(&mut self, word: &mut u64) {
        match &mut self.0 {
            Way::Save(words) => words.push(*word),
            Way::Restore(left) => match left.split_first() {
                Some((first, rest)) => (*word, *left) = (*first, rest),
                None => self.refuse(),
            },
            Way::Wrong => {}
        }
    }

    /// The saved words are not those of such a state.
    pub fn refuse(&mut self) {
        self.0 = Way::Wrong;
    }

    /// Passes an item of a table.
    pub fn one_of<T: Copy + PartialEq>(&mut self, item: &mut T, table: &[T]) {
        let mut place = table.iter().position(|other| other == item).unwrap_or(0) as u64;
        self.word(&mut place);
        match table.get(place as usize) {
            Some(found) => *item = *found,
            None => self.refuse(),
        }
    }

    /// Passes items, of which a state can have more or fewer.
    pub fn many<T: State + Default>(&mut self, items: &mut Vec<T>) {
        let mut count = items.len() as u64;
        self.word(&mut count);
        if let Way::Restore(left) = &self.0 {
            match usize::try_from(count).ok().filter(|count| *count <= left.len()) {
                Some(count) => *items = std::iter::repeat_with(T::default).take(count).collect(),
                None => return self.refuse(),
            }
        }
        items.iter_mut().for_each(|item| item.pass(self));
    }

    /// Passes the values of a bundle.
    pub fn bundle<B: Bundle<Binary32>>(&mut self, bundle: &mut B) {
        let mut words = Vec::new();
        to_words(bundle, &mut words);
        words.iter_mut().for_each(|word| self.word(word));
        *bundle = from_words(Binary32, &words);
    }
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl State for $type {
            fn pass(&mut self, words: &mut StateWords<'_>) {
                let mut word = *self as u64;
                words.word(&mut word);
                match Self::try_from(word) {
                    Ok(number) => *self = number,
                    Err(_) => words.refuse(),
                }
            }
        }
    )*};
}
numbers!(u8, u32, u64, usize);

impl State for u128 {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let mut halves = [*self as u64, (*self >> 64) as u64];
        halves.pass(words);
        *self = u128::from(halves[0]) | u128::from(halves[1]) << 64;
    }
}

impl State for bool {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(self, &[false, true]);
    }
}

impl State for f32 {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let mut bits = self.to_bits();
        bits.pass(words);
        *self = Self::from_bits(bits);
    }
}

impl<T: State> State for Vec<T> {
    /// As many items as there are.
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.as_mut_slice().pass(words);
    }
}

impl<T: State + Default> State for VecDeque<T> {
    /// A queue can have more or fewer items.
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let mut items = Vec::from(take(self));
        words.many(&mut items);
        *self = items.into();
    }
}

impl<T: State> State for [T] {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.iter_mut().for_each(|item| item.pass(words));
    }
}

impl<T: State, const N: usize> State for [T; N] {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.as_mut_slice().pass(words);
    }
}

impl State for () {
    /// Nothing; a word, so that a queue of them has as many words as items.
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.word(&mut 0);
    }
}

impl<A: State, B: State> State for (A, B) {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.0.pass(words);
        self.1.pass(words);
    }
}

impl<T: State + Default> State for Option<T> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let (mut is_some, mut value) = (self.is_some(), take(self).unwrap_or_default());
        is_some.pass(words);
        if is_some {
            value.pass(words);
        }
        *self = is_some.then_some(value);
    }
}

/// Implements [`State`] for structures by the fields that change, and, after a bar, optional parts that are there or
/// not for each configuration.
#[macro_export]
macro_rules! state {
    ($($type:ty { $($field:ident),* $(| $($part:ident),*)? })*) => {$(
        impl $crate::State for $type {
            fn pass(&mut self, words: &mut $crate::StateWords<'_>) {
                $($crate::State::pass(&mut self.$field, words);)*
                $($($crate::State::pass(self.$part.as_mut_slice(), words);)*)?
            }
        }
    )*};
}
