//! Faults of staging: an operation marks a stage too early, too late, or with another number.

use super::graph::Graph;
use super::replay::Replayed;
use crate::Error;
use raypath_ops::{Operation, Rounding};
use raypath_rtl::{Budget, Config, STAGES, Units};
use raypath_sim::Datapath;
use raypath_sim::jobs::any_jobs;
use raypath_sim::lockstep::lockstep;
use raypath_sim::traffic::Traffic;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What became of a fault of staging.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum StagingFate {
    /// The elaborator refuses the dataflow.
    Refused,
    /// The datapath has other units in a stage, or another latency.
    OtherUnits,
    /// The datapath has the same units. Its netlist agrees with the model, so that only paths are longer.
    Harmless,
    /// The netlist differs from the model.
    Wrong(String),
}

/// A dataflow with a mark that is elsewhere, and a description.
pub fn faults(graph: &Graph) -> Vec<(String, Graph)> {
    let mut faults = Vec::new();
    for (place, mark) in graph.marks.iter().enumerate() {
        let mut add = |what: String, change: &dyn Fn(&mut super::graph::Mark)| {
            let mut faulty = graph.clone();
            change(&mut faulty.marks[place]);
            faults.push((format!("stage {}: {what}", mark.stage), faulty));
        };
        add("begins one value later".into(), &|mark| mark.nodes += 1);
        add("begins one value earlier".into(), &|mark| mark.nodes -= 1);
        add("one stage later".into(), &|mark| (mark.stage, mark.short) = (mark.stage + 1, mark.short + 1));
        add("one stage earlier".into(), &|mark| (mark.stage, mark.short) = (mark.stage - 1, mark.short - 1));
        add("not marked".into(), &|mark| mark.nodes = usize::MAX);
    }
    faults
}
