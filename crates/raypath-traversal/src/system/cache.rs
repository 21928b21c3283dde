//! The cache between units and the memory: the timing of `raypath_cache`, in every cycle.

use std::collections::VecDeque;
use thiserror::Error;

/// A set-associative cache of lines, whose least recently used line is replaced. Requests of a line that is under way
/// wait for it; others go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheParameters {
    /// The number of sets: a power of two from 2 on.
    pub sets: u32,
    /// The lines of a set: 1, 2, 4 or 8.
    pub ways: u32,
    /// The bytes of a line: a block, or 2 or 4 blocks.
    pub line: u32,
    /// The lines that are fetched at a time: a power of two from 2 to 64.
    pub misses: u32,
}

/// The error of a cache that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the cache's {name} is {value}, expected {expected}")]
pub struct CacheError {
    name: &'static str,
    value: u32,
    expected: String,
}

impl CacheParameters {
    /// The cache of so many bytes.
    ///
    /// # Errors
    /// A size that is not that of a power of two of sets, from 2 on.
    pub fn of_bytes(bytes: u32, ways: u32, line: u32, misses: u32) -> Result<Self, CacheError> {
        let set = ways.saturating_mul(line).max(1);
        let sets = bytes / set;
        if !bytes.is_multiple_of(set) || !sets.is_power_of_two() || sets < 2 {
            let expected = format!("{set} bytes times a power of two from 2 on");
            return Err(CacheError { name: "size", value: bytes, expected });
        }
        Ok(Self { sets, ways, line, misses })
    }

    /// Its size in bytes.
    pub fn bytes(self) -> u64 {
        u64::from(self.sets) * u64::from(self.ways) * u64::from(self.line)
    }

    /// Checks the parameters for blocks of so many bytes.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(self, block_bytes: u32) -> Result<(), CacheError> {
        let Self { sets, ways, line, misses } = self;
        let lines = [1, 2, 4].map(|blocks| blocks * block_bytes);
        let is_one =
            |value: u32, range: std::ops::RangeInclusive<u32>| value.is_power_of_two() && range.contains(&value);
        let parameters = [
            ("sets", sets, is_one(sets, 2..=1 << 16), "a power of two from 2 to 65536".to_string()),
            ("ways", ways, is_one(ways, 1..=8), "1, 2, 4 or 8".to_string()),
            ("line", line, lines.contains(&line), format!("{}, {} or {} bytes", lines[0], lines[1], lines[2])),
            ("misses", misses, is_one(misses, 2..=64), "a power of two from 2 to 64".to_string()),
        ];
        let wrong = parameters.into_iter().find(|(_, _, is_right, _)| !is_right);
        wrong.map_or(Ok(()), |(name, value, _, expected)| Err(CacheError { name, value, expected }))
    }
}

/// What a cache did since its last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CacheCounts {
    /// Requests that were answered from a line.
    pub hits: u64,
    /// Requests that waited for a line under way.
    pub merges: u64,
    /// Requests that fetched a line.
    pub misses: u64,
}

impl CacheCounts {
    /// The sums of what two caches did.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { hits: self.hits + other.hits, merges: self.merges + other.merges, misses: self.misses + other.misses }
    }
}

/// Where a beat is stored: the place of its line, and its number there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Stored {
    /// The set and the way.
    pub place: u32,
    /// The beat of the line.
    pub beat: u32,
}

/// A beat that leaves the cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheBeat {
    /// The tag of the request.
    pub tag: u32,
    /// The memory reported an error for the line.
    pub is_error: bool,
    /// Where its data is.
    pub stored: Stored,
}

/// What enters the cache in a cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct CacheEdge {
    /// All lines become invalid.
    pub invalidates: bool,
    /// The address of a block, and the tag of its beats.
    pub request: Option<(u64, u32)>,
    /// The request of a line is taken.
    pub memory_ready: bool,
    /// A beat of a line: the number of the request, and whether it has an error.
    pub beat: Option<(u32, bool)>,
}

