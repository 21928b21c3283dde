//! Runs jobs on the functional model, the cycle-exact model and the netlist, and requires equal outcomes.

use raypath::model::{Functional, Shape, WordModel, Words};
use raypath::ops::{Aabb, Binary32, Job, Num, Outcome, Ray, RayBoxInput, Rules};
use raypath::rtl::Config;
use raypath::sim::Datapath;
use raypath::sim::engine::{CycleEngine, Engine, NetlistEngine, drive};
use raypath::sim::traffic::Traffic;
use std::cell::RefCell;
use std::collections::HashMap;

pub type Ray32 = Ray<Binary32>;
pub type Box32 = Aabb<Binary32>;
pub const INF: f32 = f32::INFINITY;

/// The outcomes of `jobs` after a reset, equal in the functional model, the cycle-exact model and the netlist.
pub fn answers(rules: Rules, jobs: &[Job]) -> Vec<Outcome> {
    answers_under(rules, jobs, &Traffic::always())
}

/// The same, with bubbles and stalls.
pub fn answers_under(rules: Rules, jobs: &[Job], traffic: &Traffic) -> Vec<Outcome> {
    let mut functional = Functional::new(rules);
    let expected: Vec<Outcome> = jobs.iter().map(|job| functional.run(job)).collect();
    let in_words: Vec<Words> = jobs.iter().map(words).collect();
    let check = |name: &str, engine: &mut dyn Engine| {
        let mut came_out = 0;
        drive(engine, in_words.iter(), &mut traffic.clone(), |i, outcome| {
            assert_eq!(
                outcome.paper_outcome(),
                Some(expected[i]),
                "{name} and functional model, job {i}: {:?}",
                jobs[i]
            );
            came_out += 1;
            true
        });
        assert_eq!(came_out, jobs.len(), "{name} lost or repeated jobs");
    };
    check("cycle model", &mut CycleEngine::new(model(rules), &Shape::default()));
    with_netlist(rules, |netlist| check("netlist", &mut ProperOnly(netlist)));
    expected
}

/// The functional model of the engines.
pub fn model(rules: Rules) -> WordModel {
    Datapath::paper(Config::DEFAULT.rules(rules)).model()
}

/// A job in the form of the engines.
pub fn words(job: &Job) -> Words {
    thread_local! {
        static MODEL: WordModel = model(Rules::Paper);
    }
    MODEL.with(|model| model.paper_job(job)).unwrap()
}

/// An engine with jobs and outcomes in their own types.
pub struct Typed<'e>(pub &'e mut dyn Engine);

#[derive(Debug, PartialEq)]
pub struct Shown {
    pub input_ready: bool,
    pub output: Option<Outcome>,
}

impl Typed<'_> {
    pub fn present(&mut self, job: &Job) {
        self.0.present(&words(job));
    }
    pub fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let raypath::sim::engine::Shown { input_ready, output } = self.0.cycle(input_valid, output_ready);
        Shown { input_ready, output: output.and_then(|outcome| outcome.paper_outcome()) }
    }
    pub fn reset(&mut self) {
        self.0.reset();
    }
}

/// Every engine with time, from a reset on.
pub fn on_engines(rules: Rules, scenario: impl Fn(&mut Typed<'_>)) {
    with_netlist(rules, |netlist| scenario(&mut Typed(netlist)));
    scenario(&mut Typed(&mut CycleEngine::new(model(rules), &Shape::default())));
}

pub fn answer(rules: Rules, job: Job) -> Outcome {
    answers(rules, &[job])[0]
}

/// Runs a function on the netlist of these rules after a reset. Each thread compiles the netlist once.
pub fn with_netlist<T>(rules: Rules, f: impl FnOnce(&mut NetlistEngine) -> T) -> T {
    thread_local! {
        static NETLISTS: RefCell<HashMap<Rules, NetlistEngine>> = RefCell::default();
    }
    NETLISTS.with_borrow_mut(|netlists| {
        let netlist = netlists.entry(rules).or_insert_with(|| {
            let config = Config::DEFAULT.rules(rules);
            NetlistEngine::new(model(rules), config, |_| false).unwrap()
        });
        netlist.reset();
        f(netlist)
    })
}

/// Checks the raw ports of the netlist, because outcomes compare all NaNs as equal: every NaN is canonical, and the
/// ports of other operations are zero.
struct ProperOnly<'e>(&'e mut NetlistEngine);

impl Engine for ProperOnly<'_> {
    fn present(&mut self, job: &Words) {
        self.0.present(job);
    }
    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> raypath::sim::engine::Shown {
        let shown = self.0.cycle(input_valid, output_ready);
        let improper: Vec<String> = shown.output.iter().flat_map(|outcome| self.0.improper_outputs(outcome)).collect();
        assert!(improper.is_empty(), "{improper:?}");
        shown
    }
    fn reset(&mut self) {
        self.0.reset();
    }
}

/// All numbers of an outcome.
pub fn numbers(outcome: &Outcome) -> Vec<Num<Binary32>> {
    match outcome {
        Outcome::Triangle(o) => vec![o.t_num, o.t_denom],
        Outcome::Quadbox(o) => o.tmin.to_vec(),
        Outcome::Euclidean(o) => vec![o.euclidean_accumulator],
        Outcome::Angular(o) => vec![o.angular_dot_product, o.angular_norm],
    }
}

/// The three output fields of a quadbox job, by position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hits {
    pub hit: [bool; 4],
    /// As bits, so −0 differs from +0.
    pub tmin: [u32; 4],
    pub index: [u32; 4],
}

pub fn hits(outcome: &Outcome) -> Hits {
    let Outcome::Quadbox(o) = outcome else { panic!("no quadbox outcome: {outcome:?}") };
    Hits { hit: o.is_intersect.to_array(), tmin: o.tmin.map(Num::to_bits), index: o.box_index.map(u32::from) }
}

pub fn quadbox(ray: Ray32, aabb: [Box32; 4]) -> Job {
    Job::Quadbox(RayBoxInput { ray, aabb })
}

/// The distance at which the ray enters one box, as bits; `None` for a miss. The job has the box four times.
pub fn entry(rules: Rules, ray: Ray32, aabb: Box32) -> Option<u32> {
    let hits = hits(&answer(rules, quadbox(ray, [aabb; 4])));
    assert!(hits.hit == [hits.hit[0]; 4] && hits.tmin == [hits.tmin[0]; 4], "four equal boxes differ: {hits:?}");
    if !hits.hit[0] {
        assert_eq!(hits.tmin[0], INF.to_bits(), "a miss reports +∞");
    }
    hits.hit[0].then_some(hits.tmin[0])
}

/// The result of [`entry`] for a hit at this distance.
pub fn at(distance: f32) -> Option<u32> {
    Some(distance.to_bits())
}

/// The ray with all derived fields.
pub fn ray(origin: [f32; 3], direction: [f32; 3], extent: f32) -> Ray32 {
    Ray::new(origin, direction, extent).unwrap()
}

/// A ray from 0 whose inverse direction is 1, and a box with these bounds, which are then the slab distances.
pub fn slabs(near: [f32; 3], far: [f32; 3], extent: f32) -> (Ray32, Box32) {
    (ray([0.0; 3], [1.0; 3], extent), Aabb::new(near, far))
}
