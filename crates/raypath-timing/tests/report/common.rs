//! A simulated run with all features of a recording: all kinds of jobs, fetches, stalls, an accumulator loop.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Control, CycleModel, Functional, Loop, Shape};
use raypath_ops::{Job, JobKind, Outcome, Rules};
use raypath_timing::report::{Image, Recorder, Recording, StageUse, Table, UnitUse};
use raypath_timing::{Action, Agent, Environment, Sink, Timing, simulate};

/// A ray that visits nodes, or a query of vectors.
pub struct Walk {
    rng: ChaCha8Rng,
    left: u32,
    distances: bool,
    beats: u32,
    waits: bool,
    fetched: bool,
}

impl Walk {
    /// Whether the agent is a query.
    pub fn distances(&self) -> bool {
        self.distances
    }

    pub fn new(seed: u64, visits: u32) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let distances = rng.random_bool(0.3);
        Self { rng, left: visits, distances, beats: 0, waits: false, fetched: false }
    }
}

impl Agent<Functional> for Walk {
    fn next_action(&mut self) -> Action<Job> {
        if self.waits {
            return Action::Wait;
        }
        if self.left == 0 {
            return Action::Done;
        }
        if !self.fetched {
            self.fetched = true;
            self.beats = if self.distances { 3 } else { 1 };
            return Action::Fetch;
        }
        self.beats -= 1;
        self.waits = self.beats == 0;
        let kind = match (self.distances, self.rng.random_bool(0.7)) {
            (true, _) => JobKind::Euclidean,
            (false, true) => JobKind::Quadbox,
            (false, false) => JobKind::Triangle,
        };
        Action::Issue(Job::from_ports(kind, |_| 0))
    }
    fn receive(&mut self, _: &Outcome) {
        if self.waits {
            (self.waits, self.fetched) = (false, false);
            self.left -= 1;
        }
    }
}

pub fn shape(control: Control) -> Shape {
    let loops = vec![Loop { opcode: JobKind::Euclidean.opcode(), first: 9, last: 10 }];
    Shape { latency: 12, control, interval: 1, loops }
}

/// A run with a recorder of the first `jobs` jobs from cycle `from` on.
pub fn run(control: Control, from: u64, jobs: usize, stalls: f64) -> (Timing, Recorder) {
    let agents = (0..400).map(|seed| Walk::new(seed, 1 + jobs as u32 / 100));
    let sink = if stalls > 0.0 { Sink::Stalls { probability: stalls, seed: 1 } } else { Sink::Always };
    let environment = Environment { in_flight: 24, memory_latency: 40, sink };
    let shape = shape(control);
    let pipeline = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &shape);
    let mut recorder = Recorder::new("ray", shape.latency, from, jobs);
    let timing = simulate(agents, &environment, pipeline, &mut recorder, &|_| true).expect("runs");
    (timing, recorder)
}

/// A recording with every section.
pub fn recording(control: Control, jobs: usize, stalls: f64) -> Recording {
    let (timing, recorder) = run(control, 0, jobs, stalls);
    let what =
        ["", "each vertex - origin", "every box bound - origin", "a - b, zero where masked off", "sums i + (i + half)"];
    let utilisation = (1..=12).map(|number| StageUse {
        number,
        titles: (0..4).map(|opcode| what[(number + opcode) % what.len()].to_string()).collect(),
        units: [("adder", 24), ("multiplier", 16), ("comparator", 40)]
            .into_iter()
            .enumerate()
            .filter(|(index, _)| (number + index) % 3 != 0)
            .map(|(index, (name, count))| {
                let by_operation: Vec<f64> =
                    (0..4).map(|op| f64::from((number as u32 * 7 + op * 5) % 11) / 40.0).collect();
                UnitUse { name: name.to_string(), count: count + index, total: by_operation.iter().sum(), by_operation }
            })
            .collect(),
    });
    Recording {
        title: "A cornell box & 24 rays <in flight>".to_string(),
        configuration: vec![
            ("preset".to_string(), "paper".to_string()),
            ("control".to_string(), format!("{control:?}").to_lowercase()),
            ("memory latency".to_string(), "40 cycles".to_string()),
            ("in flight".to_string(), "24 rays".to_string()),
        ],
        counts: vec![
            ("cycles".to_string(), timing.cycles.to_string()),
            ("jobs".to_string(), timing.total_jobs().to_string()),
            ("jobs per cycle".to_string(), format!("{:.4}", timing.jobs_per_cycle())),
            ("rays a second at 500 MHz".to_string(), format!("{:.2} million", timing.rates(500.0).agents / 1e6)),
        ],
        operations: JobKind::ALL.map(|kind| kind.name().to_string()).to_vec(),
        utilisation: utilisation.collect(),
        window: recorder.window(),
        // 5 × 3 pixels.
        image: Some(Image { title: "Rendered picture".to_string(), png: include_bytes!("picture.png").to_vec() }),
        sweep: None,
        tables: vec![Table {
            title: "Recall".to_string(),
            head: vec!["k".to_string(), "recall".to_string()],
            rows: vec![vec!["1".to_string(), "0.981".to_string()], vec!["10".to_string(), "0.954".to_string()]],
        }],
    }
}