/// The timing of a cache. The beats themselves are not in it: it says where they are.
#[derive(Debug, Clone)]
pub struct Cache {
    parameters: CacheParameters,
    /// The beats of a block and of a line.
    beats: u32,
    line_beats: u32,
    /// The lines of each set in the order of their last use, each with its way.
    lines: Vec<(Option<u64>, u32)>,
    look: Option<Look>,
    under_way: Vec<UnderWay>,
    /// The request of a line, and how many reads of hits it waits for.
    request: Option<(u64, u32)>,
    reads_before: u32,
    reads_left: u32,
    clears: bool,
    sweep: u32,
    /// For each requester, the one after it in the list of its line, and the first beat that it wants.
    followers: Vec<u32>,
    first_beats: Vec<u32>,
    filled: Filled,
    walk: Walk,
    walk_miss: usize,
    walk_tag: u32,
    walk_beat: u32,
    follower: u32,
    hits: VecDeque<Read>,
    prefers_hit: bool,
    read: Option<Read>,
    response: Option<CacheBeat>,
    counts: CacheCounts,
}

/// A request in the lookup.
#[derive(Debug, Clone, Copy)]
struct Look {
    tag: u32,
    line: u64,
    beat: u32,
}

/// A line that is fetched, with the list of those who wait for it.
#[derive(Debug, Clone, Copy, Default)]
struct UnderWay {
    is_busy: bool,
    has_error: bool,
    line: u64,
    place: u32,
    head: u32,
    tail: u32,
    beat: u32,
}

/// A block that is read.
#[derive(Debug, Clone, Copy)]
struct Read {
    is_hit: bool,
    stored: Stored,
    /// The beats after this one.
    left: u32,
    tag: u32,
    is_error: bool,
}

/// The lines that have arrived, in `raypath_queue`.
#[derive(Debug, Clone, Default)]
struct Filled {
    waiting: VecDeque<usize>,
    output: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Walk {
    Idle,
    Serve,
    Next,
    Load,
}

/// How a request leaves the lookup.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Leave {
    Stays,
    Merges(usize),
    /// The line is at this place of the order of its set.
    Hits(usize),
    Misses(usize),
}

/// The hits that wait for the store.
const HITS: usize = 4;

impl Cache {
    /// A cache after a reset, of blocks of so many bytes that arrive in beats of so many bits, for requests with tags
    /// below `requesters`.
    pub fn new(parameters: CacheParameters, block_bytes: u32, width: u32, requesters: u32) -> Self {
        let CacheParameters { sets, ways, misses, line } = parameters;
        let mut cache = Self {
            parameters,
            beats: block_bytes * 8 / width,
            line_beats: line * 8 / width,
            lines: vec![(None, 0); (sets * ways) as usize],
            look: None,
            under_way: vec![UnderWay::default(); misses as usize],
            request: None,
            reads_before: 0,
            reads_left: 0,
            clears: true,
            sweep: 0,
            followers: vec![0; requesters as usize],
            first_beats: vec![0; requesters as usize],
            filled: Filled::default(),
            walk: Walk::Idle,
            walk_miss: 0,
            walk_tag: 0,
            walk_beat: 0,
            follower: 0,
            hits: VecDeque::new(),
            prefers_hit: false,
            read: None,
            response: None,
            counts: CacheCounts::default(),
        };
        (0..sets).for_each(|set| cache.clear(set));
        cache
    }

    /// What it did.
    pub fn counts(&self) -> CacheCounts {
        self.counts
    }

    /// Whether a request is taken.
    #[inline]
    pub fn ready(&self) -> bool {
        !self.clears && (self.look.is_none() || self.leave() != Leave::Stays)
    }

    /// The beat at the output.
    #[inline]
    pub fn response(&self) -> Option<CacheBeat> {
        self.response
    }

    /// The request of a line: its address and its number.
    #[inline]
    pub fn request(&self) -> Option<(u64, u32)> {
        let (line, miss) = self.request.filter(|_| self.reads_before == 0)?;
        Some((line * u64::from(self.parameters.line), miss))
    }

    /// Where the next beat of a request is stored.
    pub fn place_of(&self, miss: u32) -> Stored {
        let UnderWay { place, beat, .. } = self.under_way[miss as usize];
        Stored { place, beat }
    }

    /// No request is in it.
    pub fn is_idle(&self) -> bool {
        let is_reading = !self.hits.is_empty() || self.read.is_some() || self.response.is_some();
        self.look.is_none() && !self.is_busy() && !is_reading
    }

