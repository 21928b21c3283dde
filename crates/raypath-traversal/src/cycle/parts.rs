//! The timing of the unit's parts, each as the module of the same name in `hardware` has it.

use crate::instance::TRANSFORM_OPCODE;
use crate::walk::Asked;
use raypath_model::{State, StateWords, state};
use raypath_ops::JobKind;

/// Up to `N` items in a circle, oldest first. `N` is a power of two, 256 or more.
#[derive(Debug, Clone)]
pub struct Ring<T, const N: usize> {
    items: [T; N],
    /// The numbers of items that have entered and left, modulo 2^32.
    entered: u32,
    left: u32,
}

impl<T: Copy + Default, const N: usize> Ring<T, N> {
    /// No items.
    pub fn new() -> Self {
        Self { items: [T::default(); N], entered: 0, left: 0 }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.entered == self.left
    }

    /// The number of items.
    #[inline]
    pub fn count(&self) -> u32 {
        self.entered.wrapping_sub(self.left)
    }

    /// The oldest item. An empty ring has an arbitrary one.
    #[inline]
    pub fn first(&self) -> T {
        self.items[self.left as usize % N]
    }

    /// The items, oldest first.
    pub fn items(&self) -> impl Iterator<Item = T> + '_ {
        (0..self.count()).map(|place| self.items[self.left.wrapping_add(place) as usize % N])
    }

    /// Removes the oldest item if `leaves`. Returns it in any case.
    #[inline]
    pub fn pop_if(&mut self, leaves: bool) -> T {
        let first = self.first();
        self.left = self.left.wrapping_add(leaves.into());
        first
    }

    /// `item` enters if `enters`.
    #[inline]
    pub fn push_if(&mut self, item: T, enters: bool) {
        // The place of an item that does not enter is free, because a ring is never full before an item is offered.
        self.items[self.entered as usize % N] = item;
        self.entered = self.entered.wrapping_add(enters.into());
    }

    pub fn clear(&mut self) {
        (self.entered, self.left) = (0, 0);
    }
}

impl<T: State + Copy + Default, const N: usize> State for Ring<T, N> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let mut count = self.count();
        count.pass(words);
        if count as usize > N {
            return words.refuse();
        }
        let first = self.left as usize;
        (0..count as usize).for_each(|place| self.items[(first + place) % N].pass(words));
        self.entered = self.left.wrapping_add(count);
    }
}

impl<const N: usize> State for Queues<N> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { queues, ready, arrived, pushed } = self;
        queues.pass(words);
        [ready, arrived, pushed].into_iter().for_each(|bits| bits.pass(words));
    }
}

impl<T: State + Copy + Default> State for Line<T> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.occupied.pass(words);
        self.items.pass(words);
    }
}

state! {
    Weights { reading, operands, divider }
    Scheduler { after }
    Job { context, kind }
}

impl State for Kind {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(
            self,
            &[
                Self::Node,
                Self::Triangle,
                Self::LastTriangle,
                Self::Origin,
                Self::Direction,
                Self::Half,
                Self::Beat,
                Self::LastBeat,
                Self::Test,
            ],
        );
    }
}

/// The queues of contexts, each in a memory with a word at the output. They have numbers from 0. In a cycle, a queue is
/// popped before it is pushed.
#[derive(Debug, Clone)]
pub struct Queues<const N: usize> {
    /// Each has a place more than there are contexts.
    queues: [Ring<u8, 512>; N],
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

    /// Whether a queue has a word at the output.
    #[inline]
    pub fn is_ready(&self, queue: usize) -> bool {
        self.ready >> queue & 1 == 1
    }

    /// The word at the output of a queue.
    #[inline]
    pub fn front(&self, queue: usize) -> Option<u8> {
        self.is_ready(queue).then(|| self.queues[queue].first())
    }

    /// The words of a queue, also those that are not yet at the output.
    #[inline]
    pub fn count(&self, queue: usize) -> u32 {
        self.queues[queue].count()
    }

    /// Whether a queue has each word, also one that is not yet at the output.
    pub fn has(&self, queue: usize) -> [bool; 256] {
        let mut has = [false; 256];
        self.queues[queue].items().for_each(|word| has[usize::from(word)] = true);
        has
    }

    /// Whether an edge changes nothing.
    #[inline]
    pub fn are_settled(&self) -> bool {
        self.arrived == 0
    }

    /// The word at the output leaves.
    #[inline]
    pub fn pop(&mut self, queue: usize) -> u8 {
        self.pop_if(queue, true)
    }

    /// As [`pop`](Self::pop), if `leaves`. Otherwise nothing changes, and the word is arbitrary.
    #[inline]
    pub fn pop_if(&mut self, queue: usize, leaves: bool) -> u8 {
        let word = self.queues[queue].pop_if(leaves);
        self.ready &= !(u32::from(self.queues[queue].is_empty()) << queue);
        word
    }

    /// A word enters.
    #[inline]
    pub fn push(&mut self, queue: usize, word: u8) {
        self.push_if(queue, word, true);
    }

    /// A word enters if `enters`.
    #[inline]
    pub fn push_if(&mut self, queue: usize, word: u8, enters: bool) {
        self.queues[queue].push_if(word, enters);
        self.pushed |= u32::from(enters) << queue;
    }

