//! The functional model of a search.

use super::distance::{self, Sums};
use super::job::{Place, SearchJob, SearchMetric};
use super::list::{BestList, Candidate};
use super::parameters::SearchParameters;
use super::rank::{distance_of, rank_of};
use super::tree::{BRANCHES, Branch, NODE_BYTES};
use super::{JOB_BYTES, SEARCH_BLOCK};
use crate::model::{Memory, MemoryError, RayRequest};
use std::collections::HashSet;

/// Words of a block.
const PER_BLOCK: u32 = SEARCH_BLOCK / 4;

/// A neighbour of a query.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour {
    /// The index of the vector.
    pub index: u32,
    /// The Euclidean distance, the dot product, or the cosine of the angle.
    pub distance: f32,
}

impl PartialEq for Neighbour {
    /// Distances are equal in all bits, or both are NaN.
    fn eq(&self, other: &Self) -> bool {
        let bits = |distance: f32| if distance.is_nan() { f32::NAN.to_bits() } else { distance.to_bits() };
        (self.index, bits(self.distance)) == (other.index, bits(other.distance))
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SearchStatus {
    /// The neighbours are complete.
    #[default]
    Done,
    /// A word of the job is outside its range; there are no neighbours.
    Refused,
    /// The memory reported an error; there are no neighbours.
    Memory,
}

/// What a search did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchCounts {
    /// Vectors that were compared with the query.
    pub distances: u64,
    /// Beats of the datapath.
    pub beats: u64,
    /// Blocks that were read.
    pub blocks: u64,
    /// Candidates whose neighbours were read.
    pub expansions: u64,
}

/// What the unit returns for a job.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchReply {
    /// How it ended.
    pub status: SearchStatus,
    /// The neighbours, the best first, and of equal ranks the lower index first.
    pub neighbours: Vec<Neighbour>,
    /// What it did.
    pub counts: SearchCounts,
}

/// Does the job at an address in a unit of these parameters. `base` has the upper 32 bits of all addresses.
///
/// A vector whose rank is NaN is no neighbour: one with an element that is NaN, or with infinities whose difference or
/// sum has none, or with the cosine of a vector of zeros.
pub fn search(memory: &(impl Memory + ?Sized), base: u32, job: u32, parameters: &SearchParameters) -> SearchReply {
    let mut search = Search { memory, base, parameters, counts: SearchCounts::default() };
    let (status, neighbours) = match search.run(job) {
        Ok(Some(neighbours)) => (SearchStatus::Done, neighbours),
        Ok(None) => (SearchStatus::Refused, Vec::new()),
        Err(MemoryError(_)) => (SearchStatus::Memory, Vec::new()),
    };
    SearchReply { status, neighbours, counts: search.counts }
}

struct Search<'m, M: ?Sized> {
    memory: &'m M,
    base: u32,
    parameters: &'m SearchParameters,
    counts: SearchCounts,
}

