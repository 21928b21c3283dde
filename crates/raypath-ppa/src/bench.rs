//! From designs to reports.

use crate::design::{Design, Piece, RegisterKind};
use crate::library::Library;
use crate::netlist::Netlist;
use crate::place::{Placed, Role};
use crate::report::{Area, Path, Report, Setting, Slowest, Stage, Step, thousandths};
use crate::structural;
use crate::synthesis::Synthesis;
use crate::timing::{self, Ends, RawPath};
use crate::{Error, parallel};
use raypath_tools::{Cache, Key, OpenSta, ToolError, Yosys, read_within, temporary_folder, write};
use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// More than OpenSTA says: some kilobytes a stage.
const MOST_SAID: u64 = 64 << 20;

/// Everything that designs are measured with.
#[derive(Debug)]
pub struct Bench {
    /// The cells.
    pub library: Library,
    /// The synthesiser.
    pub yosys: Yosys,
    /// The timing analyser.
    pub sta: OpenSta,
    /// The period that gates are chosen for, in nanoseconds.
    pub period: f64,
    /// How many programs may run at a time.
    pub jobs: usize,
    /// Where results are kept.
    pub cache: PathBuf,
}

/// How far a measurement has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Steps that are done.
    pub done: usize,
    /// All of them: syntheses and timing analyses.
    pub total: usize,
}

