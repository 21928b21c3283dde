//! The timing of the unit's parts, each as the module of the same name in `hardware` has it.

/// Words in a circle, oldest first.
#[derive(Debug, Clone)]
struct Ring<T> {
    /// A power of two.
    words: Box<[T]>,
    first: usize,
    count: usize,
}

impl<T: Copy + Default> Ring<T> {
    fn new(capacity: usize) -> Self {
        Self { words: vec![T::default(); capacity.next_power_of_two()].into(), first: 0, count: 0 }
    }

    #[inline]
    fn front(&self) -> Option<T> {
        let word = self.words.get(self.first).copied();
        word.filter(|_| self.count > 0)
    }

    #[inline]
    fn pop(&mut self) {
        self.first = (self.first + 1) & (self.words.len() - 1);
        self.count -= 1;
    }

    #[inline]
    fn push(&mut self, word: T) {
        let place = (self.first + self.count) & (self.words.len() - 1);
        self.words[place] = word;
        self.count += 1;
    }
}

/// A queue in a memory with a word at the output.
#[derive(Debug, Clone)]
pub struct Queue<T> {
    ring: Ring<T>,
    /// The first word is at the output.
    valid: bool,
}

impl<T: Copy + Default> Queue<T> {
    /// An empty queue of `capacity` words.
    pub fn new(capacity: u32) -> Self {
        Self { ring: Ring::new(capacity as usize), valid: false }
    }

    /// The word at the output.
    #[inline]
    pub fn front(&self) -> Option<T> {
        self.ring.front().filter(|_| self.valid)
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ring.count == 0
    }

    /// Whether an edge without words that enter or leave changes nothing.
    #[inline]
    pub fn is_settled(&self) -> bool {
        self.valid || self.ring.count == 0
    }

    /// The clock edge: the word at the output leaves if `pop`, and `push` enters.
    #[inline]
    pub fn edge(&mut self, push: Option<T>, pop: bool) {
        if pop && self.valid {
            self.ring.pop();
        }
        // A word that enters now is read at the next edge.
        self.valid = self.ring.count > 0;
        if let Some(word) = push {
            self.ring.push(word);
        }
    }

    pub fn clear(&mut self) {
        (self.ring.first, self.ring.count, self.valid) = (0, 0, false);
    }
}

/// The jobs in the datapath, oldest first.
#[derive(Debug, Clone)]
pub struct InOrder<T>(Ring<T>);

impl<T: Copy + Default> InOrder<T> {
    /// No jobs, of at most `capacity`.
    pub fn new(capacity: usize) -> Self {
        Self(Ring::new(capacity))
    }

    #[inline]
    pub fn front(&self) -> Option<T> {
        self.0.front()
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.count == 0
    }

    #[inline]
    pub fn edge(&mut self, push: Option<T>, pop: bool) {
        if pop {
            self.0.pop();
        }
        if let Some(job) = push {
            self.0.push(job);
        }
    }

    pub fn clear(&mut self) {
        (self.0.first, self.0.count) = (0, 0);
    }
}

/// A pipeline of up to 64 stages that all stop while the last waits.
#[derive(Debug, Clone)]
pub struct Line<T> {
    /// Bit i: stage i has an item.
    occupied: u64,
    last: u64,
    /// The items, oldest first.
    items: Ring<T>,
}

impl<T: Copy + Default> Line<T> {
    pub fn new(stages: u32) -> Self {
        Self { occupied: 0, last: 1 << (stages - 1), items: Ring::new(stages as usize) }
    }

    /// The item in the last stage.
    #[inline]
    pub fn front(&self) -> Option<T> {
        self.items.front().filter(|_| self.occupied & self.last != 0)
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.occupied == 0
    }

    /// A clock edge at which the line moves: the last item leaves, and `item` enters.
    #[inline]
    pub fn advance(&mut self, item: Option<T>) {
        if self.occupied & self.last != 0 {
            self.items.pop();
        }
        self.occupied = (self.occupied & !self.last) << 1 | u64::from(item.is_some());
        if let Some(item) = item {
            self.items.push(item);
        }
    }

    pub fn clear(&mut self) {
        (self.occupied, self.items.first, self.items.count) = (0, 0, 0);
    }
}

/// The two divisions for the barycentric coordinates of each hit.
#[derive(Debug, Clone)]
pub struct Weights {
    /// The context whose operands enter the divider, and whether the next is the second.
    reading: Option<(u32, bool)>,
    operands: Option<(u32, bool)>,
    divider: Line<(u32, bool)>,
}

impl Weights {
    pub fn new(divider_latency: u32) -> Self {
        Self { reading: None, operands: None, divider: Line::new(divider_latency) }
    }

    /// The context whose weights are there.
    #[inline]
    pub fn front(&self) -> Option<u32> {
        self.divider.front().filter(|(_, is_second)| *is_second).map(|(context, _)| context)
    }

    pub fn is_empty(&self) -> bool {
        self.reading.is_none() && self.operands.is_none() && self.divider.is_empty()
    }

    /// The clock edge: `waiting` is taken if possible, and the weights at the front are if `ready`. Returns whether
    /// `waiting` was taken.
    #[inline]
    pub fn edge(&mut self, waiting: Option<u32>, ready: bool) -> bool {
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
    /// The source that is granted.
    #[inline]
    pub fn grant(self, request: u32) -> u32 {
        let later = request & self.after;
        let from = if later != 0 { later } else { request };
        from & from.wrapping_neg()
    }

    /// The clock edge after a grant.
    #[inline]
    pub fn edge(&mut self, grant: u32) {
        if grant != 0 {
            self.after = !(grant | (grant - 1));
        }
    }
}
