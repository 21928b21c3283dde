//! Elastic stages: skid buffers in a row, with ready and valid at both ends.

/// A row of `N` skid buffers. Each holds two items, passes one a cycle, and says from a register whether it is ready:
/// nothing that the sink does is seen by the source in the same cycle.
#[derive(Debug, Clone)]
pub struct Elastic<T, const N: usize> {
    buffers: [SkidBuffer<T>; N],
}

/// What passed at the two ends in one cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer<T> {
    /// The item offered was accepted.
    pub accepted: bool,
    /// The item that the sink took.
    pub output: Option<T>,
}

#[derive(Debug, Clone)]
struct SkidBuffer<T> {
    /// What the next stage sees.
    front: Option<T>,
    /// What arrived while `front` could not leave.
    spare: Option<T>,
}

impl<T, const N: usize> Elastic<T, N> {
    /// An empty pipeline. `N` is at least 1.
    pub fn new() -> Self {
        const { assert!(N > 0, "a pipeline has at least one buffer") };
        Self { buffers: std::array::from_fn(|_| SkidBuffer { front: None, spare: None }) }
    }

    /// Whether an item offered in this cycle will be accepted.
    #[inline]
    pub fn input_ready(&self) -> bool {
        self.buffers[0].is_ready()
    }

    /// What the output shows in this cycle; it stays until the sink takes it.
    #[inline]
    pub fn output(&self) -> Option<&T> {
        self.buffers[N - 1].front.as_ref()
    }

    /// One clock cycle in which the source offers `input` and the sink takes the output if `output_ready`.
    #[inline]
    pub fn cycle(&mut self, input: Option<T>, output_ready: bool) -> Transfer<T> {
        let output = if output_ready { self.buffers[N - 1].front.take() } else { None };
        let input_ready = self.input_ready();
        for i in (1..N).rev() {
            let (before, from_here) = self.buffers.split_at_mut(i);
            let (source, target) = (&mut before[i - 1], &mut from_here[0]);
            // `target` has given away its front already, but is ready only if it was so when the cycle began.
            let item = if target.is_ready() { source.front.take() } else { None };
            target.settle(item);
        }
        let accepted = input_ready && input.is_some();
        self.buffers[0].settle(if input_ready { input } else { None });
        Transfer { accepted, output }
    }

    /// A hardware reset: everything in flight is lost.
    pub fn reset(&mut self) {
        *self = Self::new();
    }
}

impl<T, const N: usize> Default for Elastic<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> SkidBuffer<T> {
    #[inline]
    fn is_ready(&self) -> bool {
        self.spare.is_none()
    }

    /// The clock edge, after `front` may have left.
    #[inline]
    fn settle(&mut self, arriving: Option<T>) {
        if self.front.is_none() {
            self.front = self.spare.take().or(arriving);
        } else if arriving.is_some() {
            self.spare = arriving;
        }
    }
}