impl Bench {
    /// Measures designs: synthesises what they are made of, each kind of unit once, and finds the slowest path to each
    /// stage. What is in the cache is not done again, and all that is done goes into it at once, so that a measurement
    /// that was stopped goes on where it was. `proceed` is told several times a second how far it is; where it says no,
    /// the programs are ended.
    ///
    /// # Errors
    /// A tool is missing or fails; a file cannot be written; [`ToolError::Stopped`].
    pub fn measure(&self, designs: &[Design], mut proceed: impl FnMut(Steps) -> bool) -> Result<Vec<Report>, Error> {
        let cache = Cache::new(&self.cache);
        let plans = designs.iter().map(|design| self.plan(design)).collect::<Result<Vec<_>, _>>()?;
        // A report that is there needs nothing else.
        let wanted: Vec<&Plan<'_>> = plans.iter().filter(|plan| cache.get::<Report>(&plan.key).is_none()).collect();
        let pieces = new_pieces(&wanted, &cache);
        let total = pieces.len() + wanted.len();

        let synthesise = |(plan, piece): &(&Plan<'_>, usize), stop: &AtomicBool| {
            self.netlist(plan, *piece, &cache, stop).map(|_| Some(()))
        };
        all(parallel::map(&pieces, self.jobs, synthesise, |done| proceed(Steps { done, total }))?)?;

        let known = plans.len() - wanted.len();
        let done = |reports: usize| Steps { done: pieces.len() + reports.saturating_sub(known), total };
        let report = |plan: &Plan<'_>, stop: &AtomicBool| match cache.get(&plan.key) {
            Some(report) => Ok::<_, Error>(Some(report)),
            None => {
                let report = self.report(plan, &cache, stop)?;
                cache.put(&plan.key, &report)?;
                Ok(Some(report))
            }
        };
        Ok(all(parallel::map(&plans, self.jobs, report, |reports| proceed(done(reports)))?)?)
    }

    fn plan<'d>(&self, design: &'d Design) -> Result<Plan<'d>, Error> {
        let synthesis = self.synthesis();
        let pieces: Vec<(Piece, Key)> = design
            .pieces()?
            .into_iter()
            .map(|piece| {
                let key = synthesis.key(&piece);
                (piece, key)
            })
            .collect();
        let (period, sta) = (self.period.to_string(), self.sta.to_string());
        let mut parts = vec![design.name(), self.library.digest(), &period, &sta];
        parts.extend(pieces.iter().map(|(_, key)| key.as_str()));
        let key = Key::new("report", &parts);
        Ok(Plan { design, registers: design.registers(), pieces, key })
    }

    fn synthesis(&self) -> Synthesis<'_> {
        Synthesis { library: &self.library, yosys: &self.yosys, period: self.period }
    }

    /// A piece, synthesised now or earlier.
    fn netlist(&self, plan: &Plan<'_>, piece: usize, cache: &Cache, stop: &AtomicBool) -> Result<Netlist, Error> {
        let (piece, key) = &plan.pieces[piece];
        match cache.get(key) {
            Some(netlist) => Ok(netlist),
            None => {
                let netlist = self.synthesis().run(piece, &plan.registers, stop)?;
                cache.put(key, &netlist)?;
                Ok(netlist)
            }
        }
    }

    /// Puts together what is known of a design.
    fn report(&self, plan: &Plan<'_>, cache: &Cache, stop: &AtomicBool) -> Result<Report, Error> {
        let Plan { design, registers, .. } = plan;
        let mut units = BTreeMap::new();
        for (number, (piece, _)) in plan.pieces.iter().enumerate() {
            units.insert(piece.module.clone(), self.netlist(plan, number, cache, stop)?);
        }
        let top = units.remove(design.top()).ok_or_else(|| ToolError::unexpected("yosys", "no top module", "one"))?;
        let groups = design.groups();
        let placed = Placed::new(&top, &units, &self.library, &groups, registers);
        let areas = placed.areas(&units, &self.library);
        let flip_flops = placed.flip_flops();
        let slowest = self.slowest(&top, &units, &placed, &flip_flops, &groups, stop)?;

        let mut area = Area::default();
        areas.iter().for_each(|part| area.add(part));
        let stages = groups.iter().zip(areas).zip(&flip_flops).zip(slowest);
        let stages = stages.map(|(((group, area), &flip_flops), slowest)| Stage {
            name: stage_name(group),
            area,
            flip_flops,
            slowest,
        });
        let stages: Vec<Stage> = stages.filter(|stage| stage.area.total > 0.0 || stage.slowest.is_some()).collect();
        let slowest = stages.iter().filter_map(|stage| Some((stage, stage.slowest.as_ref()?.ns)));
        let slowest = slowest.max_by(|(_, a), (_, b)| a.total_cmp(b));
        let slowest = slowest.map(|(stage, ns)| Slowest { stage: stage.name.clone(), ns });
        let slowest = slowest.ok_or_else(|| ToolError::unexpected("sta", "no path", "at least one"))?;
        if slowest.ns <= 0.0 {
            let found = format!("a slowest path of {} ns", slowest.ns);
            return Err(ToolError::unexpected("sta", found, "one that takes time").into());
        }
        Ok(Report {
            design: design.name().to_string(),
            setting: self.setting(),
            flip_flops: flip_flops.iter().sum(),
            kilo_gates: thousandths(area.total / self.library.nand2_area() / 1000.0),
            clock_mhz: thousandths(1000.0 / slowest.ns),
            area_period: thousandths(area.total / 1e6 * slowest.ns),
            area,
            slowest,
            stages,
        })
    }

    /// What this bench measures with, for reports.
    pub fn setting(&self) -> Setting {
        Setting {
            synthesis: self.yosys.to_string(),
            timing: self.sta.to_string(),
            library: self.library.name().to_string(),
            nand2: self.library.nand2().to_string(),
            buffer: self.library.buffer().to_string(),
            load_ff: self.library.load(),
            period_ns: self.period,
        }
    }

    /// The slowest path that ends in each group.
    fn slowest(
        &self,
        top: &Netlist,
        units: &BTreeMap<String, Netlist>,
        placed: &Placed<'_>,
        flip_flops: &[u64],
        groups: &[String],
        stop: &AtomicBool,
    ) -> Result<Vec<Option<Path>>, Error> {
        let mut ends: Vec<(usize, Ends)> = (0..groups.len())
            .filter(|group| flip_flops[*group] > 0)
            .map(|group| (group, Ends::Registers(group)))
            .collect();
        ends.push((placed.port_group(), Ends::Ports));

        let folder = temporary_folder()?;
        let folder = folder.path();
        let mut text: String =
            units.values().map(|unit| structural::module(unit, |index| format!("x{index}"))).collect();
        text += &structural::module(top, |index| structural::cell_name(index, &placed.roles[index]));
        write(&folder.join(timing::NETLIST), &text)?;
        write(&folder.join(timing::LIBRARY), self.library.text())?;
        let ends_only: Vec<Ends> = ends.iter().map(|(_, end)| *end).collect();
        write(&folder.join(timing::SCRIPT), &timing::script(&top.module, &self.library, self.period, &ends_only))?;
        self.sta.run(folder, timing::SCRIPT, timing::LOG, &top.module, stop)?;
        let log = folder.join(timing::LOG);
        let said = read_within(&log, MOST_SAID)?;
        let found = timing::paths(&String::from_utf8_lossy(&said), ends.len())?;

        let mut slowest: Vec<Option<Path>> = vec![None; groups.len()];
        for ((group, _), raw) in ends.into_iter().zip(found) {
            let Some(path) = raw.map(|raw| readable(&raw, top, placed)) else { continue };
            let known = &mut slowest[group];
            if known.as_ref().is_none_or(|known| known.ns < path.ns) {
                *known = Some(path);
            }
        }
        Ok(slowest)
    }
}

