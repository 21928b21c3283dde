//! The timing of the unit's parts, each as the module of the same name in `hardware` has it.

/// The places of a [`Ring`]: more than the contexts of a unit, and more than the jobs in a datapath.
const PLACES: u32 = 512;

/// Items in a circle, oldest first.
#[derive(Debug, Clone)]
pub struct Ring<T> {
    items: [T; PLACES as usize],
    /// The numbers of items that have entered and left, modulo 2^32.
    entered: u32,
    left: u32,
}

impl<T: Copy + Default> Ring<T> {
    /// No items.
    pub fn new() -> Self {
        Self { items: [T::default(); PLACES as usize], entered: 0, left: 0 }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.entered == self.left
    }

    /// The oldest item. An empty ring has an arbitrary one.
    #[inline]
    pub fn first(&self) -> T {
        self.items[(self.left % PLACES) as usize]
    }

    /// Removes the oldest item.
    #[inline]
    pub fn pop(&mut self) -> T {
        let first = self.first();
        self.left = self.left.wrapping_add(1);
        first
    }

    #[inline]
    pub fn push(&mut self, item: T) {
        self.items[(self.entered % PLACES) as usize] = item;
        self.entered = self.entered.wrapping_add(1);
    }

    pub fn clear(&mut self) {
        (self.entered, self.left) = (0, 0);
    }
}

/// The queues of contexts, each in a memory with a word at the output. They have numbers from 0. In a cycle, a queue is
/// popped before it is pushed.
#[derive(Debug, Clone)]
pub struct Queues<const N: usize> {
    queues: [Ring<u8>; N],
    /// A bit for each queue: it has a word at the output.
    ready: u32,
    /// The queues that were pushed in the last cycle. Their words are not yet at the output.
    arrived: u32,
    /// The queues that were pushed in this cycle.
    pushed: u32,
}

impl<const N: usize> Queues<N> {
    /// Empty queues.
    pub fn new() -> Self {
        Self { queues: std::array::from_fn(|_| Ring::new()), ready: 0, arrived: 0, pushed: 0 }
    }

    /// A bit for each queue: it has a word at the output.
    #[inline]
    pub fn ready(&self) -> u32 {
        self.ready
    }

    /// The word at the output of a queue.
    #[inline]
    pub fn front(&self, queue: usize) -> Option<u8> {
        (self.ready >> queue & 1 == 1).then(|| self.queues[queue].first())
    }

    /// Whether an edge changes nothing.
    #[inline]
    pub fn are_settled(&self) -> bool {
        self.arrived == 0
    }

    /// The word at the output leaves.
    #[inline]
    pub fn pop(&mut self, queue: usize) -> u8 {
        let word = self.queues[queue].pop();
        self.ready &= !(u32::from(self.queues[queue].is_empty()) << queue);
        word
    }

    /// A word enters.
    #[inline]
    pub fn push(&mut self, queue: usize, word: u8) {
        self.queues[queue].push(word);
        self.pushed |= 1 << queue;
    }

    /// The clock edge.
    #[inline]
    pub fn edge(&mut self) {
        self.ready |= self.arrived;
        self.arrived = std::mem::take(&mut self.pushed);
    }

    pub fn clear(&mut self) {
        self.queues.iter_mut().for_each(Ring::clear);
        (self.ready, self.arrived, self.pushed) = (0, 0, 0);
    }
}

/// A pipeline of up to 64 stages that all stop while the last waits.
#[derive(Debug, Clone)]
pub struct Line<T> {
    /// Bit i: stage i has an item.
    occupied: u64,
    last: u64,
    items: Ring<T>,
}

impl<T: Copy + Default> Line<T> {
    pub fn new(stages: u32) -> Self {
        Self { occupied: 0, last: 1 << (stages - 1), items: Ring::new() }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.occupied == 0
    }

    /// The item in the last stage.
    #[inline]
    pub fn front(&self) -> Option<T> {
        (self.occupied & self.last != 0).then(|| self.items.first())
    }

    /// A clock edge at which the line moves: `item` enters, and the last item leaves.
    #[inline]
    pub fn advance(&mut self, item: Option<T>) -> Option<T> {
        let leaves = (self.occupied & self.last != 0).then(|| self.items.pop());
        self.occupied = (self.occupied & !self.last) << 1 | u64::from(item.is_some());
        if let Some(item) = item {
            self.items.push(item);
        }
        leaves
    }

    pub fn clear(&mut self) {
        self.occupied = 0;
        self.items.clear();
    }
}

/// The two divisions for the barycentric coordinates of each hit.
#[derive(Debug, Clone)]
pub struct Weights {
    /// The context whose operands enter the divider, and whether the next is the second.
    reading: Option<(u8, bool)>,
    operands: Option<(u8, bool)>,
    divider: Line<(u8, bool)>,
}

impl Weights {
    pub fn new(divider_latency: u32) -> Self {
        Self { reading: None, operands: None, divider: Line::new(divider_latency) }
    }

    /// The context whose weights are there.
    #[inline]
    pub fn front(&self) -> Option<u8> {
        self.divider.front().filter(|(_, is_second)| *is_second).map(|(context, _)| context)
    }

    pub fn is_empty(&self) -> bool {
        self.reading.is_none() && self.operands.is_none() && self.divider.is_empty()
    }

    /// The clock edge: `waiting` is taken if possible, and the weights at the front are if `ready`. Returns whether
    /// `waiting` was taken.
    #[inline]
    pub fn edge(&mut self, waiting: Option<u8>, ready: bool) -> bool {
        let moves = self.front().is_none() || ready;
        let divided = if moves { self.operands.take() } else { None };
        let enters = self.reading.filter(|_| self.operands.is_none());
        if moves {
            self.divider.advance(divided);
        }
        self.operands = enters.or(self.operands);
        let ends = enters.is_some_and(|(_, is_second)| is_second);
        let takes = waiting.is_some() && (self.reading.is_none() || ends);
        self.reading = match (waiting.filter(|_| takes), self.reading) {
            (Some(context), _) => Some((context, false)),
            (None, _) if ends => None,
            (None, Some((context, _))) if enters.is_some() => Some((context, true)),
            (None, reading) => reading,
        };
        takes
    }

    pub fn clear(&mut self) {
        (self.reading, self.operands) = (None, None);
        self.divider.clear();
    }
}

/// The arbiter of the sources of answers: the first requested source after the one that was granted last.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scheduler {
    after: u32,
}

impl Scheduler {
    /// Grants a source of at least one, and advances by a cycle.
    #[inline]
    pub fn grant(&mut self, request: u32) -> u32 {
        let later = request & self.after;
        let from = if later != 0 { later } else { request };
        let grant = from & from.wrapping_neg();
        self.after = !(grant | (grant - 1));
        grant
    }
}