    /// A cycle changes nothing if nothing enters.
    #[inline]
    pub fn is_still(&self) -> bool {
        let waits = self.walk == Walk::Idle && self.filled.output.is_none() && self.filled.waiting.is_empty();
        let is_reading = !self.hits.is_empty() || self.read.is_some() || self.response.is_some();
        let moves = self.look.is_some() && self.leave() != Leave::Stays;
        waits && !is_reading && !moves && self.request.is_none() && (!self.clears || self.is_busy())
    }

    /// The clock edge. Each part reads what the parts after it had before the edge.
    pub fn cycle(&mut self, edge: &CacheEdge) {
        let (leave, accepts, requested) = (self.leave(), self.ready(), self.request().is_some());
        let read_ends = self.read.is_some_and(|read| read.left == 0);
        let hit_is_read = read_ends && self.read.is_some_and(|read| read.is_hit);
        let sweeps = self.clears && !self.is_busy();
        let has_error = edge.beat.is_some_and(|(_, is_error)| is_error);

        let takes_walk = self.read_on(read_ends);
        self.walk_on(leave, takes_walk);
        let ended = edge.beat.and_then(|(miss, is_error)| self.arrive(miss as usize, is_error));
        self.filled.waiting.extend(ended);

        // The lookup, and the request of a line.
        if requested && edge.memory_ready {
            self.request = None;
        }
        self.reads_left -= u32::from(hit_is_read);
        self.reads_before = self.reads_before.saturating_sub(hit_is_read.into());
        if let Some(look) = self.look {
            self.leave_as(leave, look);
        }
        if sweeps {
            self.clear(self.sweep);
        }
        let is_swept = sweeps && self.sweep == self.parameters.sets - 1;
        self.sweep = (self.sweep + u32::from(sweeps)) % self.parameters.sets;
        self.clears = edge.invalidates || has_error || (self.clears && !is_swept);
        let entering = edge.request.filter(|_| accepts).map(|(address, tag)| {
            let line = u64::from(self.parameters.line);
            let beat = (address % line) as u32 / (self.parameters.line / self.line_beats);
            Look { tag, line: address / line, beat }
        });
        self.look = entering.or(self.look.filter(|_| leave == Leave::Stays));
    }

    /// How the request in the lookup leaves it.
    fn leave(&self) -> Leave {
        let Some(Look { line, .. }) = self.look else { return Leave::Stays };
        if let Some(miss) = self.under_way.iter().position(|known| known.is_busy && known.line == line) {
            return Leave::Merges(miss);
        }
        if self.clears {
            return Leave::Stays;
        }
        let set = self.set_of(line);
        if let Some(place) = set.iter().position(|(known, _)| *known == Some(line)) {
            return if self.hits.len() < HITS { Leave::Hits(place) } else { Leave::Stays };
        }
        let place = self.place(line, set[set.len() - 1].1);
        let is_used = self.under_way.iter().any(|known| known.is_busy && known.place == place)
            || self.read.is_some_and(|read| read.stored.place == place);
        let free = self.under_way.iter().position(|known| !known.is_busy);
        free.filter(|_| self.request.is_none() && !is_used).map_or(Leave::Stays, Leave::Misses)
    }

    fn leave_as(&mut self, leave: Leave, Look { tag, line, beat }: Look) {
        match leave {
            Leave::Stays => {}
            Leave::Merges(miss) => {
                self.counts.merges += 1;
                let tail = &mut self.under_way[miss].tail;
                self.followers[*tail as usize] = tag;
                *tail = tag;
                self.first_beats[tag as usize] = beat;
            }
            Leave::Hits(place) => {
                self.counts.hits += 1;
                let way = self.use_line(line, place);
                let stored = Stored { place: self.place(line, way), beat };
                self.hits.push_back(Read { is_hit: true, stored, left: self.beats - 1, tag, is_error: false });
                self.reads_left += 1;
            }
            Leave::Misses(miss) => {
                self.counts.misses += 1;
                let way = self.use_line(line, self.parameters.ways as usize - 1);
                let place = self.place(line, way);
                self.under_way[miss] =
                    UnderWay { is_busy: true, line, place, head: tag, tail: tag, ..UnderWay::default() };
                self.first_beats[tag as usize] = beat;
                self.request = Some((line, miss as u32));
                self.reads_before = self.reads_left;
            }
        }
    }

