//! The regression checks of a configuration's netlist.

use crate::engine::{CycleEngine, Engine, NetlistEngine, Shown, drive};
use crate::jobs::random;
use crate::lockstep::{Timing, lockstep, timing};
use crate::traffic::{Cycle, Traffic};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_hdl::Probe;
use raypath_model::{WordModel, Words};
use raypath_ops::{JobKind, Port, PortKind, Rounding};
use raypath_rtl::{Config, Control, Encoding, Interval, Lanes, Multiplier, Sharing, UnitLatency, UnitSharing};

/// The configurations whose modules get faults in `raypath verify mutation`: the default, and small ones with the modules
/// that it lacks, so that each format, control, sharing, latency and encoding has its share.
pub const CONFIGS: [Config; 10] = [
    Config::DEFAULT,
    Config::DEFAULT.lanes(Lanes::Two).control(Control::Credit),
    Config::DEFAULT.lanes(Lanes::Two).unit_latency(UnitLatency::TWO),
    Config::DEFAULT.lanes(Lanes::Two).control(Control::Credit).unit_latency(UnitLatency::TWO),
    Config::DEFAULT.lanes(Lanes::Two).interval(Interval::Four),
    Config::DEFAULT
        .lanes(Lanes::Two)
        .control(Control::Credit)
        .interval(Interval::Two)
        .unit_latency(UnitLatency { sums: 5, products: 3 })
        .multiplier(Multiplier::Dsp),
    Config::DEFAULT
        .lanes(Lanes::None)
        .control(Control::Credit)
        .unit_latency(UnitLatency { sums: 7, products: 5 })
        .delay_lines(4)
        .multiplier(Multiplier::Dsp),
    Config::DEFAULT.lanes(Lanes::None).format(Format::BINARY16).sharing(Sharing::Segregated),
    Config::DEFAULT.lanes(Lanes::None).format(Format::TF32).control(Control::Credit).registers(Encoding::Ieee),
    Config::DEFAULT
        .lanes(Lanes::Two)
        .format(Format::BFLOAT16)
        .unit_latency(UnitLatency::THREE)
        .units(UnitSharing::Disjoint),
];

/// The regression checks of a configuration, reproducible by `seed`.
#[derive(Debug, Clone, Copy)]
pub struct RegressionChecks {
    /// The configuration.
    pub config: Config,
    /// The seed of jobs, traffic and resets.
    pub seed: u64,
    /// The number of jobs in the longest stream.
    pub jobs: usize,
}

/// A check that failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailedCheck {
    /// The check's name.
    pub check: &'static str,
    /// What it found.
    pub what: String,
}

impl RegressionChecks {
    /// A number of jobs that finds nearly every fault. `raypath verify mutation` and its tests use it.
    pub const THOROUGH: usize = 20_000;

    /// Whether the checks observe the signal of this name, which must then be observable in the compiled netlist.
    pub fn observes(name: &str) -> bool {
        is_number_register(name)
    }

    /// Runs the checks until one fails. `model` is the configuration's model, its accumulators at zero; the netlist may
    /// be in any state.
    ///
    /// # Errors
    /// The check that failed.
    pub fn check(self, netlist: &mut NetlistEngine, model: &WordModel) -> Result<(), FailedCheck> {
        let named = |check| move |what| FailedCheck { check, what };
        self.agrees_with_the_models(netlist, model).map_err(named("lockstep"))?;
        self.holds_canonical_words(netlist, model).map_err(named("canonical words"))?;
        self.agrees_through_resets(netlist, model).map_err(named("resets"))?;
        self.has_the_specified_timing(netlist, model).map_err(named("timing"))
    }

    /// Random jobs. In some, numbers have few significant bits, so that results are ties.
    fn jobs(self, model: &WordModel, kinds: &[JobKind]) -> impl Iterator<Item = Words> + use<> {
        let format = self.config.semantics.format;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let model = model.clone();
        random(&model, format, self.seed, kinds).map(move |job| {
            if rng.random_bool(SHORT) {
                shortened(&model, format, &job, rng.random_range(1..=format.significand() / 2))
            } else {
                job
            }
        })
    }

