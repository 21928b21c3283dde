//! The timing of the unit's parts, each as the module of the same name in `hardware` has it.

use std::collections::VecDeque;

/// A queue in a memory with a word at the output.
#[derive(Debug, Clone)]
pub struct Queue<T> {
    /// The words, the next first.
    words: VecDeque<T>,
    /// The first word is at the output.
    valid: bool,
}

impl<T> Queue<T> {
    pub fn new() -> Self {
        Self { words: VecDeque::new(), valid: false }
    }

    /// The word at the output.
    #[inline]
    pub fn front(&self) -> Option<&T> {
        if self.valid { self.words.front() } else { None }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Whether an edge without words that enter or leave changes nothing.
    #[inline]
    pub fn is_settled(&self) -> bool {
        self.valid || self.words.is_empty()
    }

    /// The clock edge: the word at the output leaves if `pop`, and `push` enters.
    #[inline]
    pub fn edge(&mut self, push: Option<T>, pop: bool) {
        let pop = pop && self.valid;
        if pop {
            self.words.pop_front();
        }
        // A word that enters now is read at the next edge.
        self.valid = !self.words.is_empty();
        if let Some(word) = push {
            self.words.push_back(word);
        }
    }

    pub fn clear(&mut self) {
        *self = Self::new();
    }
}

/// A pipeline of up to 64 stages that all stop while the last waits.
#[derive(Debug, Clone)]
pub struct Line<T> {
    /// Bit i: stage i has an item.
    occupied: u64,
    last: u64,
    /// The items, oldest first.
    items: VecDeque<T>,
}

impl<T> Line<T> {
    pub fn new(stages: u32) -> Self {
        Self { occupied: 0, last: 1 << (stages - 1), items: VecDeque::new() }
    }

    /// The item in the last stage.
    #[inline]
    pub fn front(&self) -> Option<&T> {
        if self.occupied & self.last != 0 { self.items.front() } else { None }
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.occupied == 0
    }

    /// A clock edge at which the line moves: the last item leaves, and `item` enters.
    #[inline]
    pub fn advance(&mut self, item: Option<T>) -> Option<T> {
        let leaves = if self.occupied & self.last != 0 { self.items.pop_front() } else { None };
        self.occupied = (self.occupied & !self.last) << 1 | u64::from(item.is_some());
        self.items.extend(item);
        leaves
    }

    pub fn clear(&mut self) {
        self.occupied = 0;
        self.items.clear();
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
