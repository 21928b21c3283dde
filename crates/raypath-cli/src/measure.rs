use crate::{CliError, Progress};
use raypath_ppa::{Bench, Design, Error, Report};

/// Measures designs with a progress bar. Results are taken from the bench's cache and added to it, also if the user
/// stops the work.
pub fn measure(bench: &Bench, designs: &[Design]) -> Result<Vec<Report>, CliError> {
    watched(|watch| bench.measure(designs, watch))
}

/// Shows the progress of `work`, which reports its steps.
pub fn watched<T>(
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
