//! Every configuration: its netlist in every cycle like the cycle-exact model, every outcome like the functional model,
//! and as fast as is promised.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath::check::{Timing, lockstep, timing};
use raypath::engine::{CycleEngine, Engine, NetlistEngine, drive};
use raypath::format::Format;
use raypath::jobs::random;
use raypath::model::Model;
use raypath::models::{Visitor, with_model};
use raypath::ops::{JobKind, Rules};
use raypath::rtl::{Config, Control, Encoding, Lanes, Sharing, UnitLatency};
use raypath::traffic::{Cycle, Traffic};

/// Configurations: every combination of these values.
struct Space {
    rules: &'static [Rules],
    lanes: &'static [Lanes],
    formats: &'static [&'static str],
    io: &'static [Encoding],
    registers: &'static [Encoding],
    control: &'static [Control],
    sharing: &'static [Sharing],
    unit_latency: &'static [UnitLatency],
}

/// The default alone.
const DEFAULT: Space = Space {
    rules: &[Rules::Paper],
    lanes: &[Lanes::Sixteen],
    formats: &["fp32"],
    io: &[Encoding::Ieee],
    registers: &[Encoding::Recoded],
    control: &[Control::Skid],
    sharing: &[Sharing::Union],
    unit_latency: &[UnitLatency::One],
};

const RULES: &[Rules] = &[Rules::Paper, Rules::Chisel];
const FEW_AND_MANY_LANES: &[Lanes] = &[Lanes::None, Lanes::Two, Lanes::Sixteen, Lanes::SixtyFour];

#[test]
fn lanes_and_rules() {
    Space { lanes: Lanes::ALL, rules: RULES, ..DEFAULT }.check();
}

/// Table VI, complete: 28 configurations.
#[test]
fn encodings_at_ports_and_in_registers() {
    Space { io: Encoding::ALL, registers: Encoding::ALL, lanes: Lanes::ALL, ..DEFAULT }.check();
}

#[test]
fn control_and_sharing_and_unit_latency_without_distances() {
    let lanes = &[Lanes::None];
    Space {
        rules: RULES,
        lanes,
        control: Control::ALL,
        sharing: Sharing::ALL,
        unit_latency: UnitLatency::ALL,
        ..DEFAULT
    }
    .check();
}

#[test]
fn control_and_sharing_and_unit_latency_with_distances() {
    let lanes = &[Lanes::Two, Lanes::Sixteen, Lanes::SixtyFour];
    Space { lanes, control: Control::ALL, sharing: Sharing::ALL, unit_latency: UnitLatency::ALL, ..DEFAULT }.check();
}

/// Encodings meet everything else that changes what a register is.
#[test]
fn encodings_with_every_control_and_unit_latency() {
    let (lanes, registers) = (&[Lanes::Four], &[Encoding::Ieee]);
    let space = Space { lanes, registers, io: Encoding::ALL, sharing: Sharing::ALL, ..DEFAULT };
    Space { control: Control::ALL, unit_latency: UnitLatency::ALL, ..space }.check();
}

/// From the smallest format to the largest.
#[test]
fn formats() {
    let formats = &["tf32", "bf16", "fp16", "e3s3", "e4s4", "e5s3", "e11s24"];
    Space { formats, io: Encoding::ALL, registers: Encoding::ALL, ..DEFAULT }.check();
}

#[test]
fn formats_with_every_control_and_unit_latency() {
    let (formats, lanes) = (&["bf16", "e3s3"], FEW_AND_MANY_LANES);
    Space { formats, lanes, control: Control::ALL, unit_latency: UnitLatency::ALL, ..DEFAULT }.check();
}

impl Space {
    fn check(self) {
        for (seed, config) in (1..).zip(self.configs()) {
            with_model(config, Check { config, seed });
        }
    }

    fn configs(&self) -> Vec<Config> {
        let mut configs = vec![Config::DEFAULT];
        vary(&mut configs, self.lanes, |config, lanes| config.lanes = lanes);
        vary(&mut configs, self.rules, |config, rules| config.rules = rules);
        vary(&mut configs, self.formats, |config, name| config.format = name.parse().expect("a format"));
        vary(&mut configs, self.io, |config, io| config.io = io);
        vary(&mut configs, self.registers, |config, registers| config.registers = registers);
        vary(&mut configs, self.control, |config, control| config.control = control);
        vary(&mut configs, self.sharing, |config, sharing| config.sharing = sharing);
        vary(&mut configs, self.unit_latency, |config, latency| config.unit_latency = latency);
        configs
    }
}

/// Each of the configurations with each of a parameter's values.
fn vary<T: Copy>(configs: &mut Vec<Config>, values: &[T], set: impl Fn(&mut Config, T)) {
    let with = |config: &Config, value: T| {
        let mut config = *config;
        set(&mut config, value);
        config
    };
    *configs = configs.iter().flat_map(|config| values.iter().map(|&value| with(config, value))).collect();
}

/// What is asked of a configuration.
struct Check {
    config: Config,
    seed: u64,
}

