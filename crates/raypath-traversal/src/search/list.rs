//! The best candidates of a search, in order.

/// A candidate. Of two, the one of the lower rank is better, and of equal ranks the one of the lower index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Not NaN.
    pub rank: f32,
    pub index: u32,
    /// Its neighbours have been read.
    pub is_expanded: bool,
}

/// The best of the candidates that were offered, each index once.
#[derive(Debug, Clone)]
pub struct BestList {
    candidates: Vec<Candidate>,
    most: usize,
}

impl BestList {
    pub fn new(most: u32) -> Self {
        Self { candidates: Vec::with_capacity(most as usize), most: most as usize }
    }

    /// Adds a candidate, unless it is there or as many better ones are. The last one leaves a list that is full.
    ///
    /// A candidate that is offered again changes nothing: it is in the list, or so many better ones are that it left.
    pub fn offer(&mut self, candidate: Candidate) {
        // Zeros of both signs are equal.
        let is_better = |other: &Candidate| (other.rank, other.index) < (candidate.rank, candidate.index);
        let place = self.candidates.partition_point(is_better);
        let is_there = self.candidates.get(place).is_some_and(|other| other.index == candidate.index);
        if !is_there && place < self.most {
            self.candidates.truncate(self.most - 1);
            self.candidates.insert(place, candidate);
        }
    }

    /// Marks the best candidate whose neighbours were not read, and returns its index.
    pub fn expand(&mut self) -> Option<u32> {
        let next = self.candidates.iter_mut().find(|candidate| !candidate.is_expanded)?;
        next.is_expanded = true;
        Some(next.index)
    }

    pub fn into_best(self, count: u32) -> impl Iterator<Item = Candidate> {
        self.candidates.into_iter().take(count as usize)
    }
}