impl<M: Memory + ?Sized> Search<'_, M> {
    /// The neighbours; none if the job is refused.
    fn run(&mut self, address: u32) -> Result<Option<Vec<Neighbour>>, MemoryError> {
        let words = self.words(address, JOB_BYTES / 4)?;
        let Some(job) = words.try_into().ok().and_then(|words| SearchJob::from_words(words, self.parameters).ok())
        else {
            return Ok(None);
        };
        let mut query = self.elements(&job, job.query)?;
        let first = std::array::from_fn(|k| query.get(k).copied().unwrap_or_default());
        query.truncate(job.dimensions as usize);
        let query_norm = match job.metric {
            SearchMetric::Cosine => {
                let again = self.vector(&job, job.query)?;
                self.sums(&job, &query, &again).norm
            }
            _ => 1.0,
        };
        let mut seen = Seen { job, query, indices: HashSet::new(), list: BestList::new(job.kept()) };
        match job.place {
            Place::Scan => (0..job.count).try_for_each(|index| self.compare(&mut seen, index))?,
            Place::Gather { list, len } => self.compare_list(&mut seen, list, len)?,
            Place::Graph { neighbours, degree, entries, entry_count, expansions, .. } => {
                self.compare_list(&mut seen, entries, entry_count)?;
                let stride = (4 * degree).next_multiple_of(SEARCH_BLOCK);
                while self.counts.expansions < u64::from(expansions)
                    && let Some(index) = seen.list.expand()
                {
                    self.counts.expansions += 1;
                    self.compare_list(&mut seen, neighbours.wrapping_add(index.wrapping_mul(stride)), degree)?;
                }
            }
            Place::Keys { nodes, len, expansions } => self.descend(&mut seen, first, nodes, Some(len), expansions)?,
            Place::Boxes { nodes, expansions } => self.descend(&mut seen, first, nodes, None, expansions)?,
        }
        let scale = job.elements.scale();
        let of = |Candidate { rank, index, .. }| Neighbour {
            index,
            distance: distance_of(job.metric, rank, query_norm, scale),
        };
        Ok(Some(seen.list.into_best(job.k).map(of).collect()))
    }

    /// Compares the vectors that a tree of keys, of which `range` are read, or of boxes has for a query.
    fn descend(
        &mut self,
        seen: &mut Seen,
        query: [f32; 4],
        nodes: u32,
        range: Option<u32>,
        most: u32,
    ) -> Result<(), MemoryError> {
        let visit = |search: &mut Self, index: u32| {
            let words = search.words(nodes.wrapping_add(index.wrapping_mul(NODE_BYTES)), NODE_BYTES / 4)?;
            search.counts.beats += 1;
            Ok(Branch::of_node(&std::array::from_fn(|k| words[k]), query, range.is_some()))
        };
        let mut branches = vec![visit(self, 0)?];
        while let Some(branch) = branches.pop() {
            if branch.is_leaf {
                match range {
                    Some(len) => self.compare_all(seen, (0..len).map(|k| branch.first.wrapping_add(k)))?,
                    None => self.compare_all(seen, branch.indices())?,
                }
            } else if self.counts.expansions < most.into() {
                self.counts.expansions += 1;
                for index in branch.indices() {
                    let next = visit(self, index)?;
                    if next.children != 0 && branches.len() == BRANCHES {
                        return Err(MemoryError(nodes.into()));
                    }
                    branches.extend((next.children != 0).then_some(next));
                }
            } else {
                break;
            }
        }
        Ok(())
    }

    /// Compares the vectors of a list with the query, unless there is none of an index, or it was compared before.
    fn compare_list(&mut self, seen: &mut Seen, list: u32, len: u32) -> Result<(), MemoryError> {
        for number in 0..len.div_ceil(PER_BLOCK) {
            let address = list.wrapping_add(number.wrapping_mul(SEARCH_BLOCK));
            for index in self.words(address, (len - number * PER_BLOCK).min(PER_BLOCK))? {
                if index < seen.job.count && seen.indices.insert(index) {
                    self.compare(seen, index)?;
                }
            }
        }
        Ok(())
    }

    /// Compares the vectors of these indices, but those that name none.
    fn compare_all(&mut self, seen: &mut Seen, indices: impl Iterator<Item = u32>) -> Result<(), MemoryError> {
        let count = seen.job.count;
        indices.filter(|index| *index < count).try_for_each(|index| self.compare(seen, index))
    }

    fn compare(&mut self, seen: &mut Seen, index: u32) -> Result<(), MemoryError> {
        let job = seen.job;
        let vector = self.vector(&job, job.vectors.wrapping_add(index.wrapping_mul(job.stride)))?;
        let sums = self.sums(&job, &seen.query, &vector);
        let rank = rank_of(job.metric, sums);
        if rank <= job.bound {
            seen.list.offer(Candidate { rank, index, is_expanded: false });
        }
        Ok(())
    }

    fn sums(&mut self, job: &SearchJob, query: &[f32], vector: &[f32]) -> Sums {
        let (sums, beats) = distance::sums(job.metric, query, vector);
        self.counts.distances += 1;
        self.counts.beats += beats;
        sums
    }

    fn vector(&mut self, job: &SearchJob, address: u32) -> Result<Vec<f32>, MemoryError> {
        let mut vector = self.elements(job, address)?;
        vector.truncate(job.dimensions as usize);
        Ok(vector)
    }

    /// The elements of a vector and those behind it in its last block.
    fn elements(&mut self, job: &SearchJob, address: u32) -> Result<Vec<f32>, MemoryError> {
        let mut vector = Vec::with_capacity((job.layout().bytes() / job.elements.bytes()) as usize);
        self.read(address, job.layout().bytes(), |block| vector.extend(job.elements.of_block(block)))?;
        Ok(vector)
    }

    fn words(&mut self, address: u32, count: u32) -> Result<Vec<u32>, MemoryError> {
        let mut words = Vec::new();
        self.read(address, 4 * count, |block| {
            words.extend(block.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)));
        })?;
        words.truncate(count as usize);
        Ok(words)
    }

    /// Reads the blocks of so many bytes.
    fn read(&mut self, address: u32, bytes: u32, mut take: impl FnMut(&[u8])) -> Result<(), MemoryError> {
        for offset in (0..bytes).step_by(SEARCH_BLOCK as usize) {
            let address = RayRequest::address(self.base, address.wrapping_add(offset));
            take(self.memory.block(address, SEARCH_BLOCK)?);
            self.counts.blocks += 1;
        }
        Ok(())
    }
}

/// What a search keeps.
struct Seen {
    job: SearchJob,
    query: Vec<f32>,
    /// The indices of lists that were compared. A candidate that is offered again changes nothing, so hardware may forget some.
    indices: HashSet<u32>,
    list: BestList,
}
