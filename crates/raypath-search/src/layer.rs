use crate::SearchError;

/// The lowest layer of a graph, which has all vectors: a job of the unit searches it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer {
    degree: usize,
    neighbours: Vec<Vec<u32>>,
    entry: u32,
}

/// The most neighbours of a vector in a job.
const MAX_DEGREE: usize = 0xffff;

impl Layer {
    /// A layer in which each vector has at most `degree` neighbours, the indices in `neighbours`. A search begins with
    /// the vector `entry`.
    ///
    /// # Errors
    /// A degree that is not 1 to 65,535; more neighbours than that; an index that names no vector.
    pub fn new(degree: usize, neighbours: Vec<Vec<u32>>, entry: u32) -> Result<Self, SearchError> {
        let refused = |problem: String| Err(SearchError::Parameter(problem));
        if !(1..=MAX_DEGREE).contains(&degree) {
            return refused(format!("{degree} neighbours of a vector, expected 1 to {MAX_DEGREE}"));
        }
        let count = neighbours.len();
        if entry as usize >= count {
            return refused(format!("the search begins with vector {entry}, expected one of {count}"));
        }
        for (index, list) in neighbours.iter().enumerate() {
            if list.len() > degree {
                return refused(format!("vector {index}: {} neighbours, expected at most {degree}", list.len()));
            }
            if let Some(next) = list.iter().find(|next| **next as usize >= count) {
                return refused(format!("vector {index}: neighbour {next}, expected one of {count} vectors"));
            }
        }
        Ok(Self { degree, neighbours, entry })
    }

    /// The most neighbours of a vector.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The neighbours of each vector.
    pub fn neighbours(&self) -> &[Vec<u32>] {
        &self.neighbours
    }

    /// The vector with which a search begins.
    pub fn entry(&self) -> u32 {
        self.entry
    }
}