impl Visitor for Check {
    type Answer = ();

    fn visit<M: Model>(self, model: M) {
        let config = self.config;
        let mut netlist =
            NetlistEngine::new(model.clone(), config, |_| false).unwrap_or_else(|error| panic!("{config}: {error}"));
        self.answers_like_the_models(&mut netlist, &model);
        self.keeps_step_through_resets(&mut netlist, &model);
        self.is_as_fast_as_promised(&mut netlist, &model);
    }
}

impl Check {
    fn jobs<M: Model>(&self, model: &M, kinds: &[JobKind]) -> impl Iterator<Item = M::Job> + use<M> {
        random(model, self.config.format, self.seed, kinds)
    }

    /// Random and edge jobs under random handshakes.
    fn answers_like_the_models<M: Model>(&self, netlist: &mut NetlistEngine<M>, model: &M) {
        const JOBS: usize = 3000;
        let (config, kinds) = (self.config, self.config.kinds());
        let jobs = self.jobs(model, kinds).take(JOBS);
        let found = lockstep(netlist, model.clone(), jobs, &mut Traffic::random(self.seed), |_| true);
        assert_eq!((found.jobs, found.different), (JOBS, 0), "{config}: {:#?}", found.differences);
        assert!(kinds.iter().all(|&kind| found.by_kind[kind as usize] > JOBS / 6), "{config}: {:?}", found.by_kind);
        assert!(found.stalled > 100, "{config}: {} cycles stalled", found.stalled);
    }

    /// Resets at any moment, with jobs of all kinds in flight; the ports are full of other jobs while none is offered.
    fn keeps_step_through_resets<M: Model>(&self, netlist: &mut NetlistEngine<M>, model: &M) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut traffic = Traffic::random(self.seed);
        let mut modelled = CycleEngine::new(model.clone(), netlist.shape());
        let mut jobs = self.jobs(model, self.config.kinds());
        let (mut resets, mut left) = (0, 0);
        netlist.reset();
        for cycle in 0..3000 {
            if rng.random_bool(0.005) {
                netlist.reset();
                modelled.reset();
                resets += 1;
            }
            let job = jobs.next().expect("an endless stream");
            netlist.present(&job);
            modelled.present(&job);
            let Cycle { offers, takes: output_ready, .. } = traffic.next_cycle();
            let shown = netlist.cycle(offers, output_ready);
            assert_eq!(shown, modelled.cycle(offers, output_ready), "{}, cycle {cycle}", self.config);
            left += usize::from(shown.output.is_some() && output_ready);
        }
        assert!(resets > 3 && left > 100, "{}: {resets} resets, {left} jobs", self.config);
    }

    /// Latency 12 where units take one step. One job a cycle, but for beats of one accumulator, which follow each other
    /// as fast as an addition takes.
    fn is_as_fast_as_promised<M: Model>(&self, netlist: &mut NetlistEngine<M>, model: &M) {
        let (config, kinds) = (self.config, self.config.kinds());
        let (latency, unit_latency) = (netlist.shape().latency as u64, config.unit_latency.stages());
        assert!(if unit_latency == 1 { latency == 12 } else { latency > 12 }, "{config}: latency {latency}");
        for &kind in kinds {
            let sums = matches!(kind, JobKind::Euclidean | JobKind::Angular);
            let initiation_interval = if sums { unit_latency.into() } else { 1 };
            assert_eq!(netlist.shape().interval(kind) as u64, initiation_interval, "{config}, {kind}");
            let job = self.jobs(model, &[kind]).next().expect("an endless stream");
            let measured = timing(netlist, &job);
            assert_eq!(measured, Some(Timing { latency, initiation_interval }), "{config}, {kind}");
        }
        // No kind comes again within as many cycles as an addition takes: nobody waits.
        const ROUNDS: usize = 50;
        let mut streams: Vec<_> = kinds.iter().map(|&kind| self.jobs(model, &[kind])).collect();
        let round = |_| streams.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>();
        let jobs: Vec<M::Job> = (0..ROUNDS).flat_map(round).collect();
        netlist.reset();
        let run = drive(netlist, jobs.iter(), &mut Traffic::always(), |_, _| true);
        assert_eq!((run.jobs, run.cycles), (jobs.len(), jobs.len() as u64 + latency), "{config}: mixed jobs");
    }
}

/// The combinations are what they seem to be.
#[test]
fn a_space_has_every_combination_once() {
    let space = Space { lanes: Lanes::ALL, formats: &["fp32", "fp16"], control: Control::ALL, ..DEFAULT };
    let configs = space.configs();
    assert_eq!(configs.len(), 28);
    for (index, config) in configs.iter().enumerate() {
        assert!(!configs[..index].contains(config), "{config}");
    }
    let last =
        Config { lanes: Lanes::SixtyFour, format: Format::BINARY16, control: Control::Credit, ..Config::DEFAULT };
    assert_eq!((configs[0].lanes, configs.last()), (Lanes::None, Some(&last)));
    assert_eq!(DEFAULT.configs(), [Config::DEFAULT]);
}