    /// Lockstep with the models, for random and edge jobs under random handshakes, with a few resets.
    fn agrees_with_the_models(self, netlist: &mut NetlistEngine, model: &WordModel) -> Result<(), String> {
        // Resets lose the jobs inside.
        let (kinds, count) = (self.config.kinds(), self.jobs + 4 * netlist.shape().capacity());
        let jobs = self.jobs(model, kinds).take(count);
        let mut traffic = Traffic::random(self.seed).with_resets(RESETS);
        netlist.restart_randomly(self.seed);
        let found = lockstep(netlist, model.clone(), jobs, &mut traffic, |_| true);
        expect((found.jobs + found.lost, found.different) == (count, 0), || {
            format!("{} jobs and {} that were lost: {:#?}", found.jobs, found.lost, found.differences)
        })?;
        let is_mixed = kinds.iter().all(|&kind| found.jobs_of(kind) > self.jobs / 6);
        expect(is_mixed, || format!("jobs by opcode: {:?}", found.by_opcode))?;
        expect(found.stalled > 100, || format!("{} cycles stalled", found.stalled))
    }

    /// With recoded registers, each register holds a canonical word in every cycle. Zero, with which they
    /// begin, is one. The first jobs fill the registers inside units, whose zeros may stand for no value.
    fn holds_canonical_words(self, netlist: &mut NetlistEngine, model: &WordModel) -> Result<(), String> {
        let count = self.jobs;
        if self.config.microarchitecture.registers != Encoding::Recoded {
            return Ok(());
        }
        netlist.restart_with_zeros();
        let first = self.jobs(model, self.config.kinds()).take(FIRST_JOBS);
        drive(netlist, first, &mut Traffic::random(self.seed), |_, _| true);
        let mut watched = WatchedNetlist::new(netlist, self.config.semantics.format);
        let registers = watched.registers();
        expect(registers > 10, || format!("{registers} number registers can be observed"))?;
        let jobs = self.jobs(model, self.config.kinds()).take(count);
        let run = drive(&mut watched, jobs, &mut Traffic::random(self.seed), |_, _| true);
        expect(run.jobs == count, || format!("{} of {count} jobs", run.jobs))?;
        watched.found.map_or(Ok(()), Err)
    }

    /// Lockstep with the cycle-exact model through resets at random cycles. The input ports hold other jobs while no
    /// job is offered.
    fn agrees_through_resets(self, netlist: &mut NetlistEngine, model: &WordModel) -> Result<(), String> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut traffic = Traffic::random(self.seed);
        let mut modelled = CycleEngine::new(model.clone(), netlist.shape());
        let (mut resets, mut left) = (0, 0);
        netlist.restart_randomly(!self.seed);
        for (cycle, job) in self.jobs(model, self.config.kinds()).take(3000).enumerate() {
            if rng.random_bool(0.005) {
                netlist.reset();
                modelled.reset();
                resets += 1;
            }
            netlist.present(&job);
            modelled.present(&job);
            let Cycle { offers, takes: output_ready, .. } = traffic.next_cycle();
            let (shown, expected) = (netlist.cycle(offers, output_ready), modelled.cycle(offers, output_ready));
            expect(shown == expected, || {
                format!("cycle {cycle}: shows {shown:?}, the cycle-exact model {expected:?}")
            })?;
            left += usize::from(shown.output.is_some() && output_ready);
        }
        let rounds = left * self.config.microarchitecture.interval.cycles() as usize;
        expect(resets > 3 && rounds > 100, || format!("{resets} resets, {left} jobs"))
    }

    /// Latency 12 if units take one step and stages one round; 10 with sums that round once, unless an operation computes
    /// something in the stages that they save. The initiation interval is the configured one, or the
    /// duration of an addition for distances.
    fn has_the_specified_timing(self, netlist: &mut NetlistEngine, model: &WordModel) -> Result<(), String> {
        let (kinds, unit_latency) = (self.config.kinds(), self.config.microarchitecture.unit_latency);
        let latency = netlist.shape().latency as u64;
        let interval = u64::from(self.config.microarchitecture.interval.cycles());
        let semantics = self.config.semantics;
        let features = semantics.features;
        let is_short = semantics.rounding == Rounding::Sum && !features.range && !features.quantised_boxes;
        let shortest = if is_short { 10 } else { 12 };
        let is_specified =
            if !unit_latency.is_divided() && interval == 1 { latency == shortest } else { latency > shortest };
        expect(is_specified, || format!("latency {latency}"))?;
        for &kind in kinds {
            let sums = matches!(kind, JobKind::Euclidean | JobKind::Angular);
            let initiation_interval = if sums { interval.max(unit_latency.sums.into()) } else { interval };
            let shaped = netlist.shape().interval(kind.opcode()) as u64;
            expect(shaped == initiation_interval, || format!("{kind}: an interval of {shaped}"))?;
            let (measured, specified) = match self.jobs(model, &[kind]).next() {
                Some(job) => (timing(netlist, &job), Timing { latency, initiation_interval }),
                None => continue,
            };
            expect(measured == Some(specified), || format!("{kind}: {measured:?}, expected {specified}"))?;
        }
        // A job of each kind in a round. The next round begins at once, or when the addition for an accumulator is
        // done.
        const ROUNDS: usize = 50;
        let apart = kinds.iter().map(|kind| netlist.shape().interval(kind.opcode()) as u64).max().unwrap_or(0);
        let round_cycles = apart.max(kinds.len() as u64 * interval);
        let mut streams: Vec<_> = kinds.iter().map(|&kind| self.jobs(model, &[kind])).collect();
        let round = |_| streams.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>();
        let jobs: Vec<Words> = (0..ROUNDS).flat_map(round).collect();
        netlist.reset();
        let run = drive(netlist, jobs.iter(), &mut Traffic::always(), |_, _| true);
        let cycles = (ROUNDS as u64 - 1) * round_cycles + (kinds.len() as u64 - 1) * interval + 1 + latency;
        let is_full_speed = (run.jobs, run.cycles) == (jobs.len(), cycles);
        expect(is_full_speed, || format!("mixed jobs: {} in {} cycles", run.jobs, run.cycles))
    }
}

