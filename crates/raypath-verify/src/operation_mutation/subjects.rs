//! The operations that get faults, with jobs and oracles.

use super::evaluate::{Jobs, Values};
use super::expected::{self, Boxes, Entry};
use super::faults::{Fault, faults};
use super::graph::Graph;
use crate::layout::Layout;
use crate::record::root;
use crate::stimuli::{Stimuli, splitmix64};
use crate::{Error, Level};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::Words;
use raypath_ops::operations::{key_compare, octbox, point_in_box, quantised_box, sphere};
use raypath_ops::{
    Angular, AngularMany, AngularOutput, Binary32, Bundle, Culling, Euclidean, EuclideanMany, EuclideanOutput, Flags,
    JobKind, Operation, PortKind, RayBox, RayBoxConservative, RayBoxInput, RayBoxOutput, RayTriangle,
    RayTriangleExtended, RayTriangleExtendedInput, RayTriangleOutput, Rounding, Rules, Word, from_words,
    to_canonical_words,
};
use raypath_oracle::{AnyOperationSpec, added_operation};
use raypath_rtl::{Accumulators, Config, Lanes};
use raypath_sim::Datapath;
use raypath_sim::jobs::random;
use raypath_sim::numbers::edges;
use raypath_sim::transactions::read;

/// An operation, the jobs that its faults run, and the judge of their outcomes.
pub struct Subject {
    pub name: String,
    pub graph: Graph,
    pub faults: Vec<Fault>,
    pub jobs: Jobs,
    /// The values without a fault.
    pub values: Values,
    pub judge: Judge,
    /// What holds for every job, in SMT-LIB: a precondition of the operation.
    pub assumptions: Vec<String>,
    /// Why the oracle refuses a job without a fault. It must not.
    pub refused: Option<String>,
}

/// Who decides whether an outcome is right.
pub enum Judge {
    /// An oracle whose outcomes are exact, and were those without a fault for all jobs: any other outcome is wrong.
    Exact(&'static str),
    /// An oracle that accepts outcomes within bounds.
    Within(AnyOperationSpec),
}

/// The outcome of a job by an oracle, as words at the ports out. It keeps the state of the jobs before.
type Expect = Box<dyn FnMut(&[u64]) -> Vec<u64>>;

const TEXT: &str = "the text, in binary64 rounded once";
const RECORDED: &str = "golden vectors of the original hardware";

impl Subject {
    /// Whether the oracle refuses an outcome of a job.
    pub fn refuses(&self, step: usize, job: usize, outcome: &[u64]) -> bool {
        match &self.judge {
            Judge::Exact(_) => true,
            Judge::Within(spec) => {
                spec.judges(&self.jobs.steps[step][job], outcome).is_some_and(|judged| judged.is_err())
            }
        }
    }

