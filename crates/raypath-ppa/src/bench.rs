//! Measures designs: from netlists to reports.

use crate::Error;
use crate::attribution::{Attribution, CellRole};
use crate::design::{Block, Design, RegisterKind};
use crate::library::Library;
use crate::netlist::Netlist;
use crate::report::{Area, Path, Report, Setting, Slowest, Stage, Step, thousandths};
use crate::structural;
use crate::timing::{self, RawPath};
use raypath_tools::{Cache, Key, OpenSta, ToolError, Yosys, read_within, temporary_folder, write};
use raypath_work::pool::{self, Progress};
use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// The limit on OpenSTA's output, which has some kilobytes for each stage.
const MAX_STA_OUTPUT: u64 = 64 << 20;

/// A cell library, the tools and a cache, with which designs are measured.
#[derive(Debug)]
pub struct Bench {
    /// The cell library.
    pub library: Library,
    /// The synthesiser.
    pub yosys: Yosys,
    /// The timing analyser.
    pub sta: OpenSta,
    /// The clock period for which gates are chosen, in nanoseconds.
    pub period: f64,
    /// The part of the period for which units are optimised, in nanoseconds; the gates around them are optimised for
    /// the rest. None: both are optimised for the whole period.
    pub unit_period: Option<f64>,
    /// The number of programs that may run at a time.
    pub jobs: usize,
    /// The folder of cached results.
    pub cache: PathBuf,
}

impl Bench {
    /// Measures designs: synthesises their blocks, each kind of unit once, and finds the slowest path to each stage.
    ///
    /// Every result goes into the cache at once and is not computed again, so that a stopped measurement resumes.
    /// `proceed` gets the number of finished syntheses and timing analyses several times a second; if it returns
    /// false, the programs are ended.
    ///
    /// # Errors
    /// A tool is missing or fails; a file cannot be written; [`ToolError::Stopped`].
    pub fn measure(&self, designs: &[Design], mut proceed: impl FnMut(Progress) -> bool) -> Result<Vec<Report>, Error> {
        let cache = Cache::new(&self.cache);
        let plans = designs.iter().map(|design| self.plan(design)).collect::<Result<Vec<_>, _>>()?;
        // A cached report needs no synthesis.
        let wanted: Vec<&Plan<'_>> = plans.iter().filter(|plan| cache.get::<Report>(&plan.key).is_none()).collect();
        let blocks = new_blocks(&wanted, &cache);
        let (synthesised, total) = (blocks.len() as u64, (blocks.len() + wanted.len()) as u64);

        let mut synthesising = |blocks| proceed(Progress { total, ..blocks });
        self.each(&blocks, &mut synthesising, |(plan, block), stop| {
            self.netlist(plan, *block, &cache, stop).map(|_| ())
        })?;

        let known = (plans.len() - wanted.len()) as u64;
        let mut reported =
            |plans: Progress| proceed(Progress { done: synthesised + plans.done.saturating_sub(known), total });
        self.each(&plans, &mut reported, |plan, stop| {
            cache.kept(&plan.key, |_| true, || self.report(plan, &cache, stop))
        })
    }

    /// The results of `work` on each item, some at a time.
    ///
    /// # Errors
    /// An error that ended the run, not its consequence that tools were stopped; else [`ToolError::Stopped`] if the
    /// user stopped it.
    pub(crate) fn each<I: Sync, T: Send>(
        &self,
        items: &[I],
        proceed: &mut dyn FnMut(Progress) -> bool,
        work: impl Fn(&I, &AtomicBool) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let results = pool::map(items, self.jobs, proceed, |item, stop| match work(item, stop) {
            Err(Error::Tool(ToolError::Stopped)) => Ok(None),
            other => other.map(Some),
        })?;
        Ok(results.into_iter().collect::<Option<_>>().ok_or(ToolError::Stopped)?)
    }

