//! Searches by jobs of the unit's model.

use crate::exact::check;
use crate::tree::{self, in_tree};
use crate::{Layer, Metric, Neighbour, SearchError, SearchResults, Vectors, Work};
use rayon::prelude::*;
use raypath_model::Shape;
use raypath_timing::{Progress, ProgressCounter};
use raypath_traversal::search::{
    self as unit, Elements, Place, SEARCH_BLOCK, SearchCounts, SearchImage, SearchJob, SearchMetric, SearchParameters,
    SearchReply, SearchStatus, VectorLayout, search,
};
use raypath_traversal::{
    BlockRequest, Memory, Response, SearchInputs, SearchOutputs, SearchResult, UnitEngine, UnitInputs, UnitModel,
    UnitParameters,
};
use std::collections::VecDeque;
use std::time::Instant;

/// The elements of vectors in the unit's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoredAs {
    /// binary32, unchanged.
    Binary32,
    /// binary16, rounded to nearest.
    Binary16,
    /// Integers of 8 bits, rounded to nearest; 127 of them are the greatest magnitude of base and queries.
    Int8,
}

raypath_ops::names! {
    StoredAs { Binary32 = "binary32", Binary16 = "binary16", Int8 = "int8" },
    /// The error of an unknown name of elements.
    ParseStoredAsError, "elements `{0}`, expected binary32, binary16 or int8"
}

/// Where jobs look for neighbours.
#[derive(Debug, Clone, Copy)]
pub enum UnitPlace<'s> {
    /// All vectors are scanned.
    All,
    /// A graph, with the candidates that are kept.
    Graph(&'s Layer, usize),
    /// A tree of boxes around vectors of 1 to 3 dimensions, for those whose Euclidean distance is at most this.
    Boxes(f32),
    /// A tree of keys, which are vectors of one dimension. A query has two: the least and the greatest key. Its
    /// neighbours are the first that are not less than the former, in ascending order, and their distances are the keys.
    Keys,
}

/// What the jobs of a search do.
#[derive(Debug, Clone, Copy)]
pub struct UnitSpec<'s> {
    /// The vectors to search.
    pub base: &'s Vectors,
    /// The queries, each of which has a job.
    pub queries: &'s Vectors,
    /// The metric.
    pub metric: SearchMetric,
    /// The elements in memory, to which numbers are rounded.
    pub elements: Elements,
    /// The most neighbours of a query.
    pub neighbours: usize,
    /// The greatest rank of a neighbour (`docs/reference/searching.md`).
    pub bound: f32,
    /// Where its neighbours are looked for.
    pub place: UnitPlace<'s>,
    /// The unit's limits.
    pub unit: SearchParameters,
}

/// The results of a search by jobs.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitSearch {
    /// The neighbours of each query, with the unit's distances.
    pub rows: Vec<Vec<unit::Neighbour>>,
    /// The work of the datapath.
    pub work: Work,
    /// The wall-clock time of the search in seconds.
    pub seconds: f64,
    /// Blocks of 64 bytes that all queries read.
    pub blocks: u64,
    /// Candidates whose neighbours in a graph were read.
    pub expansions: u64,
    counts: Vec<SearchCounts>,
}

impl UnitSearch {
    /// The results as those of a search without the unit: the angular distance is 1 minus the cosine.
    pub fn results(&self, metric: Metric) -> SearchResults {
        let distance = |distance: f32| match metric {
            Metric::Euclidean => distance.into(),
            Metric::Angular => 1.0 - f64::from(distance),
        };
        let near = |near: &unit::Neighbour| Neighbour { index: near.index, distance: distance(near.distance) };
        let rows = self.rows.iter().map(|row| row.iter().map(near).collect()).collect();
        SearchResults { rows, work: self.work, seconds: self.seconds }
    }

    /// Bytes that were read.
    pub fn bytes(&self) -> u64 {
        self.blocks * u64::from(SEARCH_BLOCK)
    }
}

/// The memory around a unit: each request is answered after some cycles, one beat a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchMemory {
    /// Bits of a beat: 128, 256 or 512.
    pub width: u32,
    /// Cycles from a request to the first beat of its block.
    pub latency: u64,
}

