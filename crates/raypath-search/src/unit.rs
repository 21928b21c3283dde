//! Searches by jobs of the unit's model.

use crate::exact::check;
use crate::{Graph, Metric, Neighbour, SearchError, SearchResults, Vectors, Work};
use rayon::prelude::*;
use raypath_timing::{Progress, ProgressCounter};
use raypath_traversal::search::{
    Elements, Place, SEARCH_BLOCK, SearchCounts, SearchImage, SearchJob, SearchMetric, SearchParameters, SearchReply,
    SearchStatus, VectorLayout, search,
};
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

/// The unit of the model.
const UNIT: SearchParameters = SearchParameters::MOST;

/// The results of a search by jobs.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitSearch {
    /// The neighbours. The angular distance is 1 minus the unit's cosine.
    pub results: SearchResults,
    /// Blocks of 64 bytes that all queries read.
    pub blocks: u64,
    /// Candidates whose neighbours in a graph were read.
    pub expansions: u64,
}

impl UnitSearch {
    /// Bytes that were read.
    pub fn bytes(&self) -> u64 {
        self.blocks * u64::from(SEARCH_BLOCK)
    }
}

/// Searches the `count` nearest vectors of each query by a job of the unit: a scan of all vectors, or a search in the
/// lowest layer of a graph that keeps a number of candidates. `progress` gets the number of completed queries.
///
/// # Errors
/// Queries of another dimension; a number of neighbours, candidates, dimensions or bytes that a job does not have;
/// [`Stopped`](SearchError::Stopped).
pub fn search_through_unit(
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
    count: usize,
    stored: StoredAs,
    graph: Option<(&Graph, usize)>,
    progress: Progress,
) -> Result<UnitSearch, SearchError> {
    check(base.dimensions(), base.len(), queries.dimensions(), count)?;
    in_job("neighbours", count, 1, UNIT.neighbours)?;
    in_job("dimensions", base.dimensions(), 1, UNIT.dimensions)?;
    let refused = |error: raypath_traversal::search::ImageError| SearchError::Parameter(error.to_string());
    let layout = VectorLayout { elements: stored.elements([base, queries]), dimensions: base.dimensions() as u32 };
    let mut image = SearchImage::new();
    let mut placed = |vectors: &Vectors| {
        let numbers: Vec<f32> = vectors.data().iter().map(|x| layout.elements.nearest(*x)).collect();
        image.vectors(layout, &numbers).map_err(refused)
    };
    let (vectors, first_query) = (placed(base)?, placed(queries)?);
    let place = match graph {
        None => Place::Scan,
        Some((graph, candidates)) => {
            in_job("candidates", candidates, count, UNIT.candidates)?;
            let (degree, lists, entry) = graph.lowest_layer();
            let neighbours = image.lists(degree as u32, lists.into_iter()).map_err(refused)?;
            let entries = image.lists(1, [&[entry][..]].into_iter()).map_err(refused)?;
            let (degree, candidates) = (degree as u32, candidates as u32);
            Place::Graph { neighbours, degree, entries, entry_count: 1, candidates, expansions: u32::MAX }
        }
    };
    let job = SearchJob {
        metric: if metric == Metric::Euclidean { SearchMetric::Euclidean } else { SearchMetric::Cosine },
        elements: layout.elements,
        dimensions: layout.dimensions,
        query: first_query,
        vectors,
        stride: layout.bytes(),
        count: base.len() as u32,
        k: count as u32,
        bound: f32::INFINITY,
        place,
    };
    let mut jobs = Vec::with_capacity(queries.len());
    for number in 0..queries.len() as u32 {
        let query = first_query + number * layout.bytes();
        jobs.push(image.job(&SearchJob { query, ..job }).map_err(refused)?);
    }

    let (began, progress) = (Instant::now(), ProgressCounter::new(progress));
    let replies: Vec<Option<SearchReply>> = jobs
        .into_par_iter()
        .map(|address| {
            let reply = (!progress.is_stopped()).then(|| search(&image, 0, address, &UNIT));
            progress.add(1);
            reply
        })
        .collect();
    if progress.is_stopped() {
        return Err(SearchError::Stopped);
    }
    let seconds = began.elapsed().as_secs_f64();
    let mut all = SearchCounts::default();
    let mut rows = Vec::with_capacity(replies.len());
    for SearchReply { status, neighbours, counts } in replies.into_iter().flatten() {
        if status != SearchStatus::Done {
            return Err(SearchError::Parameter(format!("a job ended with {status:?}, expected neighbours")));
        }
        rows.push(
            neighbours
                .into_iter()
                .map(|near| Neighbour { index: near.index, distance: shown(metric, near.distance) })
                .collect(),
        );
        all.distances += counts.distances;
        all.beats += counts.beats;
        all.blocks += counts.blocks;
        all.expansions += counts.expansions;
    }
    let work = Work { evaluations: all.distances, beats: all.beats };
    Ok(UnitSearch { results: SearchResults { rows, work, seconds }, blocks: all.blocks, expansions: all.expansions })
}

fn shown(metric: Metric, distance: f32) -> f64 {
    match metric {
        Metric::Euclidean => distance.into(),
        Metric::Angular => 1.0 - f64::from(distance),
    }
}

fn in_job(name: &str, found: usize, least: usize, most: u32) -> Result<(), SearchError> {
    if (least..=most as usize).contains(&found) {
        return Ok(());
    }
    Err(SearchError::Parameter(format!("{found} {name} in a job of the unit, expected {least} to {most}")))
}

impl StoredAs {
    fn elements(self, vectors: [&Vectors; 2]) -> Elements {
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
