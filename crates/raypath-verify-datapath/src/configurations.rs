//! Netlists against models in the presets and in every pair of values of two parameters, by the regression checks that
//! `mutation` tests.

use crate::covering::{Space, presets_and_pairs};
use raypath_sim::Datapath;
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::RegressionChecks;
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict};

/// The stream of the campaign's random numbers.
const STREAM: u64 = 23;

/// Checks each configuration, or the one of the request.
///
/// # Errors
/// A configuration cannot be elaborated.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let configs = if request.is_chosen { vec![request.config] } else { presets_and_pairs(&Space::new(&|_| true)) };
    let jobs = request.jobs.unwrap_or(request.level.pick(2_000, 20_000, 200_000)) as usize;
    let seed = request.seed;
    let case = |number: u64, tally: &mut Tally| -> Result<(), Error> {
        let config = configs[number as usize];
        let checks = RegressionChecks { config, seed: seed.wrapping_add(number), jobs };
        tally.add("configurations", 1_u64);
        if let Some(failure) = failure(checks)? {
            tally.fail(|| failure);
        }
        Ok(())
    };
    let campaign = Campaign::of_episodes(STREAM, configs.len() as u64);
    let (tally, is_stopped) = campaign.run(request, || Ok(()), |(), number, _, tally| case(number, tally))?;
    let remark = (!request.added.is_empty()).then(|| "added operations are not checked by this item".to_string());
    Ok(Verdict {
        covered: format!("{} configurations, {jobs} jobs each", tally.count("configurations")),
        remarks: remark.into_iter().collect(),
        failures: tally.first_failure().map(|(_, what)| what.to_string()).into_iter().collect(),
        is_stopped,
    })
}

/// What is wrong in a configuration.
fn failure(checks: RegressionChecks) -> Result<Option<String>, Error> {
    let config = checks.config;
    let model = Datapath::paper(config).model();
    let mut netlist = NetlistEngine::new(model.clone(), config, RegressionChecks::observes)?;
    let failed = checks.check(&mut netlist, &model).err();
    Ok(failed.map(|failed| format!("{config}, {}: {}", failed.check, failed.what)))
}