/// The job with all but so many upper bits of each number's fraction at zero.
fn shortened(model: &WordModel, format: Format, job: &Words, bits: u32) -> Words {
    let kept = u64::MAX << (format.significand() - 1 - bits);
    let short = |port: &Port| match port.kind {
        PortKind::Number => job.port(&port.name) & kept,
        PortKind::Flags | PortKind::Word => job.port(&port.name),
    };
    let words: Vec<u64> = model.inputs(job.kind()).iter().map(short).collect();
    model.job_of_words(job.kind(), &words)
}

/// The probability that a job's numbers are short.
const SHORT: f64 = 0.15;
/// The jobs that fill the registers before they are watched.
const FIRST_JOBS: usize = 100;
/// The probability of a reset in a cycle of the longest stream. Accumulators reach large values between them.
const RESETS: f64 = 0.0005;

fn expect(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

/// A netlist as an engine that checks its number registers in every cycle: their recoded words must be canonical. The
/// ports do not show this, because units accept every encoding of a number.
pub struct WatchedNetlist<'n> {
    /// The first word that is not canonical, as a message.
    pub found: Option<String>,
    netlist: &'n mut NetlistEngine,
    format: Format,
    registers: Vec<Register>,
}

struct Register {
    name: String,
    probe: Probe,
    /// The last word, which was canonical.
    held: u64,
}

/// Whether the signal of this hierarchical name is a number register or an accumulator.
pub fn is_number_register(name: &str) -> bool {
    let name = name.rsplit('.').next().unwrap_or(name);
    name.starts_with("num_") && name.ends_with("_q") || name.ends_with("_state_q")
}

impl<'n> WatchedNetlist<'n> {
    /// Watches a netlist with observable number registers. Those of the recoded width of `format` hold recoded words.
    pub fn new(netlist: &'n mut NetlistEngine, format: Format) -> Self {
        let probes = netlist.simulator().probes();
        let recoded = probes.filter(|(name, width, _)| is_number_register(name) && *width == format.recoded_width());
        let zero = format.encode(0);
        let registers =
            recoded.map(|(name, _, probe)| Register { name: name.to_string(), probe, held: zero }).collect();
        Self { found: None, netlist, format, registers }
    }

    /// The number of watched registers.
    pub fn registers(&self) -> usize {
        self.registers.len()
    }

    fn check_registers(&mut self) {
        for register in &mut self.registers {
            let word = self.netlist.simulator().peek(register.probe);
            if word == register.held {
                continue;
            }
            let canonical = self.format.encode(self.format.decode(word));
            if word != canonical {
                let name = &register.name;
                self.found = Some(format!("{name} holds {word:#x}, which is not canonical, expected {canonical:#x}"));
                return;
            }
            register.held = word;
        }
    }
}

impl Engine for WatchedNetlist<'_> {
    fn present(&mut self, job: &Words) {
        self.netlist.present(job);
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let shown = self.netlist.cycle(input_valid, output_ready);
        if self.found.is_none() {
            self.check_registers();
        }
        shown
    }

    fn reset(&mut self) {
        self.netlist.reset();
    }
}
