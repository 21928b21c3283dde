//! Vectors, lists, graphs and jobs in memory.

use super::distance::{Elements, VectorLayout};
use super::job::SearchJob;
use super::{JOB_BYTES, SEARCH_BLOCK};
use crate::model::{Memory, MemoryError};
use thiserror::Error;

/// A memory that is filled from address 0 on.
#[derive(Debug, Clone, Default)]
pub struct SearchImage {
    bytes: Vec<u8>,
}

/// What does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ImageError {
    /// More than the 4 GiB that a job reaches.
    #[error("{0} bytes, expected at most 4294967296, which a job reaches")]
    Size(u64),
    /// A number that the elements do not have.
    #[error("number {0} of the vectors is not one of their elements: expected a rounded or a scaled one")]
    Element(usize),
    /// A key that is none, or less than the one before.
    #[error("key {0} is NaN or less than the one before, expected keys in ascending order")]
    Order(usize),
}

impl SearchImage {
    /// A memory without contents.
    pub fn new() -> Self {
        Self::default()
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Its bytes, to change those behind the elements of a vector.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Places vectors of so many dimensions, one behind the other with a stride of [`VectorLayout::bytes`], and returns
    /// the address of the first. Numbers are those of the elements: [`Elements::nearest`] rounds to them.
    ///
    /// # Errors
    /// More than 4 GiB; a number that is none of the elements.
    pub fn vectors(&mut self, layout: VectorLayout, numbers: &[f32]) -> Result<u32, ImageError> {
        if let Some(number) = numbers.iter().position(|x| !layout.elements.has(*x)) {
            return Err(ImageError::Element(number));
        }
        let rows = numbers.chunks(layout.dimensions.max(1) as usize);
        let address = self.reserve(rows.len() as u64 * u64::from(layout.bytes()))?;
        let size = layout.elements.bytes() as usize;
        for (row, place) in rows.zip(self.bytes[address as usize..].chunks_mut(layout.bytes() as usize)) {
            for (x, bytes) in row.iter().zip(place.chunks_exact_mut(size)) {
                bytes.copy_from_slice(&layout.elements.encoded(*x)[..size]);
            }
        }
        Ok(address)
    }

    /// Places lists of words, each of `len` words in whole blocks, one behind the other, and returns the address of the
    /// first. A shorter list is filled up with words that name no vector.
    ///
    /// # Errors
    /// More than 4 GiB.
    pub fn lists<'l>(&mut self, len: u32, lists: impl ExactSizeIterator<Item = &'l [u32]>) -> Result<u32, ImageError> {
        let stride = (4 * len).next_multiple_of(SEARCH_BLOCK);
        let address = self.reserve(lists.len() as u64 * u64::from(stride))?;
        for (list, place) in lists.zip(self.bytes[address as usize..].chunks_mut(stride.max(1) as usize)) {
            let words = list.iter().copied().chain(std::iter::repeat(u32::MAX));
            put(place, words);
        }
        Ok(address)
    }

    /// Places a job and returns its address.
    ///
    /// # Errors
    /// More than 4 GiB.
    pub fn job(&mut self, job: &SearchJob) -> Result<u32, ImageError> {
        let address = self.reserve(JOB_BYTES.into())?;
        self.write(address, &job.words());
        Ok(address)
    }

    /// Writes words where there are bytes.
    pub(super) fn write(&mut self, address: u32, words: &[u32]) {
        put(&mut self.bytes[address as usize..], words.iter().copied());
    }

    /// Adds bytes and returns the address of the first.
    pub(super) fn reserve(&mut self, bytes: u64) -> Result<u32, ImageError> {
        let address = self.bytes.len() as u64;
        let end = address + bytes;
        let (Ok(first), true) = (u32::try_from(address), end <= 1 << 32) else { return Err(ImageError::Size(end)) };
        self.bytes.resize(end as usize, 0);
        Ok(first)
    }
}

/// Writes words to a place, until one of them ends.
fn put(place: &mut [u8], words: impl Iterator<Item = u32>) {
    words.zip(place.chunks_exact_mut(4)).for_each(|(word, bytes)| bytes.copy_from_slice(&word.to_le_bytes()));
}

impl Memory for SearchImage {
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError> {
        self.bytes.as_slice().block(address, bytes)
    }
}

impl Elements {
    /// The nearest element, ties to even; of integers the nearest of -128 to 127.
    #[must_use]
    pub fn nearest(self, x: f32) -> f32 {
        match self {
            Self::Binary32 => x,
            Self::Binary16 => half::f16::from_f32(x).to_f32(),
            Self::Int8 { scale } => (x / scale).round_ties_even().clamp(-128.0, 127.0) * scale,
        }
    }

    fn has(self, x: f32) -> bool {
        x.is_nan() || self.nearest(x) == x
    }

    /// The bytes of an element, the first of them.
    fn encoded(self, x: f32) -> [u8; 4] {
        match self {
            Self::Binary32 => x.to_le_bytes(),
            Self::Binary16 => {
                let [a, b] = half::f16::from_f32(x).to_le_bytes();
                [a, b, 0, 0]
            }
            Self::Int8 { scale } => [(x / scale).round_ties_even() as i8 as u8, 0, 0, 0],
        }
    }
}