/// The timing of jobs in the unit's cycle-exact model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitTiming {
    /// The jobs.
    pub jobs: usize,
    /// Cycles until the last result was taken.
    pub cycles: u64,
    /// Beats of the datapath, from the functional model.
    pub beats: u64,
    /// Beats of the memory.
    pub memory_beats: u64,
}

impl UnitTiming {
    /// Beats of the datapath in a cycle.
    pub fn beats_per_cycle(&self) -> f64 {
        self.beats as f64 / self.cycles.max(1) as f64
    }

    /// The most beats in a cycle: 1; what the beats of the memory allow; and what so many searches do if each takes as
    /// long as one `alone`.
    pub fn bound(&self, alone: &Self, contexts: u32) -> f64 {
        let by_memory = self.beats as f64 / self.memory_beats.max(1) as f64;
        by_memory.min(f64::from(contexts) * alone.beats_per_cycle()).min(1.0)
    }
}

/// Vectors, a graph and a job for each query in the unit's memory.
#[derive(Debug, Clone)]
pub struct UnitJobs {
    image: SearchImage,
    jobs: Vec<u32>,
    unit: SearchParameters,
    /// In trees, the indices of vectors in the order of memory.
    order: Option<Vec<u32>>,
    are_keys: bool,
}

impl UnitJobs {
    /// Jobs that search the nearest vectors of each query.
    ///
    /// # Errors
    /// Queries of another dimension; a graph of another number of vectors; a number of neighbours, candidates,
    /// dimensions or bytes that a job of the unit does not have; a metric, elements or dimensions that a tree does not
    /// have; a radius that is negative or not finite.
    pub fn new(spec: &UnitSpec<'_>) -> Result<Self, SearchError> {
        let UnitSpec { base, queries, metric, elements, neighbours: count, bound, place, unit } = *spec;
        let of_query = if matches!(place, UnitPlace::Keys) { 2 } else { base.dimensions() };
        check(of_query, base.len(), queries.dimensions(), count)?;
        if matches!(place, UnitPlace::Boxes(_) | UnitPlace::Keys) {
            in_tree(spec)?;
        }
        in_job("neighbours", count, 1, unit.neighbours)?;
        in_job("dimensions", base.dimensions(), 1, unit.dimensions)?;
        let refused = |error: raypath_traversal::search::ImageError| SearchError::Parameter(error.to_string());
        let layout = VectorLayout { elements, dimensions: base.dimensions() as u32 };
        let mut image = SearchImage::new();
        let sorted = tree::sorted(base, place);
        let numbers = sorted.as_ref().map_or(base.data(), |(_, numbers)| numbers);
        let mut placed = |layout: VectorLayout, numbers: &[f32]| {
            let numbers: Vec<f32> = numbers.iter().map(|x| layout.elements.nearest(*x)).collect();
            image.vectors(layout, &numbers).map_err(refused)
        };
        let vectors = placed(layout, numbers)?;
        let first_query = match place {
            UnitPlace::Keys => placed(VectorLayout { dimensions: 4, ..layout }, &tree::ranges(queries))?,
            _ => placed(layout, queries.data())?,
        };
        let expansions = u32::MAX;
        let place = match place {
            UnitPlace::All => Place::Scan,
            UnitPlace::Boxes(radius) => {
                let nodes = image.boxes(&tree::points(base.dimensions(), numbers), radius).map_err(refused)?;
                Place::Boxes { nodes, expansions }
            }
            UnitPlace::Keys => {
                let nodes = image.keys(numbers).map_err(refused)?;
                Place::Keys { nodes, len: count as u32, expansions }
            }
            UnitPlace::Graph(layer, candidates) => {
                in_job("candidates", candidates, count, unit.candidates)?;
                let (degree, lists) = (layer.degree(), layer.neighbours());
                if lists.len() != base.len() {
                    let problem = format!("a graph of {} vectors, expected {}", lists.len(), base.len());
                    return Err(SearchError::Parameter(problem));
                }
                let neighbours = image.lists(degree as u32, lists.iter().map(Vec::as_slice)).map_err(refused)?;
                let entries = image.lists(1, [&[layer.entry()][..]].into_iter()).map_err(refused)?;
                let (degree, candidates) = (degree as u32, candidates as u32);
                Place::Graph { neighbours, degree, entries, entry_count: 1, candidates, expansions }
            }
        };
        let are_keys = matches!(place, Place::Keys { .. });
        let job = SearchJob {
            // The dot product of a key and -1 ranks it by its value.
            metric: if are_keys { SearchMetric::Dot } else { metric },
            elements,
            dimensions: layout.dimensions,
            query: first_query,
            vectors,
            stride: layout.bytes(),
            count: base.len() as u32,
            k: count as u32,
            bound: tree::bound(spec.place).unwrap_or(bound),
            place,
        };
        let mut jobs = Vec::with_capacity(queries.len());
        for number in 0..queries.len() as u32 {
            let query = first_query + number * layout.bytes();
            let bound = if are_keys { queries.data()[2 * number as usize + 1] } else { job.bound };
            jobs.push(image.job(&SearchJob { query, bound, ..job }).map_err(refused)?);
        }
        Ok(Self { image, jobs, unit, order: sorted.map(|(order, _)| order), are_keys })
    }