    pub fn oracle(&self) -> &str {
        match &self.judge {
            Judge::Exact(name) => name,
            Judge::Within(spec) => spec.oracle_name().unwrap_or_default(),
        }
    }
}

/// The subjects of a level, with about `count` jobs each.
///
/// # Errors
/// The golden vectors cannot be read.
pub fn all(level: Level, count: usize, seed: u64) -> Result<Vec<Subject>, Error> {
    let maker = Maker { count, seed };
    let paper = Config::DEFAULT;
    let mut subjects = Vec::new();
    let boxes = |rules| RayBox { rules };
    let near = |how| move |job: &_| in_order(job, how);
    subjects.push(maker.by_text("quadbox, paper", paper, &boxes(Rules::Paper), || near(Boxes::Nearest)));
    let bits = |bits| Rules::Bounds(raypath_ops::BoxBits(bits));
    let all_bits: &[u32] = if level == Level::Regression { &[13] } else { &[8, 13, 20, 24] };
    for &count in all_bits {
        let config = paper.rules(bits(count));
        let name = format!("quadbox, bounds of {count} bits");
        subjects.push(maker.by_text(&name, config, &boxes(bits(count)), || near(Boxes::Bits(count))));
    }
    let conservative = paper.conservative(true);
    subjects.push(maker.by_text("quadbox, conservative", conservative, &RayBoxConservative, || near(Boxes::Widened)));
    subjects.push(maker.recorded("quadbox, chisel", &boxes(Rules::Chisel))?);

    for rules in [Rules::Paper, Rules::Chisel] {
        for rounding in [Rounding::Unit, Rounding::Sum] {
            let plain = RayTriangle { rules, rounding };
            let name = format!("triangle, {rules}, rounding {rounding}");
            let config = paper.rules(rules).rounding(rounding);
            subjects.push(match (rules, rounding) {
                (Rules::Chisel, Rounding::Unit) => maker.recorded(&name, &plain)?,
                _ => maker.by_text(&name, config, &plain, || {
                    let options = triangle_options(rules, rounding, Culling::Back, false);
                    move |job: &raypath_ops::RayTriangleInput<Binary32>| {
                        let found = expected::triangle(&options, &extended(job));
                        let raypath_ops::RayTriangleExtendedOutput { t_num, t_denom, triangle_hit, .. } = found;
                        RayTriangleOutput { t_num, t_denom, triangle_hit }
                    }
                }),
            });
        }
        for (culling, range) in [(Culling::Back, true), (Culling::Front, false), (Culling::None, true)] {
            let options = triangle_options(rules, Rounding::Unit, culling, range);
            let config = paper.rules(rules).culling(culling).range(range).facing(true).barycentrics(true);
            let name = format!("triangle with features, {rules}, culling {culling}, range {range}");
            subjects.push(maker.by_text(&name, config, &options, || move |job: &_| expected::triangle(&options, job)));
        }
    }

    maker.distances(Lanes::Sixteen, &mut subjects);
    if level > Level::Regression {
        for &lanes in Lanes::ALL.iter().filter(|lanes| !matches!(lanes, Lanes::None | Lanes::Sixteen)) {
            maker.distances(lanes, &mut subjects);
        }
    }
    let four = paper.accumulators(Accumulators::Four);
    let rounding = Rounding::Unit;
    subjects.push(maker.by_text("euclidean, four accumulators", four, &EuclideanMany::<16, 4, 2> { rounding }, || {
        let mut sums = [0.0; 4];
        move |job: &raypath_ops::BeatManyInput<Binary32, 16, 2>| {
            let sum = &mut sums[u32::from(job.accumulator) as usize];
            euclidean(sum, &job.euclidean, Rounding::Unit)
        }
    }));
    subjects.push(maker.by_text("angular, four accumulators", four, &AngularMany::<8, 4, 2> { rounding }, || {
        let mut sums = [[0.0; 2]; 4];
        move |job: &raypath_ops::BeatManyInput<Binary32, 8, 2>| {
            let sums = &mut sums[u32::from(job.accumulator) as usize];
            angular(sums, &job.euclidean, Rounding::Unit)
        }
    }));

    // The separators are in ascending order, NaNs last.
    let sorted = (1..key_compare::SEPARATORS).map(|next| {
        let [a, b] = [next - 1, next].map(|number| format!("{{separator_{number}}}"));
        format!("(or (fp.isNaN {b}) (fp.leq {a} {b}))")
    });
    subjects.push(Subject { assumptions: sorted.collect(), ..maker.added(&key_compare::KeyCompare) });
    subjects.push(maker.added(&point_in_box::PointInBox));
    subjects.push(maker.quantised());
    subjects.push(maker.added(&sphere::Sphere));
    subjects.push(maker.octbox());
    Ok(subjects)
}

fn triangle_options(rules: Rules, rounding: Rounding, culling: Culling, range: bool) -> RayTriangleExtended {
    RayTriangleExtended { rules, rounding, culling, facing: true, barycentrics: true, range }
}

fn extended(job: &raypath_ops::RayTriangleInput<Binary32>) -> RayTriangleExtendedInput<Binary32> {
    RayTriangleExtendedInput { ray: job.ray, triangle: job.triangle, t_min: 0.0.into() }
}

fn in_order(job: &RayBoxInput<Binary32>, how: Boxes) -> RayBoxOutput<Binary32> {
    four(expected::boxes(&job.ray, &job.aabb, how))
}

fn four(entries: [Entry; 4]) -> RayBoxOutput<Binary32> {
    RayBoxOutput {
        is_intersect: Flags::new(entries.map(|entry| entry.0)),
        tmin: entries.map(|entry| entry.1.into()),
        box_index: entries.map(|entry| Word::truncate(entry.2)),
    }
}

fn euclidean<const N: usize>(
    sum: &mut f32,
    beat: &raypath_ops::Beat<Binary32, N>,
    rounding: Rounding,
) -> EuclideanOutput<Binary32> {
    let now = crate::oracle::add(*sum, expected::squares(beat, rounding));
    *sum = if beat.reset_accum.into() { 0.0 } else { now };
    EuclideanOutput { euclidean_accumulator: now.into(), euclidean_reset_accum: beat.reset_accum }
}

fn angular<const N: usize>(
    sums: &mut [f32; 2],
    beat: &raypath_ops::Beat<Binary32, N>,
    rounding: Rounding,
) -> AngularOutput<Binary32> {
    let products = expected::products(beat, rounding);
    let now = [0, 1].map(|i| crate::oracle::add(sums[i], products[i]));
    *sums = if beat.reset_accum.into() { [0.0; 2] } else { now };
    AngularOutput {
        angular_dot_product: now[0].into(),
        angular_norm: now[1].into(),
        angular_reset_accum: beat.reset_accum,
    }
}

/// Makes subjects with so many jobs.
struct Maker {
    count: usize,
    seed: u64,
}

/// Numbers with rules of their own.
const SPECIAL: [f32; 7] = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1.0, -1.0];

