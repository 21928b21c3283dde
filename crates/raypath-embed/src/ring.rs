use crate::job::{Outcome, Tagged};
use raypath_model::{State, StateWords, Words};
use std::collections::VecDeque;

/// The outcomes of the jobs inside a pipeline, oldest first, in a ring. An outcome stays in its place until another
/// takes it, so that the one that left last can still be read.
#[derive(Clone)]
pub struct Ring {
    /// A power of two.
    places: Box<[Tagged]>,
    first: usize,
    len: usize,
    /// The words of the outcomes that are [`Outcome::Words`], oldest first.
    words: VecDeque<Words>,
    /// The words of the last such outcome that left.
    left_words: Option<Words>,
}

impl Ring {
    /// An empty ring for at least `capacity` jobs.
    pub fn new(capacity: usize) -> Self {
        let empty = Tagged { tag: 0, outcome: Outcome::Timing(0) };
        let places = vec![empty; capacity.next_power_of_two()].into();
        Self { places, first: 0, len: 0, words: VecDeque::new(), left_words: None }
    }

    /// The number of jobs.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Adds a job with a tag, and returns the place of its outcome, which the caller sets.
    #[inline(always)]
    pub fn push(&mut self, tag: u64) -> &mut Outcome {
        let place = self.place(self.first + self.len);
        self.len += 1;
        let Tagged { tag: own, outcome } = &mut self.places[place];
        *own = tag;
        outcome
    }

    /// Keeps the words of the job that was added last.
    pub fn push_words(&mut self, words: Words) {
        self.words.push_back(words);
    }

    /// Removes the oldest job, of which there must be one. Returns its outcome.
    #[inline(always)]
    pub fn pop(&mut self) -> &Tagged {
        let place = self.place(self.first);
        self.first = self.place(self.first + 1);
        self.len -= 1;
        if matches!(self.places[place].outcome, Outcome::Words(_)) {
            self.left_words = self.words.pop_front();
        }
        &self.places[place]
    }

    /// The outcome of the oldest job, and its words if it is [`Outcome::Words`].
    pub fn front(&self) -> (&Tagged, Option<&Words>) {
        let tagged = &self.places[self.place(self.first)];
        (tagged, self.words.front().filter(|_| matches!(tagged.outcome, Outcome::Words(_))))
    }

    /// The words of the last [`Outcome::Words`] that left.
    pub fn left_words(&self) -> Option<&Words> {
        self.left_words.as_ref()
    }

    /// Removes all jobs.
    pub fn clear(&mut self) {
        (self.first, self.len, self.left_words) = (0, 0, None);
        self.words.clear();
    }

    /// Passes the jobs inside. `words_of` makes the words of an operation's outcome.
    pub fn pass(&mut self, words: &mut StateWords<'_>, words_of: impl Fn(u64, &[u64]) -> Option<Words>) {
        let mut count = self.len;
        count.pass(words);
        if count > self.places.len() {
            return words.refuse();
        }
        (self.len, self.left_words) = (count, None);
        let kept = std::mem::take(&mut self.words);
        let mut kept = kept.iter();
        for index in 0..count {
            let place = self.place(self.first + index);
            let Tagged { tag, outcome } = &mut self.places[place];
            tag.pass(words);
            outcome.pass(words);
            if let Outcome::Words(opcode) = *outcome {
                let mut list = kept.next().map_or(Vec::new(), |kept| kept.as_words().to_vec());
                words.many(&mut list);
                match words_of(opcode, &list) {
                    Some(found) => self.words.push_back(found),
                    None => return words.refuse(),
                }
            }
        }
    }

    #[inline(always)]
    fn place(&self, index: usize) -> usize {
        index & (self.places.len() - 1)
    }
}