    /// The neighbours of a job that was done, by the indices of the base.
    fn done(
        &self,
        status: SearchStatus,
        neighbours: Vec<unit::Neighbour>,
    ) -> Result<Vec<unit::Neighbour>, SearchError> {
        if status != SearchStatus::Done {
            return Err(SearchError::Parameter(format!("a job ended with {status:?}, expected neighbours")));
        }
        let of_base = |near: unit::Neighbour| unit::Neighbour {
            index: self.order.as_ref().map_or(near.index, |order| order[near.index as usize]),
            distance: if self.are_keys { 0.0 - near.distance } else { near.distance },
        };
        Ok(neighbours.into_iter().map(of_base).collect())
    }

    /// The unit's memory.
    pub fn image(&self) -> &SearchImage {
        &self.image
    }

    /// The address of each query's job.
    pub fn addresses(&self) -> &[u32] {
        &self.jobs
    }

    /// The neighbours, by the functional model. `progress` gets the number of completed queries.
    ///
    /// # Errors
    /// [`Stopped`](SearchError::Stopped).
    pub fn search(&self, progress: Progress) -> Result<UnitSearch, SearchError> {
        let (began, progress) = (Instant::now(), ProgressCounter::new(progress));
        let replies: Vec<Option<SearchReply>> = self
            .jobs
            .par_iter()
            .map(|address| {
                let reply = (!progress.is_stopped()).then(|| search(&self.image, 0, *address, &self.unit));
                progress.add(1);
                reply
            })
            .collect();
        if progress.is_stopped() {
            return Err(SearchError::Stopped);
        }
        let seconds = began.elapsed().as_secs_f64();
        let (mut rows, mut all) = (Vec::with_capacity(replies.len()), Vec::with_capacity(replies.len()));
        for SearchReply { status, neighbours, counts } in replies.into_iter().flatten() {
            rows.push(self.done(status, neighbours)?);
            all.push(counts);
        }
        let sum = |of: fn(&SearchCounts) -> u64| all.iter().map(of).sum::<u64>();
        let work = Work { evaluations: sum(|counts| counts.distances), beats: sum(|counts| counts.beats) };
        let (blocks, expansions) = (sum(|counts| counts.blocks), sum(|counts| counts.expansions));
        Ok(UnitSearch { rows, work, seconds, blocks, expansions, counts: all })
    }