/// Jobs of a step: as many as streams of beats.
const STREAMS: usize = 64;

impl Maker {
    /// A subject with jobs of the campaigns and of the regression tests, half of each, some of them with more special
    /// numbers.
    fn by_text<O: Operation, E: FnMut(&O::Input<Binary32>) -> O::Output<Binary32> + 'static>(
        &self,
        name: &str,
        config: Config,
        operation: &O,
        oracle: impl Fn() -> E,
    ) -> Subject {
        let expect = || -> Expect {
            let mut oracle = oracle();
            Box::new(move |job| {
                let mut words = Vec::new();
                to_canonical_words(&oracle(&from_words(Binary32, job)), &mut words);
                words
            })
        };
        let kind = JobKind::ALL.into_iter().find(|kind| kind.name() == O::NAME).unwrap_or(JobKind::Quadbox);
        let jobs = self.jobs(config, kind);
        exact(name, operation, jobs, TEXT, expect)
    }

    fn jobs(&self, config: Config, paper: JobKind) -> Jobs {
        let model = Datapath::paper(config).model();
        let layout = Layout::of(&model);
        let Some(kind) = model.kind(paper.name()) else { return Jobs::default() };
        let mut stimuli = Stimuli::new(&layout, config, splitmix64(self.seed));
        let mut others = random(&model, config.semantics.format, self.seed, &[paper]);
        let is_number: Vec<bool> = model.inputs(kind).iter().map(|port| port.kind == PortKind::Number).collect();
        let rng = &mut ChaCha8Rng::seed_from_u64(self.seed);
        let mut words = Vec::new();
        let mut job = |number: usize| {
            let job = match others.next().filter(|_| number.is_multiple_of(2)) {
                Some(other) => other,
                None => {
                    stimuli.next_of(paper, &mut words);
                    model.job_of_words(kind, &words)
                }
            };
            // Some jobs get many special numbers: an inverse of zero matters only beside an infinite bound.
            let mut words = job.as_words().to_vec();
            let share = [0.0, 0.0, 0.0, 0.0, 0.1, 0.3][rng.random_range(0..6)];
            for (word, _) in words.iter_mut().zip(&is_number).filter(|(_, is_number)| **is_number) {
                if share > 0.0 && rng.random_bool(share) {
                    *word = SPECIAL[rng.random_range(0..SPECIAL.len())].to_bits().into();
                }
            }
            model.all_inputs(&model.job_of_words(kind, &words))
        };
        let steps = self.count.div_ceil(STREAMS);
        Jobs { steps: (0..steps).map(|step| (0..STREAMS).map(|stream| job(step + stream)).collect()).collect() }
    }

    /// A subject with recorded jobs and outcomes.
    fn recorded<O: Operation>(&self, name: &str, operation: &O) -> Result<Subject, Error> {
        let model = Datapath::paper(Config::DEFAULT).model();
        let path = root().join(format!("crates/raypath/tests/data/golden/{}.txt.gz", O::NAME));
        let recorded = read(&path, model.kind(O::NAME), &model, Config::DEFAULT)
            .map_err(|problem| raypath_tools::ToolError::file(&path, "read", std::io::Error::other(problem)))?;
        let steps = recorded.chunks(STREAMS);
        let jobs: Vec<Vec<Vec<u64>>> =
            steps.map(|step| step.iter().map(|one| model.all_inputs(&one.job)).collect()).collect();
        // The oracles of all places of a step, one after another.
        let expected: Vec<Vec<u64>> = recorded.iter().map(|one| model.all_outputs(&one.expected)).collect();
        let place = std::cell::Cell::new(0);
        let expect = || -> Expect {
            let of_place: Vec<Vec<u64>> =
                expected.iter().skip(place.replace(place.get() + 1)).step_by(STREAMS).cloned().collect();
            let mut outcomes = of_place.into_iter();
            Box::new(move |_| outcomes.next().unwrap_or_default())
        };
        Ok(exact(name, operation, Jobs { steps: jobs }, RECORDED, expect))
    }

    fn distances(&self, lanes: Lanes, subjects: &mut Vec<Subject>) {
        match lanes {
            Lanes::None => {}
            Lanes::Two => self.distances_of::<2, 1>(lanes, subjects),
            Lanes::Four => self.distances_of::<4, 2>(lanes, subjects),
            Lanes::Eight => self.distances_of::<8, 4>(lanes, subjects),
            Lanes::Sixteen => self.distances_of::<16, 8>(lanes, subjects),
            Lanes::ThirtyTwo => self.distances_of::<32, 16>(lanes, subjects),
            Lanes::SixtyFour => self.distances_of::<64, 32>(lanes, subjects),
        }
    }

    fn distances_of<const E: usize, const A: usize>(&self, lanes: Lanes, subjects: &mut Vec<Subject>) {
        for rounding in [Rounding::Unit, Rounding::Sum] {
            let config = Config::DEFAULT.lanes(lanes).rounding(rounding);
            let name = format!("euclidean, {E} lanes, rounding {rounding}");
            subjects.push(self.by_text(&name, config, &Euclidean::<E> { rounding }, || {
                let mut sum = 0.0;
                move |job: &raypath_ops::BeatInput<Binary32, E>| euclidean(&mut sum, &job.euclidean, rounding)
            }));
            let name = format!("angular, {A} lanes, rounding {rounding}");
            subjects.push(self.by_text(&name, config, &Angular::<A> { rounding }, || {
                let mut sums = [0.0; 2];
                move |job: &raypath_ops::BeatInput<Binary32, A>| angular(&mut sums, &job.euclidean, rounding)
            }));
        }
    }

    /// An added operation, whose specification has jobs and an oracle.
    fn added<O: Operation>(&self, operation: &O) -> Subject {
        let (spec, jobs) = self.specified(O::NAME);
        let graph = Graph::of(operation);
        let values = Values::of(&graph, &jobs);
        let mut refused = None;
        for (step, of_step) in jobs.steps.iter().enumerate() {
            for (place, job) in of_step.iter().enumerate() {
                let judged = spec.judges(job, &values.outcome(&graph, step, place));
                refused = refused.or(judged.unwrap_or_else(|| Err("no oracle".to_string())).err());
            }
        }
        let (name, faults, judge) = (O::NAME.to_string(), faults(&graph), Judge::Within(spec));
        Subject { name, graph, faults, jobs, values, judge, assumptions: vec![], refused }
    }

    /// Four quantised boxes.
    fn quantised(&self) -> Subject {
        let (_, jobs) = self.specified(quantised_box::QuantisedBox::NAME);
        let expect = || -> Expect {
            Box::new(|job| {
                let job: quantised_box::QuantisedBoxInput<Binary32> = from_words(Binary32, job);
                words_of(&four(expected::quantised(&job.ray, &job.node)))
            })
        };
        exact(quantised_box::QuantisedBox::NAME, &quantised_box::QuantisedBox, jobs, TEXT, expect)
    }

    /// Eight boxes. Half of the jobs are those of two jobs of four boxes, some of which are hit at infinity.
    fn octbox(&self) -> Subject {
        let (_, mut jobs) = self.specified(octbox::Octbox::NAME);
        let fours = self.jobs(Config::DEFAULT, JobKind::Quadbox);
        for (step, fours) in jobs.steps.iter_mut().zip(fours.steps).skip(1).step_by(2) {
            for place in 0..step.len() {
                let four = |job: &Vec<u64>| -> RayBoxInput<Binary32> { from_words(Binary32, job) };
                let [one, other] = [&fours[place], &fours[(place + 1) % fours.len()]].map(four);
                let aabb = std::array::from_fn(|i| if i < 4 { one.aabb[i] } else { other.aabb[i - 4] });
                step[place] = words_of(&octbox::OctboxInput { ray: one.ray, aabb });
            }
        }
        let expect = || -> Expect {
            Box::new(|job| {
                let job: octbox::OctboxInput<Binary32> = from_words(Binary32, job);
                let entries = expected::boxes(&job.ray, &job.aabb, Boxes::Nearest);
                words_of(&octbox::OctboxOutput {
                    octbox_is_intersect: Flags::new(entries.map(|entry| entry.0)),
                    octbox_tmin: entries.map(|entry| entry.1.into()),
                    octbox_box_index: entries.map(|entry| Word::truncate(entry.2)),
                })
            })
        };
        exact(octbox::Octbox::NAME, &octbox::Octbox, jobs, TEXT, expect)
    }

    fn specified(&self, name: &str) -> (AnyOperationSpec, Jobs) {
        let spec = added_operation(name).unwrap_or_else(|problem| unreachable!("{problem}"));
        let datapath = Datapath::paper(Config::DEFAULT).with_any(spec.operation());
        let model = datapath.model();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let is_number: Vec<bool> = spec.operation().inputs().iter().map(|port| port.kind == PortKind::Number).collect();
        let mut job = || -> Option<Vec<u64>> {
            let kind = model.kind(name)?;
            let job: Words = spec.job(&model, kind, &mut rng);
            let mut words = model.all_inputs(&job);
            // A number of some jobs is replaced by a special one. (Separators must stay sorted.)
            if name != key_compare::KeyCompare::NAME && rng.random_bool(0.4) {
                let numbers: Vec<usize> = (0..words.len()).filter(|&port| is_number[port]).collect();
                let edges = edges(model.format());
                let other = [edges[rng.random_range(0..edges.len())], model.format().nan()][rng.random_range(0..2)];
                words[numbers[rng.random_range(0..numbers.len())]] = other;
            }
            Some(words)
        };
        let steps = self.count.div_ceil(STREAMS);
        let jobs = Jobs { steps: (0..steps).map(|_| (0..STREAMS).filter_map(|_| job()).collect()).collect() };
        (spec, jobs)
    }
}

