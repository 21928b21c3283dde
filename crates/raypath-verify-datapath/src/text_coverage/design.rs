//! What is covered: a design, and stimuli for it.

use raypath_hdl::Module;
use raypath_tools::CoveragePoint;
use raypath_verify::Error;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// A design, and stimuli for it.
pub trait Design: Sync {
    /// The top module.
    fn top(&self) -> &Arc<Module>;

    /// The modules that another design covers.
    ///
    /// # Errors
    /// Different modules of one name.
    fn covered_elsewhere(&self) -> Result<BTreeSet<String>, Error> {
        Ok(BTreeSet::new())
    }

    /// Whether a point does not count, for a reason that the documents give.
    fn is_left_out(&self, _point: &CoveragePoint) -> bool {
        false
    }

    /// The optimisation of the program's C++, [`raypath_tools::Options::c_optimisation`]. More than 0 pays only for
    /// runs of a hundred thousand cycles.
    fn c_optimisation(&self) -> u32 {
        0
    }

    /// What the stimuli can leave out.
    fn omissions(&self) -> Vec<String>;

    /// The run of a seed and a number, without one of the [`omissions`](Self::omissions).
    ///
    /// # Errors
    /// What the design's model did wrong.
    fn run(&self, seed: u64, number: u64, omitted: Option<usize>) -> Result<Run, String>;
}

/// The numbers of the episodes of a run that has so many.
pub fn episodes_of(run: u64, episodes: u64) -> Range<u64> {
    run * episodes..(run + 1) * episodes
}

/// The inputs of all cycles of a run, and what the outputs must be.
pub struct Run {
    /// The words of `rst_ni` and of all inputs.
    pub frames: Vec<Vec<u64>>,
    pub fault: Fault,
}

/// What is wrong with the outputs of a cycle, if anything is.
pub type Fault = Box<dyn Fn(usize, &[u64]) -> Option<String>>;
