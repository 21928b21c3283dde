use std::num::NonZeroUsize;

/// An evenly spaced subset of numbered items: 0, `stride`, 2 · `stride` and so on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// The distance between two selected items.
    pub stride: NonZeroUsize,
    /// The maximum number of selected items.
    pub max: usize,
}

impl Sample {
    /// All items.
    pub const ALL: Self = Self::first(usize::MAX);

    /// The first `max` items.
    pub const fn first(max: usize) -> Self {
        Self { stride: NonZeroUsize::MIN, max }
    }

    /// At most `max` of `count` items, evenly spaced over all of them; at least one.
    pub fn spread(count: usize, max: usize) -> Self {
        Self { stride: NonZeroUsize::new(count.div_ceil(max.max(1))).unwrap_or(NonZeroUsize::MIN), max: usize::MAX }
    }

    /// The numbers of the selected items among `count`.
    pub fn numbers(self, count: usize) -> impl ExactSizeIterator<Item = usize> + Clone + use<> {
        (0..count).step_by(self.stride.get()).take(self.max)
    }
}
