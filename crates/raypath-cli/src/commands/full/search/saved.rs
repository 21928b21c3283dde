//! The results of a search in a part.

use raypath_search::{Neighbour, SearchResults, Work};
use serde::{Deserialize, Serialize};

#[derive(Default, Serialize, Deserialize)]
pub struct SavedResults {
    /// The neighbours of each query: the index, and the bits of the distance.
    rows: Vec<Vec<(u32, u64)>>,
    evaluations: u64,
    beats: u64,
    seconds: f64,
}

impl From<SearchResults> for SavedResults {
    fn from(SearchResults { rows, work, seconds }: SearchResults) -> Self {
        let saved = |Neighbour { index, distance }: Neighbour| (index, distance.to_bits());
        let rows = rows.into_iter().map(|row| row.into_iter().map(saved).collect()).collect();
        Self { rows, evaluations: work.evaluations, beats: work.beats, seconds }
    }
}

impl From<SavedResults> for SearchResults {
    fn from(SavedResults { rows, evaluations, beats, seconds }: SavedResults) -> Self {
        let restored = |(index, bits)| Neighbour { index, distance: f64::from_bits(bits) };
        let rows = rows.into_iter().map(|row| row.into_iter().map(restored).collect()).collect();
        Self { rows, work: Work { evaluations, beats }, seconds }
    }
}
