//! Random agents: what they are answered, and when, before a second simulator that walks every cycle.

mod common;

use common::{Echo, Script, Tag, echo};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_model::{Control, CycleModel, Functional, Loop, Shape};
use raypath_ops::{Beat, Binary32, EuclideanInput, Job, JobKind, Outcome, Rules};
use raypath_timing::{Agent, Machine, Sink, Step, simulate};
use std::collections::{HashMap, VecDeque};

/// Steps that come to an end, as they wait only for answers that will come.
fn steps<J>(rng: &mut ChaCha8Rng, length: usize, mut job: impl FnMut(&mut ChaCha8Rng) -> J) -> Vec<Step<J>> {
    let (mut steps, mut issued, mut waited) = (Vec::new(), 0, 0);
    let mut holds = false;
    while steps.len() < length || holds {
        steps.push(match rng.random_range(0..4) {
            0 => Step::Fetch,
            // Only to be surely outstanding: one wait for each job, and none but right after a job.
            1 if issued > waited && matches!(steps.last(), Some(Step::Issue { .. })) => {
                waited = issued;
                Step::Wait
            }
            _ => {
                issued += 1;
                holds = steps.len() < length && rng.random_bool(0.2);
                Step::Issue { job: job(rng), holds }
            }
        });
    }
    steps
}

/// Each cycle looks at everybody: an agent has a cycle from which it may act, and everything else follows.
/// The pipeline is a delay.
fn walk(agents: &[Vec<Step<Tag>>], in_flight: usize, memory: u64, latency: u64) -> (u64, Vec<(u64, u64)>) {
    #[derive(Debug, Clone, PartialEq)]
    enum Doing {
        Free(u64),
        InLine(u64, Tag, bool),
        Waiting,
        Leaving,
        Gone,
    }
    struct Walker {
        /// None before it acts for the first time.
        number: Option<usize>,
        step: usize,
        doing: Doing,
        outstanding: usize,
        /// Among those who may act in the same cycle.
        rank: (u64, u64),
    }
    let mut numbers = 0..agents.len();
    let newcomer = |rank| Walker { number: None, step: 0, doing: Doing::Free(0), outstanding: 0, rank };
    let mut live: Vec<Walker> = (0..in_flight as u64).map(|seat| newcomer((3, seat))).collect();
    let (mut inside, mut entries) = (VecDeque::<(usize, u64)>::new(), Vec::new());
    let (mut line_number, mut fetch_number, mut holder) = (0, 0, None::<usize>);
    for now in 0.. {
        // Who may act, in order.
        loop {
            let able = live.iter().enumerate().filter(|(_, walker)| walker.doing == Doing::Free(now));
            let Some((seat, _)) = able.min_by_key(|(_, walker)| walker.rank) else { break };
            let walker = &mut live[seat];
            let Some(number) = walker.number.or_else(|| numbers.next()) else {
                walker.doing = Doing::Gone;
                continue;
            };
            walker.number = Some(number);
            match agents[number].get(walker.step).copied().unwrap_or(Step::Done) {
                Step::Fetch => {
                    walker.doing = Doing::Free(now + memory);
                    walker.rank = if memory == 0 { walker.rank } else { (0, fetch_number) };
                    fetch_number += 1;
                }
                Step::Issue { job, holds } => {
                    walker.doing = Doing::InLine(line_number, job, holds);
                    line_number += 1;
                }
                Step::Wait => walker.doing = Doing::Waiting,
                Step::Done if walker.outstanding > 0 => walker.doing = Doing::Leaving,
                Step::Done => {
                    *walker = Walker { doing: Doing::Free(now), ..newcomer(walker.rank) };
                    continue;
                }
            }
            walker.step += 1;
        }
        if live.iter().all(|walker| walker.doing == Doing::Gone) {
            return (now, entries);
        }
        let in_line = |walker: &Walker| match walker.doing {
            Doing::InLine(place, ..) => Some(place),
            _ => None,
        };
        let offering = (0..live.len())
            .filter(|seat| in_line(&live[*seat]).is_some() && holder.is_none_or(|holder| holder == *seat))
            .min_by_key(|seat| in_line(&live[*seat]));
        // The answer before the acceptance: it is one of an older job.
        if inside.front().is_some_and(|(_, shown)| *shown <= now)
            && let Some((seat, _)) = inside.pop_front()
        {
            live[seat].outstanding -= 1;
            let walker = &mut live[seat];
            if walker.doing == Doing::Waiting || walker.doing == Doing::Leaving && walker.outstanding == 0 {
                walker.doing = Doing::Free(now + 1);
                walker.rank = (1, 0);
            }
        }
        if let Some(seat) = offering
            && let Doing::InLine(_, job, holds) = live[seat].doing
        {
            live[seat].outstanding += 1;
            live[seat].doing = Doing::Free(now + 1);
            live[seat].rank = (2, 0);
            holder = holds.then_some(seat);
            inside.push_back((seat, now + latency));
            entries.push((now, job.1));
        }
    }
    unreachable!("there are always more cycles")
}

