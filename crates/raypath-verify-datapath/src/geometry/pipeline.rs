//! The netlist of a datapath, one job at a time: geometry judges sampled jobs of it as it judges the functional model.

use super::campaign::Tally;
use raypath_hdl::Module;
use raypath_hdl::mutate::{faults, replace};
use raypath_hdl::verilog::modules;
use raypath_model::WordModel;
use raypath_ops::{Job, Outcome};
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::{Engine, NetlistEngine, shape};
use raypath_verify::{Error, Verdict};
use std::cell::RefCell;
use std::sync::Arc;

/// One case of this many also runs on the netlist.
pub const SAMPLED: u64 = 50;
/// The number of judged results after which the faulty netlist must have been refuted.
const ENOUGH: u64 = 1_000;
/// The name of the faulty netlist's count.
pub const FAULTY: &str = "a netlist with a fault";

/// A simulated netlist, which is empty between jobs. Sums stay in its accumulators.
pub struct Pipeline {
    model: WordModel,
    engine: RefCell<NetlistEngine>,
}

/// A netlist, and the same with a fault: the negative control.
pub struct Pair {
    pub right: Pipeline,
    pub faulty: Pipeline,
}

impl Pair {
    /// The netlist of a configuration, and the one with the first fault whose description has these words.
    pub fn new(config: Config, words: &str) -> Result<Self, Error> {
        let datapath = Datapath::new(config)?;
        let faulty = with_fault(datapath.top(), words)?;
        Ok(Self {
            right: Pipeline::of(config, &datapath, datapath.top())?,
            faulty: Pipeline::of(config, &datapath, &faulty)?,
        })
    }
}

impl Pipeline {
    fn of(config: Config, datapath: &Datapath, top: &Arc<Module>) -> Result<Self, Error> {
        let model = raypath_sim::Datapath::paper(config).model();
        let engine = NetlistEngine::of_module(model.clone(), config, top, shape(config, datapath), |_| false)?;
        Ok(Self { model, engine: RefCell::new(engine) })
    }

    /// The outcome of a job in the empty pipeline; `None` if none leaves.
    pub fn run<const E: usize, const A: usize>(&self, job: &Job<E, A>) -> Option<Outcome> {
        /// More cycles than a job needs.
        const ENOUGH: usize = 200;
        let mut engine = self.engine.borrow_mut();
        engine.present(&self.model.paper_job(job)?);
        let mut is_offered = true;
        for _ in 0..ENOUGH {
            let shown = engine.cycle(is_offered, true);
            is_offered &= !shown.input_ready;
            if let Some(outcome) = shown.output {
                return outcome.paper_outcome();
            }
        }
        None
    }
}

/// The module with the first fault of these words; the module itself if there is none, so that the control fails.
fn with_fault(top: &Arc<Module>, words: &str) -> Result<Arc<Module>, Error> {
    for module in modules(top)? {
        if let Some(fault) = faults(&module).into_iter().find(|fault| fault.to_string().contains(words)) {
            return Ok(replace(top, &Arc::new(fault.apply(&module)?))?);
        }
    }
    Ok(top.clone())
}

/// Adds the results on the netlist to the verdict of an item. `judged` names the count of judged results.
pub fn joined(mut verdict: Verdict, (tally, is_stopped): (Tally, bool), judged: &str) -> Verdict {
    let (count, found) = (tally.count(judged), tally.count(FAULTY));
    let label = "wrong results of a netlist with a fault";
    let on_netlist = tally.verdict(is_stopped, String::new(), Vec::new(), (label, [FAULTY], count >= ENOUGH));
    verdict.covered += &format!("; {count} of the netlist");
    verdict.remarks.push(format!("{label}: {found}"));
    verdict.failures.extend(on_netlist.failures.into_iter().map(|failure| format!("netlist: {failure}")));
    verdict.is_stopped |= is_stopped;
    verdict
}