    /// A word enters an empty queue, and is at the output in the next cycle.
    #[inline]
    pub fn put(&mut self, queue: usize, word: u8) {
        self.queues[queue].push_if(word, true);
        self.ready |= 1 << queue;
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
    /// The top bit is the last stage, `first` the first.
    occupied: u64,
    first: u32,
    items: Ring<T, 256>,
}

impl<T: Copy + Default> Line<T> {
    pub fn new(stages: u32) -> Self {
        Self { occupied: 0, first: u64::BITS - stages, items: Ring::new() }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.occupied == 0
    }

    /// Whether the last stage has an item.
    #[inline]
    pub fn has_last(&self) -> bool {
        self.occupied >> (u64::BITS - 1) == 1
    }

    /// The item that is, or will be, in the last stage first. An empty line has an arbitrary one.
    #[inline]
    pub fn first(&self) -> T {
        self.items.first()
    }

    /// The item in the last stage.
    #[inline]
    pub fn front(&self) -> Option<T> {
        self.has_last().then(|| self.first())
    }

    /// A clock edge at which the line moves: `item` enters, and the last item leaves.
    #[inline]
    pub fn advance(&mut self, item: Option<T>) -> Option<T> {
        let leaves = self.has_last();
        let last = self.advance_if(item.unwrap_or_default(), item.is_some());
        leaves.then_some(last)
    }

    /// As [`advance`](Self::advance), but `item` enters only if `enters`. Returns the item in the last stage, or an
    /// arbitrary one if [`has_last`](Self::has_last) was false.
    #[inline]
    pub fn advance_if(&mut self, item: T, enters: bool) -> T {
        let last = self.items.pop_if(self.has_last());
        self.occupied = self.occupied << 1 | u64::from(enters) << self.first;
        self.items.push_if(item, enters);
        last
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
    /// Grants a source, and advances by a cycle. Returns 0 if there is none.
    #[inline]
    pub fn grant(&mut self, request: u32) -> u32 {
        let later = request & self.after;
        let from = if later != 0 { later } else { request };
        let grant = from & from.wrapping_neg();
        self.after = if grant == 0 { self.after } else { !(grant | (grant.wrapping_sub(1))) };
        grant
    }
}

/// A job of a context.
#[derive(Debug, Clone, Copy, Default)]
pub struct Job {
    pub context: u8,
    pub kind: Kind,
}

/// The kinds of jobs. An instance has a job for the ray's origin and one for its direction, and a node with eight
/// children one for its first half and one that is as that of any node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    #[default]
    Node,
    Triangle,
    LastTriangle,
    Origin,
    Direction,
    Half,
    /// A beat of a vector, its last, and a node of a tree of searches.
    Beat,
    LastBeat,
    Test,
}

impl Kind {
    /// The number of kinds.
    pub const COUNT: usize = 9;

    /// The opcode in the datapath.
    #[inline]
    pub fn opcode(self) -> u64 {
        match self {
            Self::Node | Self::Half => JobKind::Quadbox.opcode(),
            Self::Triangle | Self::LastTriangle => JobKind::Triangle.opcode(),
            Self::Origin | Self::Direction => TRANSFORM_OPCODE,
            // An angular beat or a node has another one, which only its offer tells.
            Self::Beat | Self::LastBeat | Self::Test => JobKind::Euclidean.opcode(),
        }
    }

    /// The kind of the first job of a block.
    #[inline]
    pub fn first(asked: Asked, has_eight: bool) -> Self {
        // The number of jobs is 0 to 3, where 0 is a node, and then one with eight children.
        const OF_BLOCK: [Kind; 5] = [Kind::Node, Kind::LastTriangle, Kind::Triangle, Kind::Triangle, Kind::Half];
        let count = usize::from(asked.count) % 4;
        let place = if count == 0 && has_eight { 4 } else { count };
        if asked.is_instance { Self::Origin } else { OF_BLOCK[place] }
    }

    /// The kind of the job after one of this kind, which is the last of its block if `is_last`.
    #[inline]
    pub fn next(self, is_last: bool) -> Self {
        const AFTER_TRIANGLE: [Kind; 2] = [Kind::Triangle, Kind::LastTriangle];
        match self {
            Self::Origin => Self::Direction,
            Self::Half => Self::Node,
            _ => AFTER_TRIANGLE[usize::from(is_last)],
        }
    }

    /// Whether it is a job of a triangle.
    #[inline]
    pub fn is_triangle(self) -> bool {
        matches!(self, Self::Triangle | Self::LastTriangle)
    }

    /// Whether its outcome is taken where those of triangles and of directions may be.
    #[inline]
    pub fn is_taken(self, takes_triangle: bool, takes_direction: bool) -> bool {
        let taken = 1 << Self::Node as u32
            | 1 << Self::Half as u32
            | 1 << Self::Origin as u32
            | 1 << Self::Beat as u32
            | 1 << Self::LastBeat as u32
            | 1 << Self::Test as u32
            | u32::from(takes_triangle) << Self::Triangle as u32
            | u32::from(takes_triangle) << Self::LastTriangle as u32
            | u32::from(takes_direction) << Self::Direction as u32;
        taken >> self as u32 & 1 == 1
    }
}
