//! The class `RayQuery`, behind `raypath.Query`.

use crate::array::{Output, items, items_like};
use crate::error::{exception, value_error};
use crate::hits::UnitHits;
use crate::unit::{UnitScene, shown};
use crate::watch::watched;
use pyo3::prelude::*;
use rayon::prelude::*;
use raypath_embed::{self as embed, UnitCandidate, UnitHit, UnitQuery, UnitRay, UnitVerdict};
use std::sync::Arc;

/// The rays that wait for verdicts at a time, each of which takes about 1.5 KB.
const BATCH: usize = 1 << 14;
/// The rays that a core advances between two looks for signals.
const PIECE: usize = 1 << 8;

/// Rays that wait for verdicts on candidates; ``raypath.Query`` has the interface.
#[pyclass(module = "raypath")]
pub struct RayQuery {
    unit: Arc<embed::Unit>,
    scene: Py<UnitScene>,
    rays: Vec<UnitRay>,
    hits: Vec<UnitHit>,
    /// The rays that have begun.
    begun: usize,
    /// Those that wait for a verdict, with their places.
    waiting: Vec<(u32, UnitQuery)>,
}

impl RayQuery {
    pub fn new(unit: &Arc<embed::Unit>, scene: &Bound<'_, UnitScene>, rays: Vec<UnitRay>) -> Self {
        let hits = vec![UnitHit::default(); rays.len()];
        let (unit, scene) = (unit.clone(), scene.clone().unbind());
        Self { unit, scene, rays, hits, begun: 0, waiting: Vec::new() }
    }
}

#[pymethods]
impl RayQuery {
    /// Gives verdicts on the candidates before, one for each, and returns the next; None where all rays have ended.
    #[pyo3(signature = (verdicts = None))]
    fn advance<'py>(
        &mut self,
        py: Python<'py>,
        verdicts: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        if let Some(verdicts) = verdicts {
            let verdicts = items_like::<UnitVerdict>(verdicts, "verdicts", self.waiting.len(), "candidates")?;
            self.waiting.iter_mut().zip(&*verdicts).for_each(|((_, query), verdict)| query.answer(*verdict));
        }
        let Self { unit, scene, rays, hits, begun, waiting } = self;
        let scene = &scene.get().data;
        let found = watched(py, |progress| {
            loop {
                let new = rays.len().min(*begun + BATCH - waiting.len());
                for (place, ray) in (*begun as u32..).zip(&rays[*begun..new]) {
                    waiting.push((place, unit.query(ray).map_err(exception)?));
                }
                *begun = new;
                let advance = |(place, query): &mut (u32, UnitQuery)| {
                    query.proceed(scene).map(|candidate| UnitCandidate { ray: *place, ..candidate })
                };
                let pieces = waiting.par_chunks_mut(PIECE).map(|piece| {
                    if progress(0) { piece.iter_mut().map(advance).collect::<Vec<_>>() } else { Vec::new() }
                });
                let asked: Vec<Option<UnitCandidate>> = pieces.collect::<Vec<_>>().concat();
                // After a signal some are missing, and the exception is raised.
                let mut asked_of = asked.iter().chain(std::iter::repeat(&None));
                waiting.retain(|(place, query)| {
                    let is_asked = asked_of.next().is_some_and(Option::is_some);
                    if let Some(hit) = query.hit().filter(|_| !is_asked) {
                        hits[*place as usize] = shown(hit);
                    }
                    is_asked
                });
                let asked: Vec<UnitCandidate> = asked.into_iter().flatten().collect();
                if !asked.is_empty() || *begun == rays.len() || !progress(0) {
                    return Ok(asked);
                }
            }
        })?;
        if found.is_empty() {
            return Ok(None);
        }
        let mut output = Output::new::<UnitCandidate>(py, found.len())?;
        output.items()?.copy_from_slice(&found);
        Ok(Some(output.into_array()))
    }

    /// The hits of all rays, which have ended.
    fn hits(&self, py: Python<'_>) -> PyResult<UnitHits> {
        if self.begun < self.rays.len() || !self.waiting.is_empty() {
            let ended = self.begun - self.waiting.len();
            return Err(value_error(format!(
                "{ended} of {} rays have ended: iterate over the query first",
                self.rays.len()
            )));
        }
        let mut output = Output::new::<UnitHit>(py, self.hits.len())?;
        output.items()?.copy_from_slice(&self.hits);
        Ok(UnitHits::of(output.into_array(), None))
    }
}

/// Rays for a query, with further flags.
pub fn rays_of(rays: &Bound<'_, PyAny>, flags: u32) -> PyResult<Vec<UnitRay>> {
    Ok(items::<UnitRay>(rays, "rays")?.iter().map(|ray| UnitRay { flags: ray.flags | flags, ..*ray }).collect())
}