/// All results, where none was left out because the user stopped the work.
fn all<T>(results: Vec<Option<T>>) -> Result<Vec<T>, ToolError> {
    results.into_iter().collect::<Option<_>>().ok_or(ToolError::Stopped)
}

/// A design, and the names under which its results are kept.
struct Plan<'d> {
    design: &'d Design,
    registers: BTreeMap<String, RegisterKind>,
    pieces: Vec<(Piece, Key)>,
    key: Key,
}

/// The pieces that have to be synthesised, each once, however many designs have it; what surrounds the units first,
/// which takes longest.
fn new_pieces<'p, 'd>(plans: &[&'p Plan<'d>], cache: &Cache) -> Vec<(&'p Plan<'d>, usize)> {
    let mut seen = HashSet::new();
    let mut new = Vec::new();
    for plan in plans {
        let unknown = |(_, (_, key)): &(usize, &(Piece, Key))| !cache.has(key) && seen.insert(key.clone());
        new.extend(plan.pieces.iter().enumerate().filter(unknown).map(|(number, _)| (*plan, number)));
    }
    new.sort_by_key(|(plan, number)| plan.pieces[*number].0.is_unit);
    new
}

/// A path in the designer's words.
fn readable(raw: &RawPath, top: &Netlist, placed: &Placed<'_>) -> Path {
    let word = |pin: &str| {
        let cell = pin.split('/').next().unwrap_or_default();
        let Some(index) = structural::cell_index(cell) else { return format!("port {cell}") };
        match placed.roles.get(index) {
            Some(Role::Register { .. }) => register_name(&top.cells[index].name),
            Some(Role::Unit { .. }) => top.cells[index].name.rsplit('.').next().unwrap_or_default().to_string(),
            Some(Role::Gate) | None => "gates".to_string(),
        }
    };
    let mut steps: Vec<Step> = Vec::new();
    for (pin, ns) in &raw.points {
        let through = word(pin);
        match steps.last_mut() {
            Some(last) if last.through == through => last.ns = *ns,
            _ => steps.push(Step { through, ns: *ns }),
        }
    }
    let name = |step: Option<&Step>| step.map(|step| step.through.clone()).unwrap_or_default();
    let (start, end) = (name(steps.first()), name(steps.last()));
    Path { ns: thousandths(raw.arrival + raw.setup), start, end, steps, setup_ns: raw.setup }
}

/// `u_stage_3` is stage 3, `u_stage_3_1` stage 3.1.
fn stage_name(instance: &str) -> String {
    let name = instance.strip_prefix("u_").unwrap_or(instance);
    match name.strip_prefix("stage_") {
        Some(number) => format!("stage {}", number.replace('_', ".")),
        None => name.replace('_', " "),
    }
}

/// `u_stage_3.num_4_q[7]` is num_4_q[7] of stage 3.
fn register_name(flat: &str) -> String {
    match flat.split_once('.') {
        Some((instance, register)) => format!("{} {register}", stage_name(instance)),
        None => flat.to_string(),
    }
}
