use crate::{CliError, Progress};
use raypath_ppa::{Bench, Design, Error, Report};
#[cfg(feature = "full")]
use raypath_ppa::{PowerResults, Workload};
#[cfg(feature = "full")]
use std::collections::BTreeMap;

/// Measures designs with a progress bar. Results are taken from the bench's cache and added to it, also if the user
/// stops the work.
pub fn measure(bench: &Bench, designs: &[Design]) -> Result<Vec<Report>, CliError> {
    watched(|watch| bench.measure(designs, watch))
}

/// Synthesises the units of designs with a progress bar.
#[cfg(feature = "full")]
pub fn unit_areas(bench: &Bench, designs: &[Design]) -> Result<BTreeMap<String, f64>, CliError> {
    watched(|watch| bench.unit_areas(designs, watch))
}

/// Measures the power of a design in workloads with a progress bar.
#[cfg(feature = "full")]
pub fn power(
    bench: &Bench,
    design: &Design,
    report: &Report,
    workloads: &[Workload],
    with_saif: bool,
) -> Result<PowerResults, CliError> {
    watched(|watch| bench.power(design, report, workloads, with_saif, watch))
}

/// Shows the progress of `work`, which reports its steps.
fn watched<T>(
    work: impl FnOnce(&mut dyn FnMut(raypath_ppa::Progress) -> bool) -> Result<T, Error>,
) -> Result<T, CliError> {
    let mut progress: Option<Progress> = None;
    let mut reached = 0;
    let result = work(&mut |steps| {
        let total = steps.total as usize;
        reached = steps.done as usize;
        // If all results are in the cache, there is no progress to show.
        total == 0 || progress.get_or_insert_with(|| Progress::new("steps", total)).at(reached)
    });
    progress.map_or(Ok(()), |progress| progress.finish(reached))?;
    Ok(result?)
}
