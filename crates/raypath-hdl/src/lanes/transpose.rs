//! Conversion between one number for each lane and one slice for each bit.

/// Bits of a word, and words of a slice.
const WORD: usize = 32;
const WORDS: usize = LANES / WORD;

/// The number of stimuli that a [`LaneSimulator`](crate::LaneSimulator) simulates at once. A slice then fills a cache
/// line, and the widest SIMD register.
pub const LANES: usize = 512;

/// The same bit of every lane: lane `l` is bit `l / WORDS` of word `l % WORDS`. Neighbouring lanes are in neighbouring
/// words, so a transposition works on all words in parallel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub struct Slice(pub [u32; WORDS]);

impl Slice {
    pub const ZEROS: Self = Self([0; WORDS]);
    pub const ONES: Self = Self([u32::MAX; WORDS]);
}

type Block = [[u32; WORDS]; WORD];

/// Stores bits `0` to `slices.len() - 1` of each lane's value.
#[inline(always)]
pub fn to_slices(values: &[u64; LANES], slices: &mut [Slice]) {
    for (half, slices) in slices.chunks_mut(WORD).enumerate() {
        let size = slices.len().next_power_of_two();
        let mask = u32::MAX >> (WORD - size);
        let mut block: Block = [[0; WORDS]; WORD];
        // Rows that are narrower than a word share it.
        for (row, values) in values.as_chunks::<WORDS>().0.iter().enumerate() {
            let (row, shift) = (row % size, row / size * size);
            for (word, &value) in block[row].iter_mut().zip(values) {
                *word |= ((value >> (half * WORD)) as u32 & mask) << shift;
            }
        }
        transpose(&mut block, size);
        for (slice, row) in slices.iter_mut().zip(block) {
            *slice = Slice(row);
        }
    }
}

/// Each lane's value, of bits in order of significance.
#[inline(always)]
pub fn from_slices(bits: &[Slice]) -> [u64; LANES] {
    let mut all = [0; LANES];
    for (half, bits) in bits.chunks(WORD).enumerate() {
        let size = bits.len().next_power_of_two();
        let mask = u32::MAX >> (WORD - size);
        let mut block: Block = [[0; WORDS]; WORD];
        for (row, slice) in block.iter_mut().zip(bits) {
            *row = slice.0;
        }
        transpose(&mut block, size);
        for (row, values) in all.as_chunks_mut::<WORDS>().0.iter_mut().enumerate() {
            let (row, shift) = (row % size, row / size * size);
            for (&word, value) in block[row].iter().zip(values) {
                *value |= u64::from(word >> shift & mask) << (half * WORD);
            }
        }
    }
    all
}

/// Transposes the adjacent squares of `size` rows and `size` bits, a power of two, by exchanging halves, then halves of
/// halves.
#[inline(always)]
fn transpose(block: &mut Block, size: usize) {
    let mut step = size / 2;
    while step > 0 {
        // The bits whose position lacks the bit `step`.
        let mask = u32::MAX / ((1 << step) + 1);
        for row in (0..size).filter(|row| row & step == 0) {
            let (above, below) = block.split_at_mut(row + step);
            for (low, high) in above[row].iter_mut().zip(&mut below[0]) {
                let differ = ((*low >> step) ^ *high) & mask;
                *low ^= differ << step;
                *high ^= differ;
            }
        }
        step /= 2;
    }
}