/// Notes when which job was accepted.
#[derive(Default)]
struct Entries(Vec<(u64, u64)>);

impl raypath_timing::Observer for Entries {
    fn wants(&self, cycle: u64) -> Option<u64> {
        Some(cycle)
    }
    fn cycle(&mut self, cycle: &raypath_timing::Cycle, _: impl Iterator<Item = raypath_model::PipelinePosition>) {
        if let (Some((_, owner)), true) = (cycle.offered, cycle.accepted) {
            self.0.push((cycle.number, owner));
        }
    }
}

#[test]
fn every_job_is_accepted_in_the_cycle_in_which_a_simple_walk_accepts_it() {
    let mut jobs = 0;
    for seed in 0..400 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let agents: Vec<Vec<Step<Tag>>> = (0..rng.random_range(1..30))
            .map(|agent| {
                let length = rng.random_range(0..20);
                steps(rng, length, |rng| Tag(JobKind::ALL[rng.random_range(0..4)], agent))
            })
            .collect();
        let (in_flight, memory) = (rng.random_range(1..20), [0, 1, 2, 13, 50][rng.random_range(0..5)]);
        let control = [Control::Skid, Control::Credit][rng.random_range(0..2)];
        let shape = Shape { latency: rng.random_range(1..15), control, loops: Vec::new() };
        let machine = Machine { in_flight, memory_latency: memory, sink: Sink::Always };
        let scripts = || agents.iter().cloned().map(Script::<Echo>::new);
        let mut seen = Entries::default();
        let timing = simulate(scripts(), &machine, echo(&shape), &mut seen, &|_| true).expect("runs");
        let (cycles, entries) = walk(&agents, in_flight, memory, shape.latency as u64);
        assert_eq!(seen.0, entries, "seed {seed}");
        assert_eq!(timing.cycles, cycles, "seed {seed}");
        // Skipping what nobody looks at changes nothing.
        assert_eq!(simulate(scripts(), &machine, echo(&shape), &mut (), &|_| true), Ok(timing));
        jobs += entries.len();
    }
    assert!(jobs > 10_000, "{jobs}");
}

/// Jobs without accumulators: each agent is answered as if it were alone, whatever the sink does.
#[test]
fn outcomes_are_those_of_the_functional_model_for_each_agent_alone() {
    for seed in 0..20 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let job = |rng: &mut ChaCha8Rng| {
            let kind = [JobKind::Quadbox, JobKind::Triangle][rng.random_range(0..2)];
            Job::<16, 8>::from_ports(kind, |port| match port {
                "ray_kx" | "ray_ky" | "ray_kz" => rng.random_range(0..3),
                _ => rng.random_range(-2.0_f32..2.0).to_bits().into(),
            })
        };
        let plans: Vec<Vec<Step<Job>>> = (0..40).map(|_| steps(rng, 30, job)).collect();
        let mut agents: Vec<Script<Functional>> = plans.iter().cloned().map(Script::new).collect();
        let sink = Sink::Stalls { probability: 0.3, seed };
        let machine = Machine { in_flight: 1 + seed as usize, memory_latency: 20, sink };
        let model = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
        simulate(agents.iter_mut(), &machine, model, &mut (), &|_| true).expect("runs");
        for (agent, plan) in agents.iter().zip(&plans) {
            let mut alone = Functional::new(Rules::Paper);
            let jobs = plan.iter().filter_map(|step| if let Step::Issue { job, .. } = step { Some(job) } else { None });
            let expected: Vec<Outcome> = jobs.map(|job| alone.run(job)).collect();
            assert_eq!(agent.answers, expected);
            assert!(agent.steps.is_empty());
        }
    }
}

