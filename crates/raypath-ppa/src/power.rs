//! The power of a design in workloads: the activity of each net times the energy of its transitions.

use crate::activity::{Activity, GateSimulator, STREAMS, Workload};
use crate::attribution::{Attribution, Share};
use crate::bench::{Plan, stage_name};
use crate::energy::{self, CellEnergy, Energies};
use crate::gates::{Cell, Gates, NetId};
use crate::netlist::Netlist;
use crate::report::{Power, StagePower, WorkloadPower};
use crate::{Bench, Design, Error, Report, saif, structural};
use raypath_tools::{Cache, Key, ToolError};
use raypath_work::pool::Progress;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

/// The limit on OpenSTA's output, which has about 40 lines for each cell.
const MAX_STA_OUTPUT: u64 = 4 << 30;

/// The kind of the energy in and at clock pins.
pub const CLOCK: &str = "clock";

/// The power of a design, and files for other tools.
#[derive(Debug)]
pub struct PowerResults {
    /// The figures.
    pub power: Power,
    /// The gates as structural Verilog, with names that those of `activities` are relative to.
    pub netlist: String,
    /// For each workload its name and the activity of every net, in SAIF; empty if not wanted.
    pub activities: Vec<(String, String)>,
}

impl Bench {
    /// Measures the power of a design in workloads. `report` is the design's own; its slowest path is the clock period.
    ///
    /// Each workload is simulated on the gates. Their outputs are compared in each cycle with those of the netlist
    /// before synthesis. `with_saif` gives [`PowerResults::activities`], of about 13 MB for each workload of a
    /// datapath. `proceed` is as for [`Bench::measure`], and counts OpenSTA's run and the workloads.
    ///
    /// # Errors
    /// Those of [`Bench::measure`]; another version of OpenSTA than 2.0.17; a library with cells other than gates and
    /// flip-flops; an output that differs from the netlist's.
    pub fn power(
        &self,
        design: &Design,
        report: &Report,
        workloads: &[Workload],
        with_saif: bool,
        mut proceed: impl FnMut(Progress) -> bool,
    ) -> Result<PowerResults, Error> {
        if self.sta.version != energy::VERSION {
            let expected = format!("{}, whose messages about power are parsed", energy::VERSION);
            return Err(ToolError::unexpected("sta", self.sta.version.clone(), expected).into());
        }
        let plan = self.plan(design)?;
        let total = workloads.len() as u64 + 1;
        let mut at_first = |steps: Progress| proceed(Progress { total, ..steps });
        let mut prepared = self.each(&[()], &mut at_first, |(), stop| self.prepared(&plan, stop))?;
        let Some(Prepared { top, units, gates, netlist, shares, names, energies }) = prepared.pop() else {
            return Err(ToolError::Stopped.into());
        };

        let mut then = |steps: Progress| proceed(Progress { done: steps.done + 1, total });
        // Compiling the netlist takes as long as a workload. A simulator serves the next one.
        let idle: Mutex<Vec<GateSimulator<'_>>> = Mutex::default();
        let pool = || idle.lock().unwrap_or_else(PoisonError::into_inner);
        let simulate = |workload: &Workload, stop: &AtomicBool| {
            let free = pool().pop();
            let mut simulator = free.map_or_else(|| GateSimulator::new(&gates, design.netlist()), Ok)?;
            let activity = simulator.run(workload, stop);
            pool().push(simulator);
            Ok(activity?)
        };
        let activities = self.each(workloads, &mut then, simulate)?;

        let parts = Parts {
            gates: &gates,
            energies: &energies,
            femtofarads: self.library.femtofarads,
            shares: &shares,
            groups: design.groups(),
            clock: gates.input("clk_i"),
            period_ns: report.slowest.ns,
        };
        let of_workload = |(workload, activity): (&Workload, &Activity)| parts.power(workload, activity);
        let power = Power {
            period_ns: report.slowest.ns,
            streams: STREAMS as u64,
            compared_cycles: workloads.iter().map(|workload| (workload.frames.len() * STREAMS) as u64).sum(),
            workloads: workloads.iter().zip(&activities).map(of_workload).collect(),
        };
        let in_saif = |(workload, activity): (&Workload, &Activity)| {
            let name_of = |index: usize| names[index].clone();
            let text = saif::text(&gates, &top, &units, activity, report.slowest.ns, &name_of);
            (workload.name.clone(), text)
        };
        let shown = workloads.iter().zip(&activities).filter(|_| with_saif);
        Ok(PowerResults { power, netlist, activities: shown.map(in_saif).collect() })
    }

    /// The gates of a plan with their energies, which are taken from the cache if it has them.
    fn prepared(&self, plan: &Plan<'_>, stop: &AtomicBool) -> Result<Prepared, Error> {
        let cache = Cache::new(&self.cache);
        let (top, units) = self.netlists(plan, &cache, stop)?;
        let gates = Gates::new(&top, &units, &self.library)?;
        let groups = plan.design.groups();
        let attribution = Attribution::new(&top, &units, &self.library, &groups, &plan.registers);
        let names: Vec<String> =
            attribution.roles.iter().enumerate().map(|(index, role)| structural::cell_name(index, role)).collect();
        let shares = attribution.shares(&self.library);
        let netlist = structural::design(&top, &units, |index| names[index].clone());

        let script = energy::script(plan.design.top(), &self.library);
        let key = Key::new("energies", &[plan.key.as_str(), &script]);
        let analyse = || {
            let said = self.analyse(plan.design.top(), &netlist, &script, MAX_STA_OUTPUT, stop)?;
            energy::energies(&String::from_utf8_lossy(&said), &gates)
        };
        let energies = cache.kept(&key, |_| true, analyse)?;
        Ok(Prepared { top, units, gates, netlist, shares, names, energies })
    }
}

