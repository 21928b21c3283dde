//! A cache before the memory.

use thiserror::Error;

/// A set-associative cache whose least recently used line is replaced. Several misses of one line at a time count as
/// one: the others are hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheParameters {
    /// Its size in bytes: a multiple of `ways` lines.
    pub bytes: u32,
    /// The lines of a set.
    pub ways: u32,
    /// The bytes of a line: a power of two from 32 to 4096.
    pub line: u32,
    /// Cycles from the acceptance of a request to the first beat, at least 1.
    pub hit_latency: u64,
}

/// The error of a cache that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CacheError {
    /// The size of a line.
    #[error("lines of {0} bytes, expected a power of two from 32 to 4096")]
    Line(u32),
    /// The size.
    #[error("a cache of {bytes} bytes with {ways} ways of {line} bytes, expected a multiple of {expected} bytes")]
    Size {
        /// Its bytes.
        bytes: u32,
        /// Its ways.
        ways: u32,
        /// The bytes of a line.
        line: u32,
        /// The bytes of a set.
        expected: u64,
    },
    /// The latency.
    #[error("a hit latency of 0 cycles, expected at least 1")]
    Latency,
}

impl CacheParameters {
    /// Checks the parameters.
    ///
    /// # Errors
    /// A line that is not a power of two from 32 to 4096 bytes; a size that is not a multiple of a set; a latency of 0.
    pub fn check(self) -> Result<(), CacheError> {
        let Self { bytes, ways, line, hit_latency } = self;
        if !line.is_power_of_two() || !(32..=4096).contains(&line) {
            return Err(CacheError::Line(line));
        }
        let expected = u64::from(ways) * u64::from(line);
        if expected == 0 || bytes == 0 || !u64::from(bytes).is_multiple_of(expected) {
            return Err(CacheError::Size { bytes, ways, line, expected });
        }
        if hit_latency == 0 { Err(CacheError::Latency) } else { Ok(()) }
    }
}

/// The state of a cache.
pub(super) struct Cache {
    parameters: CacheParameters,
    /// For each set, the numbers of its lines, the one that was used last first.
    sets: Vec<Vec<u64>>,
    hits: u64,
    misses: u64,
}

impl Cache {
    pub fn new(parameters: CacheParameters) -> Self {
        let sets = parameters.bytes / (parameters.ways * parameters.line).max(1);
        Self { parameters, sets: vec![Vec::new(); sets.max(1) as usize], hits: 0, misses: 0 }
    }

    /// The bytes of a line, and the latency of a hit.
    pub fn line(&self) -> (u32, u64) {
        (self.parameters.line, self.parameters.hit_latency)
    }

    /// Requests that it had, and that it did not have.
    pub fn counts(&self) -> (u64, u64) {
        (self.hits, self.misses)
    }

    /// Reads the block of so many bytes at an address. Returns the number of lines that must be fetched.
    pub fn misses(&mut self, address: u64, bytes: u32) -> u32 {
        let CacheParameters { ways, line, .. } = self.parameters;
        let line = u64::from(line);
        let last = address.saturating_add(u64::from(bytes) - 1) / line;
        let mut missing = 0;
        for number in address / line..=last {
            let place = number as usize % self.sets.len();
            let set = &mut self.sets[place];
            match set.iter().position(|known| *known == number) {
                Some(way) => set[..=way].rotate_right(1),
                None => {
                    missing += 1;
                    set.truncate(ways as usize - 1);
                    set.insert(0, number);
                }
            }
        }
        if missing == 0 {
            self.hits += 1
        } else {
            self.misses += 1
        }
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_that_was_not_used_for_longest_leaves() {
        let parameters = CacheParameters { bytes: 1024, ways: 2, line: 128, hit_latency: 1 };
        let mut cache = Cache::new(parameters);
        // Four sets: these blocks are all in set 0.
        let [a, b, c] = [0, 512, 1024];
        assert_eq!([a, b, a, c, a, b].map(|address| cache.misses(address, 128)), [1, 1, 0, 1, 0, 1]);
        assert_eq!(cache.counts(), (2, 4));
        // Short lines: a block has two.
        let mut cache = Cache::new(CacheParameters { line: 64, ..parameters });
        assert_eq!([0, 128, 0].map(|address| cache.misses(address, 128)), [2, 2, 0]);
        // A long line has two blocks.
        let mut cache = Cache::new(CacheParameters { line: 256, ..parameters });
        assert_eq!([0, 128, 256].map(|address| cache.misses(address, 128)), [1, 0, 1]);
    }

    #[test]
    fn impossible_caches_are_errors() {
        let good = CacheParameters { bytes: 1024, ways: 2, line: 128, hit_latency: 1 };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(CacheParameters { line: 100, ..good }.check(), Err(CacheError::Line(100)));
        assert!(CacheParameters { bytes: 1000, ..good }.check().is_err_and(|e| e.to_string().contains("1000 bytes")));
        assert!(CacheParameters { ways: 0, ..good }.check().is_err());
        assert_eq!(CacheParameters { hit_latency: 0, ..good }.check(), Err(CacheError::Latency));
    }
}
