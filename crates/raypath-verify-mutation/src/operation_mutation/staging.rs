//! Faults of staging: an operation marks the beginning of a stage too early, too late, with another number, or not.
//!
//! A mark decides when a value is computed and not what it is, so that no outcome can show it. The elaborator must
//! refuse the mark, or the datapath must have other units in a stage, which the tests of the tables show, or the mark
//! is harmless: the netlist still agrees with the model.

use super::graph::{Graph, Mark};
use super::replay::Replayed;
use raypath_ops::operations::{key_compare, octbox, point_in_box, quantised_box, sphere};
use raypath_ops::{
    Angular, BoxBits, Culling, Euclidean, Operation, RayBox, RayBoxConservative, RayTriangle, RayTriangleExtended,
    Rounding, Rules,
};
use raypath_rtl::{self as rtl, STAGES, Units};
use raypath_sim::Datapath;
use raypath_sim::jobs::any_jobs;
use raypath_sim::lockstep::lockstep;
use raypath_sim::traffic::Traffic;
use raypath_tools::pool;
use raypath_verify::{Error, Request};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What became of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum StagingFate {
    /// The elaborator refuses the dataflow.
    Refused,
    /// A stage has other units, or the pipeline another latency.
    OtherUnits,
    /// The netlist has the same units and agrees with the model.
    Harmless,
    /// The netlist differs from the model.
    Wrong(String),
}

/// A fault, its operation, and the function that elaborates it.
pub struct StagingFault {
    pub text: String,
    run: Box<dyn Fn() -> Result<StagingFate, Error> + Send + Sync>,
}

/// Jobs in each comparison of a netlist with the model.
const JOBS: usize = 300;
/// One of so many faults is tried at level regression.
const REGRESSION: usize = 60;

/// The fates of the faults of all operations, or of some at level regression.
///
/// # Errors
/// A netlist that cannot be compiled.
pub fn check(request: &mut Request<'_>) -> Result<Vec<(String, StagingFate)>, Error> {
    let every = request.level.pick(REGRESSION, 1, 1);
    let faults: Vec<StagingFault> = all().into_iter().step_by(every).collect();
    let shard = request.shard;
    let faults: Vec<(usize, StagingFault)> =
        faults.into_iter().enumerate().filter(|(number, _)| shard.takes(*number as u64)).collect();
    let shards = request.parts.phase(|| {
        let run = |(_, fault): &(usize, StagingFault), _: &_| (fault.run)().map(Some);
        let fates = pool::map::<_, _, Error>(&faults, pool::ALL_CORES, request.proceed, run)?;
        let fates = faults.iter().zip(fates).filter_map(|((_, fault), fate)| Some((fault.text.clone(), fate?)));
        Ok::<Vec<(String, StagingFate)>, Error>(fates.collect())
    })?;
    Ok(shards.into_iter().flatten().collect())
}

/// The faults of all operations.
fn all() -> Vec<StagingFault> {
    let mut all = Vec::new();
    let (rules, rounding) = (Rules::Paper, Rounding::Unit);
    for rules in [rules, Rules::Chisel, Rules::Bounds(BoxBits::DEFAULT)] {
        add(&mut all, RayBox { rules });
    }
    add(&mut all, RayBoxConservative);
    add(&mut all, RayTriangle { rules, rounding });
    let (culling, facing, barycentrics, range) = (Culling::None, true, true, true);
    add(&mut all, RayTriangleExtended { rules, rounding, culling, facing, barycentrics, range });
    add(&mut all, Euclidean::<16> { rounding });
    add(&mut all, Angular::<8> { rounding });
    add(&mut all, key_compare::KeyCompare);
    add(&mut all, octbox::Octbox);
    add(&mut all, point_in_box::PointInBox);
    add(&mut all, quantised_box::QuantisedBox);
    add(&mut all, sphere::Sphere);
    all
}

fn add<O: Operation + Clone + Send + Sync + 'static>(all: &mut Vec<StagingFault>, operation: O) {
    let graph = Graph::of(&operation);
    type Change = (&'static str, fn(&mut Mark));
    let changes: [Change; 5] = [
        ("begins a value later", |mark| mark.nodes += 1),
        ("begins a value earlier", |mark| mark.nodes -= 1),
        ("a stage later", |mark| mark.stage += 1),
        ("a stage earlier", |mark| mark.stage -= 1),
        ("not marked", |mark| mark.nodes = usize::MAX),
    ];
    for place in 0..graph.marks.len() {
        for (how, change) in changes {
            let mut faulty = graph.clone();
            change(&mut faulty.marks[place]);
            let text = format!("{}, stage {}: {how}", O::NAME, graph.marks[place].stage);
            let (operation, graph) = (operation.clone(), Arc::new(faulty));
            let run = Box::new(move || fate(&operation, &graph));
            all.push(StagingFault { text, run });
        }
    }
}

fn fate<O: Operation + Clone + Send + Sync + 'static>(operation: &O, graph: &Arc<Graph>) -> Result<StagingFate, Error> {
    let right = Datapath::new().with(operation.clone());
    let faulty = Datapath::new().with(Replayed { operation: operation.clone(), graph: graph.clone() });
    let Ok(elaborated) = faulty.elaborate() else { return Ok(StagingFate::Refused) };
    let units = |datapath: &rtl::Datapath| -> (u32, Vec<Units>) {
        (datapath.latency(), (1..=STAGES as usize).map(|stage| datapath.units(stage)).collect())
    };
    if units(&right.elaborate()?) != units(&elaborated) {
        return Ok(StagingFate::OtherUnits);
    }
    let (mut netlist, jobs) = (faulty.netlist(&elaborated)?, any_jobs(right.model(), 1).take(JOBS));
    let found = lockstep(&mut netlist, right.model(), jobs, &mut Traffic::random(1), |_| true);
    Ok(match found.differences.into_iter().next() {
        None => StagingFate::Harmless,
        Some(difference) => StagingFate::Wrong(difference),
    })
}