/// A synthesised design with the energies of its cells.
struct Prepared {
    top: Netlist,
    units: BTreeMap<String, Netlist>,
    gates: Gates,
    /// The structural Verilog.
    netlist: String,
    /// The groups and kinds of each cell of the top module.
    shares: Vec<Vec<Share>>,
    /// The name of each cell of the top module.
    names: Vec<String>,
    energies: Energies,
}

/// What the power of a design in a workload follows from, beside the activity.
struct Parts<'g> {
    gates: &'g Gates,
    energies: &'g Energies,
    /// The unit of the library's capacitances.
    femtofarads: f64,
    shares: &'g [Vec<Share>],
    groups: Vec<String>,
    /// The root of the clock.
    clock: Option<NetId>,
    period_ns: f64,
}

/// The energy of a cell in femtojoules per cycle.
#[derive(Default)]
struct Parcel {
    /// In clock pins, and for charging them.
    clock: f64,
    internal: f64,
    switching: f64,
    leakage: f64,
}

impl Parts<'_> {
    fn power(&self, workload: &Workload, activity: &Activity) -> WorkloadPower {
        let cycles = activity.cycles.max(1) as f64;
        let mut stages: Vec<BTreeMap<String, f64>> = vec![BTreeMap::new(); self.groups.len()];
        let mut sum = Parcel::default();
        for (cell, energy) in self.gates.cells.iter().zip(&self.energies.cells) {
            let parcel = self.parcel(cell, energy, activity);
            let shares = &self.shares[cell.top];
            for Share { group, kind } in shares {
                let part = 1.0 / shares.len() as f64;
                let mut add = |kind: String, energy: f64| *stages[*group].entry(kind).or_default() += energy * part;
                add(kind.name(), parcel.internal + parcel.switching + parcel.leakage);
                if parcel.clock > 0.0 {
                    add(CLOCK.to_string(), parcel.clock);
                }
            }
            sum.clock += parcel.clock;
            sum.internal += parcel.internal;
            sum.switching += parcel.switching;
            sum.leakage += parcel.leakage;
        }
        let picojoules = |femtojoules: f64| rounded(femtojoules / 1000.0);
        let per_cycle = sum.clock + sum.internal + sum.switching + sum.leakage;
        let stages = self.groups.iter().zip(stages).filter(|(_, kinds)| !kinds.is_empty());
        let stages = stages.map(|(group, kinds)| StagePower {
            name: stage_name(group),
            picojoules: picojoules(kinds.values().sum()),
            kinds: kinds.into_iter().map(|(kind, energy)| (kind, picojoules(energy))).collect(),
        });
        let jobs = workload.jobs as f64;
        WorkloadPower {
            name: workload.name.clone(),
            cycles: activity.cycles,
            jobs: workload.jobs,
            milliwatts: rounded(per_cycle / self.period_ns / 1000.0),
            picojoules_per_cycle: picojoules(per_cycle),
            picojoules_per_job: (workload.jobs > 0).then(|| picojoules(per_cycle * cycles / jobs)),
            clock: picojoules(sum.clock),
            internal: picojoules(sum.internal),
            switching: picojoules(sum.switching),
            leakage: picojoules(sum.leakage),
            stages: stages.collect(),
        }
    }

    fn parcel(&self, cell: &Cell, energy: &CellEnergy, activity: &Activity) -> Parcel {
        let toggles = |net: &u32| activity.toggles[*net as usize] as f64 / activity.cycles.max(1) as f64;
        // Nanowatts times nanoseconds are 10⁻³ fJ.
        let mut parcel = Parcel { leakage: energy.leakage * self.period_ns * 1e-3, ..Parcel::default() };
        let logic = self.gates.logic(cell);
        for (input, (net, inside)) in cell.inputs.iter().zip(&energy.inputs).enumerate() {
            match logic.clock.filter(|clock| clock.input == input) {
                Some(clock) => {
                    // No cell drives the root of the clock, so its load is counted where it is.
                    let capacitance = clock.capacitance * self.femtofarads;
                    let is_root = Some(*net) == self.clock;
                    let charging = if is_root { 0.5 * capacitance * self.energies.volts.powi(2) } else { 0.0 };
                    parcel.clock += toggles(net) * (inside + charging);
                }
                None => parcel.internal += toggles(net) * inside,
            }
        }
        for (net, (inside, load)) in cell.outputs.iter().zip(energy.outputs.iter().zip(&energy.loads)) {
            if logic.is_clock_gate {
                parcel.clock += toggles(net) * (inside + load);
                continue;
            }
            parcel.internal += toggles(net) * inside;
            parcel.switching += toggles(net) * load;
        }
        parcel
    }
}

/// Rounds to four decimals, so that figures print without trailing digits.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests;
