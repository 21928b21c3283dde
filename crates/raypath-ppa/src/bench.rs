//! From designs to reports.

use crate::cache::{Cache, Key};
use crate::design::{Design, Piece, RegisterKind};
use crate::library::Library;
use crate::netlist::Netlist;
use crate::place::{Placed, Role};
use crate::report::{Area, Path, Report, Setting, Slowest, Stage, Step, thousandths};
use crate::structural;
use crate::synthesis::{Synthesis, write};
use crate::timing::{self, Ends, RawPath};
use crate::tool::{OpenSta, Yosys};
use crate::{Error, work};
use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

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
    /// A tool is missing or fails; a file cannot be written; [`Error::Stopped`].
    pub fn measure(&self, designs: &[Design], mut proceed: impl FnMut(Steps) -> bool) -> Result<Vec<Report>, Error> {
        let cache = Cache::new(&self.cache);
        let synthesis = Synthesis { library: &self.library, yosys: &self.yosys, period: self.period };
        let mut prepared = Vec::new();
        for design in designs {
            let pieces = design.pieces()?;
            let keys: Vec<Key> = pieces.iter().map(|piece| synthesis.key(piece)).collect();
            prepared.push((design, pieces, self.key(design, &keys)));
        }
        // A report that is there needs nothing else; a unit that several designs have is synthesised once.
        let wanted = prepared.iter().filter(|(.., key)| cache.get::<Report>(key).is_none());
        let mut seen = HashSet::new();
        let mut tasks: Vec<(&Piece, &Design)> = Vec::new();
        for (design, pieces, _) in wanted.clone() {
            tasks.extend(pieces.iter().filter(|piece| seen.insert(synthesis.key(piece))).map(|piece| (piece, *design)));
        }
        // What surrounds the units takes longest.
        tasks.sort_by_key(|(piece, _)| piece.is_unit);

        let total = tasks.len() + wanted.count();
        let netlist = |piece: &Piece, registers: &BTreeMap<String, RegisterKind>, stop: &AtomicBool| {
            let key = synthesis.key(piece);
            if let Some(netlist) = cache.get::<Netlist>(&key) {
                return Ok(netlist);
            }
            let netlist = synthesis.run(piece, registers, stop)?;
            cache.put(&key, &netlist).map(|()| netlist)
        };
        let synthesise = |(piece, design): &(&Piece, &Design), stop: &AtomicBool| {
            netlist(piece, &design.registers(), stop).map(drop)
        };
        work::for_each(&tasks, self.jobs, synthesise, |done| proceed(Steps { done, total }))?;

        let report = |(design, pieces, key): &(&Design, Vec<Piece>, Key), stop: &AtomicBool| {
            if let Some(report) = cache.get(key) {
                return Ok(report);
            }
            let registers = design.registers();
            let mut netlists = BTreeMap::new();
            for piece in pieces {
                netlists.insert(piece.module.clone(), netlist(piece, &registers, stop)?);
            }
            let report = self.report(design, netlists, &registers, stop)?;
            cache.put(key, &report).map(|()| report)
        };
        let cached = designs.len() - (total - tasks.len());
        let done = |reports: usize| Steps { done: tasks.len() + reports.saturating_sub(cached), total };
        work::for_each(&prepared, self.jobs, report, |reports| proceed(done(reports)))
    }

    fn key(&self, design: &Design, pieces: &[Key]) -> Key {
        let (period, sta) = (self.period.to_string(), self.sta.to_string());
        let mut parts = vec![design.name(), self.library.digest(), &period, &sta];
        parts.extend(pieces.iter().map(Key::as_str));
        Key::new("report", &parts)
    }

    /// Puts together what is known of a synthesised design. `netlists` are its units and its top module.
    fn report(
        &self,
        design: &Design,
        mut netlists: BTreeMap<String, Netlist>,
        registers: &BTreeMap<String, RegisterKind>,
        stop: &AtomicBool,
    ) -> Result<Report, Error> {
        let groups = design.groups();
        let top = netlists.remove(design.top()).ok_or_else(|| Error::unexpected("yosys", "no top module", "one"))?;
        let placed = Placed::new(&top, &netlists, &self.library, &groups, registers);
        let areas = placed.areas(&netlists, &self.library);
        let flip_flops = placed.flip_flops();
        let slowest = self.slowest(&top, &netlists, &placed, &flip_flops, &groups, stop)?;

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
        let slowest = slowest.ok_or_else(|| Error::unexpected("sta", "no path", "at least one"))?;
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

        let folder = tempfile::tempdir().map_err(|problem| Error::file(&std::env::temp_dir(), "write in", problem))?;
        let folder = folder.path();
        let mut text: String =
            units.values().map(|unit| structural::module(unit, |index| format!("x{index}"))).collect();
        text += &structural::module(top, |index| structural::cell_name(index, &placed.roles[index]));
        write(folder, timing::NETLIST, &text)?;
        write(folder, timing::LIBRARY, self.library.text())?;
        let ends_only: Vec<Ends> = ends.iter().map(|(_, end)| *end).collect();
        write(folder, timing::SCRIPT, &timing::script(&top.module, &self.library, self.period, &ends_only))?;
        self.sta.run(folder, timing::SCRIPT, timing::LOG, &top.module, stop)?;
        let log = folder.join(timing::LOG);
        let said = fs::read(&log).map_err(|problem| Error::file(&log, "read", problem))?;
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

/// `u_stage_3` is stage 3.
fn stage_name(instance: &str) -> String {
    instance.strip_prefix("u_").unwrap_or(instance).replace('_', " ")
}

/// `u_stage_3.num_4_q[7]` is num_4_q[7] of stage 3.
fn register_name(flat: &str) -> String {
    match flat.split_once('.') {
        Some((instance, register)) => format!("{} {register}", stage_name(instance)),
        None => flat.to_string(),
    }
}