fn words_of(bundle: &impl Bundle<Binary32>) -> Vec<u64> {
    let mut words = Vec::new();
    to_canonical_words(bundle, &mut words);
    words
}

/// A subject whose oracle is exact. Each place of a step has an oracle of its own.
fn exact<O: Operation>(
    name: &str,
    operation: &O,
    jobs: Jobs,
    oracle: &'static str,
    expect: impl Fn() -> Expect,
) -> Subject {
    let graph = Graph::of(operation);
    let values = Values::of(&graph, &jobs);
    let mut refused = None;
    let places = jobs.steps.first().map_or(0, Vec::len);
    for place in 0..places {
        let mut expect = expect();
        for (step, of_step) in jobs.steps.iter().enumerate() {
            let Some(job) = of_step.get(place) else { continue };
            let (mut expected, found) = (expect(job), values.outcome(&graph, step, place));
            // Ports that the operation lacks.
            let is_present = |port: usize| graph.outputs.iter().any(|leaf| leaf.port == port);
            expected.iter_mut().enumerate().filter(|(port, _)| !is_present(*port)).for_each(|(_, word)| *word = 0);
            if found != expected {
                refused.get_or_insert_with(|| format!("{found:x?}, expected {expected:x?}, for {job:x?}"));
            }
        }
    }
    let (faults, judge, assumptions) = (faults(&graph), Judge::Exact(oracle), vec![]);
    Subject { name: name.to_string(), graph, faults, jobs, values, judge, assumptions, refused }
}