    pub(crate) fn plan<'d>(&self, design: &'d Design) -> Result<Plan<'d>, Error> {
        let blocks: Vec<(Block, Key)> = design
            .blocks()?
            .into_iter()
            .map(|block| {
                let key = self.netlist_key(&block);
                (block, key)
            })
            .collect();
        if self.library.clock_gate.is_none() && blocks.iter().any(|(block, _)| block.has_clock_gates) {
            let what =
                "clock gate (clock_gating_integrated_cell : latch_posedge), which the option clock-gating needs,";
            return Err(Error::MissingCell { path: self.library.name.clone().into(), what: what.to_string() });
        }
        let period = self.period.to_string();
        let mut parts: Vec<&str> = vec![&design.name, &self.library.digest, &period, &self.sta.version];
        // The blocks are without memories.
        let memory_bits = design.memory_bits.to_string();
        parts.extend((design.memory_bits > 0).then_some(memory_bits.as_str()));
        parts.extend(blocks.iter().map(|(_, key)| key.as_str()));
        let key = Key::new("report", &parts);
        Ok(Plan { design, registers: design.registers(), blocks, key })
    }

    /// A synthesised block, from the cache if the cache has it.
    pub(crate) fn netlist(
        &self,
        plan: &Plan<'_>,
        block: usize,
        cache: &Cache,
        stop: &AtomicBool,
    ) -> Result<Netlist, Error> {
        let (block, key) = &plan.blocks[block];
        cache.kept(key, |_| true, || self.synthesise(block, &plan.registers, stop))
    }

    /// The synthesised top module of a design, and its units by name.
    pub(crate) fn netlists(
        &self,
        plan: &Plan<'_>,
        cache: &Cache,
        stop: &AtomicBool,
    ) -> Result<(Netlist, BTreeMap<String, Netlist>), Error> {
        let mut units = BTreeMap::new();
        for (number, (block, _)) in plan.blocks.iter().enumerate() {
            units.insert(block.module.clone(), self.netlist(plan, number, cache, stop)?);
        }
        let top = units.remove(plan.design.top());
        let top = top.ok_or_else(|| ToolError::unexpected("yosys", "no top module", "one"))?;
        Ok((top, units))
    }

    /// The report of a design whose blocks are synthesised.
    fn report(&self, plan: &Plan<'_>, cache: &Cache, stop: &AtomicBool) -> Result<Report, Error> {
        let Plan { design, registers, .. } = plan;
        let (top, units) = self.netlists(plan, cache, stop)?;
        let groups = design.groups();
        let attribution = Attribution::new(&top, &units, &self.library, &groups, registers);
        let areas = attribution.areas(&units, &self.library);
        let flip_flops = attribution.flip_flops();
        let slowest = self.slowest(&top, &units, &attribution, &flip_flops, &groups, stop)?;

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
            design: design.name.clone(),
            setting: self.setting(),
            flip_flops: flip_flops.iter().sum(),
            memory_bits: design.memory_bits,
            kilo_gates: thousandths(area.total / self.library.nand2_area() / 1000.0),
            clock_mhz: thousandths(1000.0 / slowest.ns),
            area_period: thousandths(area.total / 1e6 * slowest.ns),
            area,
            slowest,
            stages,
            power: None,
        })
    }

    /// The tools, the library and the period, for reports.
    pub fn setting(&self) -> Setting {
        Setting {
            synthesis: self.yosys.version.clone(),
            timing: self.sta.version.clone(),
            library: self.library.name.clone(),
            nand2: self.library.nand2.clone(),
            buffer: self.library.buffer.clone(),
            load_ff: self.library.load,
            period_ns: self.period,
            unit_period_ns: self.unit_period,
        }
    }

    /// The slowest path that ends in each group of cells.
    fn slowest(
        &self,
        top: &Netlist,
        units: &BTreeMap<String, Netlist>,
        attribution: &Attribution<'_>,
        flip_flops: &[u64],
        groups: &[String],
        stop: &AtomicBool,
    ) -> Result<Vec<Option<Path>>, Error> {
        let registers = (0..groups.len()).filter(|group| flip_flops[*group] > 0).map(Some);
        let ends: Vec<Option<usize>> = registers.chain([None]).collect();

        let text = structural::design(top, units, |index| structural::cell_name(index, &attribution.roles[index]));
        let script = timing::script(&top.module, &self.library, self.period, &ends);
        let said = self.analyse(&top.module, &text, &script, MAX_STA_OUTPUT, stop)?;
        let found = timing::paths(&String::from_utf8_lossy(&said), ends.len())?;

        let mut slowest: Vec<Option<Path>> = vec![None; groups.len()];
        for (end, raw) in ends.into_iter().zip(found) {
            let Some(path) = raw.map(|raw| named_path(&raw, top, attribution)) else { continue };
            let known = &mut slowest[end.unwrap_or(attribution.port_group())];
            if known.as_ref().is_none_or(|known| known.ns < path.ns) {
                *known = Some(path);
            }
        }
        Ok(slowest)
    }

    /// OpenSTA's output, of at most `limit` bytes, for a script about a netlist.
    pub(crate) fn analyse(
        &self,
        top: &str,
        netlist: &str,
        script: &str,
        limit: u64,
        stop: &AtomicBool,
    ) -> Result<Vec<u8>, ToolError> {
        let folder = temporary_folder()?;
        let folder = folder.path();
        write(&folder.join(timing::NETLIST), netlist)?;
        write(&folder.join(timing::LIBRARY), &self.library.text)?;
        write(&folder.join(timing::SCRIPT), script)?;
        self.sta.run(folder, timing::SCRIPT, timing::LOG, top, stop)?;
        read_within(&folder.join(timing::LOG), limit)
    }
}

