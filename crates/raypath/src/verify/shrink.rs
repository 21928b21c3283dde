//! Failures made small: jobs, handshakes and operands are left out as long as it still fails (delta debugging: Zeller and
//! Hildebrandt, IEEE TSE 28(2), 2002).

use crate::engine::{NetlistEngine, observe};
use crate::lockstep::{Difference, SideBySide};
use crate::models::PaperModel;
use crate::traffic::{Cycle, Traffic};
use crate::verify::layout::Layout;
use raypath_model::OnPorts;
use raypath_rtl::Config;
use std::cell::Cell;

/// Jobs, and what source, sink and reset do from the state on that a new netlist has; after the last cycle source and
/// sink always act.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace<M: PaperModel> {
    /// The jobs.
    pub jobs: Vec<M::Job>,
    /// The cycles.
    pub cycles: Vec<Cycle>,
}

/// What is wrong with a netlist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An outcome that leaves is not what the functional model answers.
    Answer,
    /// Something at the ports is not what the cycle-exact model shows.
    Ports,
}

/// Makes a failing trace small, and says what is wrong in it: if outcomes are, that is kept, else that ports differ.
/// Gives the trace as it is if it does not fail.
pub fn shrink<M: PaperModel>(
    netlist: &mut NetlistEngine<M>,
    model: &M,
    config: Config,
    mut trace: Trace<M>,
) -> (Trace<M>, Fault) {
    let mut fails = |trace: &Trace<M>, fault| fails(netlist, model, trace, fault);
    let fault = if fails(&trace, Fault::Answer) { Fault::Answer } else { Fault::Ports };
    if !fails(&trace, fault) {
        return (trace, fault);
    }
    let mut fails =
        |jobs: &[M::Job], cycles: &[Cycle]| fails(&Trace { jobs: jobs.to_vec(), cycles: cycles.to_vec() }, fault);
    // What is left out of one makes more of the other superfluous.
    const ROUNDS: usize = 4;
    for _ in 0..ROUNDS {
        let before = (trace.jobs.len(), trace.cycles.len());
        for simpler in simpler_cycles(&trace.cycles) {
            if fails(&trace.jobs, &simpler) {
                trace.cycles = simpler;
                break;
            }
        }
        trace.jobs = reduced(trace.jobs, |jobs| fails(jobs, &trace.cycles));
        trace.cycles = reduced(trace.cycles, |cycles| fails(&trace.jobs, cycles));
        if before == (trace.jobs.len(), trace.cycles.len()) {
            break;
        }
    }
    simplify_operands(model, config, &mut trace, |trace| fails(&trace.jobs, &trace.cycles));
    (trace, fault)
}

/// Whether the netlist has the fault in a trace.
pub fn fails<M: PaperModel>(netlist: &mut NetlistEngine<M>, model: &M, trace: &Trace<M>, fault: Fault) -> bool {
    /// More cycles than a job takes, after the last that is recorded.
    const CYCLES_A_JOB: u64 = 64;
    netlist.restart();
    let worst = Cell::new(None);
    let mut engines = SideBySide::new(netlist, model.clone(), |found| worst.set(worst.get().max(Some(found))));
    let enough = trace.cycles.len() as u64 + CYCLES_A_JOB * (trace.jobs.len() as u64 + 1);
    let mut cycles = 0;
    let is_seen = || match fault {
        Fault::Answer => worst.get() == Some(Difference::Answer),
        Fault::Ports => worst.get().is_some(),
    };
    observe(&mut engines, trace.jobs.iter(), &mut Traffic::recorded(trace.cycles.clone()), |_| {
        cycles += 1;
        cycles < enough && !is_seen()
    });
    is_seen()
}

/// Handshakes that replace a pattern, the simplest first: none, without resets and withdrawn jobs, and each without one of
/// them.
fn simpler_cycles(cycles: &[Cycle]) -> Vec<Vec<Cycle>> {
    if cycles.is_empty() {
        return Vec::new();
    }
    let with = |change: fn(&mut Cycle)| {
        let mut changed = cycles.to_vec();
        changed.iter_mut().for_each(change);
        changed
    };
    let all = [
        Vec::new(),
        with(|cycle| (cycle.resets, cycle.withdraws) = (false, false)),
        with(|cycle| cycle.withdraws = false),
        with(|cycle| cycle.resets = false),
        with(|cycle| cycle.offers = true),
        with(|cycle| cycle.takes = true),
    ];
    all.into_iter().filter(|changed| changed != cycles).collect()
}

/// As few of the items as still fail: chunks are left out, the largest first.
fn reduced<T: Clone>(mut items: Vec<T>, mut fails: impl FnMut(&[T]) -> bool) -> Vec<T> {
    let mut chunk = items.len();
    while chunk > 0 {
        let mut begin = 0;
        while begin < items.len() {
            let end = (begin + chunk).min(items.len());
            let fewer = [&items[..begin], &items[end..]].concat();
            if fails(&fewer) {
                items = fewer;
            } else {
                begin = end;
            }
        }
        chunk /= 2;
    }
    items
}

/// Operands that are 0 where it still fails, else 1.
fn simplify_operands<M: PaperModel>(
    model: &M,
    config: Config,
    trace: &mut Trace<M>,
    mut fails: impl FnMut(&Trace<M>) -> bool,
) {
    let layout = Layout::of(model);
    let one = config.semantics.format.from_f32(1.0);
    let mut words = Vec::new();
    for index in 0..trace.jobs.len() {
        let kind = trace.jobs[index].kind();
        trace.jobs[index].words(&mut words);
        for (place, field) in layout.fields(kind).iter().enumerate() {
            let was = words[place];
            let simple = if field.is_number() { [0, one] } else { [0, 1] };
            // One that is simple already stays.
            for value in simple.into_iter().take_while(|value| *value != was) {
                words[place] = value;
                let job = std::mem::replace(&mut trace.jobs[index], model.job_of_words(kind, &words));
                if fails(trace) {
                    break;
                }
                trace.jobs[index] = job;
                words[place] = was;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduction_keeps_what_matters() {
        let needed = [3, 17, 64];
        let left = reduced((0..100).collect::<Vec<i32>>(), |items| needed.iter().all(|item| items.contains(item)));
        assert_eq!(left, needed);
        assert!(reduced((0..100).collect::<Vec<i32>>(), |_| true).is_empty());
        assert_eq!(reduced((0..10).collect::<Vec<i32>>(), |items| items.len() > 6).len(), 7);
    }
}