    /// Reads the store. Returns whether it begins with a block of the list.
    fn read_on(&mut self, read_ends: bool) -> bool {
        self.response = self.read.map(|Read { stored, tag, is_error, .. }| CacheBeat { tag, is_error, stored });
        let is_free = self.read.is_none() || read_ends;
        let takes_walk = self.walk == Walk::Serve && is_free && (self.hits.is_empty() || !self.prefers_hit);
        let UnderWay { place, has_error, .. } = self.under_way[self.walk_miss];
        let stored = Stored { place, beat: self.walk_beat };
        let of_walk = Read { is_hit: false, stored, left: self.beats - 1, tag: self.walk_tag, is_error: has_error };
        let next = match is_free {
            true if takes_walk => Some(of_walk),
            true => self.hits.pop_front(),
            false => None,
        };
        if next.is_some() {
            self.prefers_hit = takes_walk;
        }
        let goes_on = self.read.filter(|_| !read_ends).map(|read| {
            let Stored { place, beat } = read.stored;
            Read { stored: Stored { place, beat: beat + 1 }, left: read.left - 1, ..read }
        });
        self.read = next.or(goes_on);
        takes_walk
    }

    /// Answers the lists of lines that have arrived.
    fn walk_on(&mut self, leave: Leave, takes_walk: bool) {
        let begun = self.filled.edge(self.walk == Walk::Idle);
        self.walk = match self.walk {
            Walk::Idle => match begun {
                Some(miss) => {
                    (self.walk_miss, self.walk_tag) = (miss, self.under_way[miss].head);
                    self.walk_beat = self.first_beats[self.walk_tag as usize];
                    Walk::Serve
                }
                None => Walk::Idle,
            },
            Walk::Serve if takes_walk => Walk::Next,
            Walk::Serve => Walk::Serve,
            Walk::Next if self.walk_tag != self.under_way[self.walk_miss].tail => {
                self.follower = self.followers[self.walk_tag as usize];
                Walk::Load
            }
            Walk::Next if leave == Leave::Merges(self.walk_miss) => Walk::Next,
            Walk::Next => {
                self.under_way[self.walk_miss].is_busy = false;
                Walk::Idle
            }
            Walk::Load => {
                self.walk_tag = self.follower;
                self.walk_beat = self.first_beats[self.walk_tag as usize];
                Walk::Serve
            }
        };
    }

    /// A beat of a line arrives. Returns the line if it is complete.
    fn arrive(&mut self, miss: usize, is_error: bool) -> Option<usize> {
        let line = &mut self.under_way[miss];
        line.has_error |= is_error;
        line.beat = (line.beat + 1) % self.line_beats;
        (line.beat == 0).then_some(miss)
    }

    fn is_busy(&self) -> bool {
        self.under_way.iter().any(|line| line.is_busy)
    }

    /// The line at this place of the order of its set moves to the front, or gives its way to a new one. Returns the
    /// way.
    fn use_line(&mut self, line: u64, place: usize) -> u32 {
        let (ways, first) = (self.parameters.ways as usize, self.first_of(line));
        let set = &mut self.lines[first..first + ways];
        set[..=place].rotate_right(1);
        set[0].0 = Some(line);
        set[0].1
    }

    fn clear(&mut self, set: u32) {
        let ways = self.parameters.ways;
        let first = (set * ways) as usize;
        let lines = self.lines[first..].iter_mut().zip(0..ways);
        lines.for_each(|(line, way)| *line = (None, way));
    }

    /// The number of the first line of the set in which a line is.
    fn first_of(&self, line: u64) -> usize {
        (line as u32 & (self.parameters.sets - 1)) as usize * self.parameters.ways as usize
    }

    fn set_of(&self, line: u64) -> &[(Option<u64>, u32)] {
        let first = self.first_of(line);
        &self.lines[first..first + self.parameters.ways as usize]
    }

    fn place(&self, line: u64, way: u32) -> u32 {
        (line as u32 & (self.parameters.sets - 1)) * self.parameters.ways.max(2) + way
    }
}

impl Filled {
    /// The clock edge. Returns the line at the output if it leaves.
    fn edge(&mut self, leaves: bool) -> Option<usize> {
        let left = self.output.filter(|_| leaves);
        if self.output.is_none() || leaves {
            self.output = self.waiting.pop_front();
        }
        left
    }
}