/// A design, and the cache keys of its results.
pub(crate) struct Plan<'d> {
    pub design: &'d Design,
    pub registers: BTreeMap<String, RegisterKind>,
    pub blocks: Vec<(Block, Key)>,
    pub key: Key,
}

/// The blocks that are not in the cache, as plans and indices into their blocks. A block that several designs share
/// appears once. Blocks that are not units come first, because they take longest.
fn new_blocks<'p, 'd>(plans: &[&'p Plan<'d>], cache: &Cache) -> Vec<(&'p Plan<'d>, usize)> {
    let mut seen = HashSet::new();
    let mut new = Vec::new();
    for plan in plans {
        let unknown = |(_, (_, key)): &(usize, &(Block, Key))| !cache.has(key) && seen.insert(key.clone());
        new.extend(plan.blocks.iter().enumerate().filter(unknown).map(|(number, _)| (*plan, number)));
    }
    new.sort_by_key(|(plan, number)| plan.blocks[*number].0.is_unit);
    new
}

/// A path with the names of registers and units in place of cell names.
fn named_path(raw: &RawPath, top: &Netlist, attribution: &Attribution<'_>) -> Path {
    let word = |pin: &str| {
        let cell = pin.split('/').next().unwrap_or_default();
        let Some(index) = structural::cell_index(cell) else { return format!("port {cell}") };
        match attribution.roles.get(index) {
            Some(CellRole::Register { .. } | CellRole::ClockGate { .. }) => register_name(&top.cells[index].name),
            Some(CellRole::Unit { .. }) => top.cells[index].name.rsplit('.').next().unwrap_or_default().to_string(),
            Some(CellRole::Gate) | None => "gates".to_string(),
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

/// The name of a stage by its instance: `u_stage_3` is stage 3, `u_stage_3_1` stage 3.1.
pub(crate) fn stage_name(instance: &str) -> String {
    let name = instance.strip_prefix("u_").unwrap_or(instance);
    match name.strip_prefix("stage_") {
        Some(number) => format!("stage {}", number.replace('_', ".")),
        None => name.replace('_', " "),
    }
}

/// The name of a register by its flattened name: `u_stage_3.num_4_q[7]` is num_4_q[7] of stage 3.
fn register_name(flat: &str) -> String {
    match flat.split_once('.') {
        Some((instance, register)) => format!("{} {register}", stage_name(instance)),
        None => flat.to_string(),
    }
}