/// Whole vectors of integers from many agents at once, fetching and waiting between their beats: the sums are exact only
/// if no beat of another agent comes between.
#[test]
fn beats_that_hold_never_interleave() {
    /// A query of several vectors; the last beat of each carries reset, and does not hold.
    struct Query {
        steps: VecDeque<Step<Job>>,
        sums: Vec<f32>,
    }
    impl Agent<Functional> for Query {
        fn step(&mut self) -> Step<Job> {
            self.steps.pop_front().unwrap_or(Step::Done)
        }
        fn answer(&mut self, outcome: &Outcome) {
            let Outcome::Euclidean(output) = outcome else { panic!("{outcome:?}") };
            if output.euclidean_reset_accum.into() {
                self.sums.push(output.euclidean_accumulator.into());
            }
        }
    }
    let loops = vec![Loop { opcode: JobKind::Euclidean.opcode(), first: 9, last: 10 }];
    for control in [Control::Skid, Control::Credit] {
        let rng = &mut ChaCha8Rng::seed_from_u64(7);
        let (mut queries, mut expected) = (Vec::new(), Vec::new());
        for _ in 0..60 {
            let (mut steps, mut sums) = (VecDeque::new(), Vec::new());
            for _ in 0..10 {
                let vector: Vec<i32> = (0..rng.random_range(1..90)).map(|_| rng.random_range(-9..=9)).collect();
                sums.push(vector.iter().map(|x| (x - 1) * (x - 1)).sum::<i32>() as f32);
                let numbers: Vec<f32> = vector.iter().map(|x| *x as f32).collect();
                let ones = vec![1.0; numbers.len()];
                for beat in Beat::<Binary32, 16>::of(&numbers, &ones).expect("beats") {
                    let holds = !bool::from(beat.reset_accum);
                    steps.push_back(Step::Issue { job: Job::Euclidean(EuclideanInput { euclidean: beat }), holds });
                    steps.extend([Step::Fetch].into_iter().filter(|_| rng.random_bool(0.2)));
                }
                if matches!(steps.back(), Some(Step::Issue { .. })) {
                    steps.push_back(Step::Wait);
                }
            }
            queries.push(Query { steps, sums: Vec::new() });
            expected.push(sums);
        }
        let machine = Machine { in_flight: 16, memory_latency: 9, sink: Sink::Stalls { probability: 0.1, seed: 3 } };
        let shape = Shape { latency: 13, control, loops: loops.clone() };
        let model = CycleModel::new(Functional::new(Rules::Paper), &shape);
        let timing = simulate(queries.iter_mut(), &machine, model, &mut (), &|_| true).expect("runs");
        assert!(queries.iter().map(|query| &query.sums).eq(&expected), "{control:?}");
        assert!(timing.starved.held > 100, "{timing:?}");
    }
}

/// Nobody is passed over: while all have jobs, they take turns.
#[test]
fn agents_take_turns() {
    let jobs = 100;
    let agents =
        (0..8).map(|agent| Script::<Echo>::new((0..jobs).map(move |_| common::issue(JobKind::Quadbox, agent))));
    let machine = Machine { in_flight: 8, memory_latency: 0, sink: Sink::Always };
    let mut seen = Entries::default();
    simulate(agents, &machine, echo(&Shape::default()), &mut seen, &|_| true).expect("runs");
    let mut counts = HashMap::new();
    for (cycle, owner) in seen.0 {
        assert_eq!(owner, cycle % 8);
        *counts.entry(owner).or_insert(0) += 1;
    }
    assert!(counts.len() == 8 && counts.values().all(|count| *count == jobs));
}
