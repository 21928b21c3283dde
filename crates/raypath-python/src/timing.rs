//! The simulated timing of rendering and search.

use crate::datapath::Datapath;
use crate::error::value_error;
use crate::tables::row;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raypath_embed as embed;
use raypath_float::Format;
use raypath_ops::JobKind;
use raypath_rtl::Features;
use raypath_timing::{Environment, System, Timing};
use std::sync::{Arc, OnceLock};

/// The datapath of an argument, or that of the preset `paper`. It must compute the paper's operations in binary32.
pub fn plain(datapath: Option<&Bound<'_, Datapath>>) -> PyResult<Arc<embed::Datapath>> {
    let Some(datapath) = datapath else { return paper() };
    let inner = &datapath.get().inner;
    let semantics = inner.config().semantics;
    if semantics.format != Format::BINARY32 || semantics.features != Features::OFF {
        let found = inner.description();
        return Err(value_error(format!("datapath: found {found}, expected format fp32 and no features")));
    }
    Ok(inner.clone())
}

/// The datapath of the preset `paper`, elaborated once: that takes longer than a search among a few vectors.
fn paper() -> PyResult<Arc<embed::Datapath>> {
    static PAPER: OnceLock<Arc<embed::Datapath>> = OnceLock::new();
    if let Some(known) = PAPER.get() {
        return Ok(known.clone());
    }
    let datapath = embed::Datapath::open("", &[]).map_err(crate::error::exception)?;
    Ok(PAPER.get_or_init(|| Arc::new(datapath)).clone())
}

/// The pipeline of a datapath before a memory.
pub fn system(datapath: &embed::Datapath, in_flight: usize, memory_latency: u64) -> System {
    let environment = Environment { in_flight, memory_latency, ..Environment::default() };
    System { environment, shape: datapath.shape().clone() }
}

/// The figures by name.
pub fn figures<'py>(py: Python<'py>, timing: &Timing, system: &System) -> PyResult<Bound<'py, PyDict>> {
    let row = row!(py,
        "in_flight": system.environment.in_flight,
        "memory_latency": system.environment.memory_latency,
        "agents": timing.agents,
        "cycles": timing.cycles,
        "jobs": timing.total_jobs(),
    )?;
    for kind in JobKind::ALL {
        row.set_item(kind.name(), timing.jobs_of(kind))?;
    }
    let rest = row!(py,
        "jobs_per_cycle": timing.jobs_per_cycle(),
        "agents_per_cycle": timing.agents_per_cycle(),
        "mean_latency": timing.mean_latency(),
        "fetches": timing.fetches,
        "accepted": timing.accepted,
        "refused": timing.refused,
        "starved_memory": timing.starved.memory,
        "starved_outcomes": timing.starved.outcomes,
        "starved_both": timing.starved.both,
    )?;
    row.update(rest.as_mapping())?;
    Ok(row)
}
