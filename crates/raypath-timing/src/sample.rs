use std::num::NonZeroUsize;

/// Which of many things become agents: those numbered 0, `every`, 2 · `every` and so on. The agent that begins as number
/// n, counted from 0, is thing number n · `every`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// From one to the next.
    pub every: NonZeroUsize,
    /// How many at most.
    pub most: usize,
}

impl Sample {
    /// All of them.
    pub const ALL: Self = Self::first(usize::MAX);

    /// The first so many.
    pub const fn first(most: usize) -> Self {
        Self { every: NonZeroUsize::MIN, most }
    }

    /// At most about `most` of `count`, evenly spread.
    pub fn spread(count: usize, most: usize) -> Self {
        Self { every: NonZeroUsize::new(count.div_ceil(most.max(1))).unwrap_or(NonZeroUsize::MIN), most: usize::MAX }
    }

    /// The numbers of the sample below `count`.
    pub fn numbers(self, count: usize) -> impl ExactSizeIterator<Item = usize> + Clone + use<> {
        (0..count).step_by(self.every.get()).take(self.most)
    }
}