    /// Runs the first jobs through the cycle-exact model of a unit with searches, whose datapath has this shape, and
    /// compares each neighbour with those of the functional model. At most `in_flight` jobs are inside; 0: any number.
    /// `progress` gets the number of jobs that have ended.
    ///
    /// # Errors
    /// A unit without searches, or one that does not have the jobs' numbers of neighbours, candidates or dimensions; a
    /// neighbour that differs; [`Stopped`](SearchError::Stopped).
    pub fn time(
        &self,
        found: &UnitSearch,
        unit: (&Shape, UnitParameters),
        memory: SearchMemory,
        [jobs, in_flight]: [usize; 2],
        progress: Progress,
    ) -> Result<UnitTiming, SearchError> {
        let (shape, parameters) = unit;
        let parameters = UnitParameters { memory_width: memory.width, id_width: 32, ..parameters };
        if parameters.search.0.is_none() {
            return Err(SearchError::Parameter("a unit without searches, expected one with them".to_string()));
        }
        let jobs = jobs.min(self.jobs.len());
        let (mut model, progress) = (UnitModel::new(shape, parameters), ProgressCounter::new(progress));
        let mut queue: VecDeque<(u64, BlockRequest)> = VecDeque::new();
        let mut rows = vec![Vec::new(); jobs];
        let (mut next, mut ended, mut beat, mut now) = (0, 0, 0, 0_u64);
        let (beat_bytes, beats) = (memory.width as usize / 8, 8 * SEARCH_BLOCK / memory.width);
        while ended < jobs {
            let Some(SearchOutputs { ready, result, request, .. }) = model.outputs().search else { break };
            let can_enter = next < jobs && (in_flight == 0 || next < ended + in_flight);
            let job = can_enter.then(|| (next as u64, 0, self.jobs[next]));
            let due = queue.front().copied().filter(|(due, _)| *due <= now).map(|(_, request)| request);
            let block = due.map(|BlockRequest { address, tag }| (self.image.block(address, SEARCH_BLOCK), tag));
            let response = block.as_ref().map(|(block, tag)| {
                let block = block.as_ref().copied().unwrap_or(&[0; SEARCH_BLOCK as usize]);
                Response { tag: *tag, is_error: false, beat: &block[beat as usize * beat_bytes..][..beat_bytes] }
            });
            let search = SearchInputs { job, result_ready: true, request_ready: true, response };
            model.cycle(&UnitInputs { search, ..UnitInputs::default() });
            next += usize::from(ready && job.is_some());
            if due.is_some() {
                beat = (beat + 1) % beats;
                if beat == 0 {
                    queue.pop_front();
                }
            }
            now += 1;
            queue.extend(request.map(|request| (now + memory.latency, request)));
            if let Some(SearchResult { id, neighbour, status, is_last, .. }) = result {
                let row = &mut rows[id as usize];
                row.extend(neighbour);
                if is_last {
                    if self.done(status, std::mem::take(row))? != found.rows[id as usize] {
                        return Err(SearchError::Parameter(format!("query {id} differs between the unit's models")));
                    }
                    ended += 1;
                    progress.add(1);
                    if progress.is_stopped() {
                        return Err(SearchError::Stopped);
                    }
                }
            }
        }
        let counts = &found.counts[..jobs];
        let sum = |of: fn(&SearchCounts) -> u64| counts.iter().map(of).sum::<u64>();
        let memory_beats = sum(|counts| counts.blocks) * u64::from(beats);
        Ok(UnitTiming { jobs, cycles: now, beats: sum(|counts| counts.beats), memory_beats })
    }
}

fn in_job(name: &str, found: usize, least: usize, most: u32) -> Result<(), SearchError> {
    if (least..=most as usize).contains(&found) {
        return Ok(());
    }
    Err(SearchError::Parameter(format!("{found} {name} in a job of the unit, expected {least} to {most}")))
}

impl StoredAs {
    /// The elements of these vectors.
    pub fn elements(self, vectors: [&Vectors; 2]) -> Elements {
        match self {
            Self::Binary32 => Elements::Binary32,
            Self::Binary16 => Elements::Binary16,
            Self::Int8 => {
                let all = vectors.into_iter().flat_map(Vectors::data);
                let greatest = all.fold(0.0_f32, |greatest, x| greatest.max(x.abs()));
                Elements::Int8 { scale: if greatest > 0.0 { greatest / 127.0 } else { 1.0 } }
            }
        }
    }
}
