//! Random agents, compared with the functional model and with an independent simulator that visits every cycle.

use crate::simulation::common::{Echo, Script, Tag, echo};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Control, CycleModel, Functional, Shape};
use raypath_ops::{Job, JobKind, Outcome, Rules};
use raypath_timing::report::Recorder;
use raypath_timing::{Action, Environment, Sink, simulate};
use std::collections::VecDeque;

/// Random actions without deadlock: the agent waits only while an outcome is outstanding.
fn random_actions<J>(rng: &mut ChaCha8Rng, length: usize, mut job: impl FnMut(&mut ChaCha8Rng) -> J) -> Vec<Action<J>> {
    let (mut actions, mut issued, mut waited) = (Vec::new(), 0, 0);
    while actions.len() < length {
        actions.push(match rng.random_range(0..4) {
            0 => Action::Fetch,
            // At most one wait for each job, directly after it, so that its outcome is certainly outstanding.
            1 if issued > waited && matches!(actions.last(), Some(Action::Issue(_))) => {
                waited = issued;
                Action::Wait
            }
            _ => {
                issued += 1;
                Action::Issue(job(rng))
            }
        });
    }
    actions
}

/// The reference simulator: it examines every agent in every cycle, and models the pipeline as a delay. Returns the
/// number of cycles, and the cycle and owner of each accepted job.
fn reference(agents: &[Vec<Action<Tag>>], in_flight: usize, memory: u64, latency: u64) -> (u64, Vec<(u64, u64)>) {
    #[derive(Debug, Clone, PartialEq)]
    enum State {
        /// May act in this cycle.
        Acts(u64),
        /// Has a job: its number in the queue, and the job.
        Queued(u64, Tag),
        Waiting,
        Finishing,
        Empty,
    }
    struct Slot {
        /// The number of the agent; `None` before its first action.
        number: Option<usize>,
        action: usize,
        state: State,
        outstanding: usize,
        /// The order among agents that may act in the same cycle.
        rank: (u64, u64),
    }
    let mut numbers = 0..agents.len();
    let new_slot = |rank| Slot { number: None, action: 0, state: State::Acts(0), outstanding: 0, rank };
    let mut slots: Vec<Slot> = (0..in_flight as u64).map(|slot| new_slot((3, slot))).collect();
    let (mut inside, mut entries) = (VecDeque::<(usize, u64)>::new(), Vec::new());
    let (mut queue_number, mut fetch_number) = (0, 0);
    for now in 0.. {
        // Agents act in the order of their ranks.
        loop {
            let able = slots.iter().enumerate().filter(|(_, slot)| slot.state == State::Acts(now));
            let Some((index, _)) = able.min_by_key(|(_, slot)| slot.rank) else { break };
            let slot = &mut slots[index];
            let Some(number) = slot.number.or_else(|| numbers.next()) else {
                slot.state = State::Empty;
                continue;
            };
            slot.number = Some(number);
            match agents[number].get(slot.action).copied().unwrap_or(Action::Done) {
                Action::Fetch => {
                    slot.state = State::Acts(now + memory);
                    slot.rank = if memory == 0 { slot.rank } else { (0, fetch_number) };
                    fetch_number += 1;
                }
                Action::Issue(job) => {
                    slot.state = State::Queued(queue_number, job);
                    queue_number += 1;
                }
                Action::Wait => slot.state = State::Waiting,
                Action::Done if slot.outstanding > 0 => slot.state = State::Finishing,
                Action::Done => {
                    *slot = Slot { state: State::Acts(now), ..new_slot(slot.rank) };
                    continue;
                }
            }
            slot.action += 1;
        }
        if slots.iter().all(|slot| slot.state == State::Empty) {
            return (now, entries);
        }
        let queue_number_of = |slot: &Slot| match slot.state {
            State::Queued(number, ..) => Some(number),
            _ => None,
        };
        let offering = (0..slots.len())
            .filter(|index| queue_number_of(&slots[*index]).is_some())
            .min_by_key(|index| queue_number_of(&slots[*index]));
        // The outcome of an older job precedes the acceptance of a new one.
        if inside.front().is_some_and(|(_, completion)| *completion <= now)
            && let Some((index, _)) = inside.pop_front()
        {
            let slot = &mut slots[index];
            slot.outstanding -= 1;
            if slot.state == State::Waiting || slot.state == State::Finishing && slot.outstanding == 0 {
                slot.state = State::Acts(now + 1);
                slot.rank = (1, 0);
            }
        }
        if let Some(index) = offering
            && let State::Queued(_, job) = slots[index].state
        {
            slots[index].outstanding += 1;
            slots[index].state = State::Acts(now + 1);
            slots[index].rank = (2, 0);
            inside.push_back((index, now + latency));
            entries.push((now, job.1));
        }
    }
    unreachable!("the range of cycles has no end")
}

/// The cycle and the owner of each recorded job.
fn entries(recorder: Recorder) -> Vec<(u64, u64)> {
    recorder.window().jobs.iter().map(|job| (job.accepted, job.owner)).collect()
}

#[test]
fn acceptance_cycles_equal_those_of_the_reference_simulator() {
    let mut jobs = 0;
    for seed in 0..400 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let agents: Vec<Vec<Action<Tag>>> = (0..rng.random_range(1..30))
            .map(|agent| {
                let length = rng.random_range(0..20);
                random_actions(rng, length, |rng| Tag(JobKind::ALL[rng.random_range(0..4)], agent))
            })
            .collect();
        let (in_flight, memory) = (rng.random_range(1..20), [0, 1, 2, 13, 50][rng.random_range(0..5)]);
        let control = [Control::Skid, Control::Credit][rng.random_range(0..2)];
        let shape = Shape { latency: rng.random_range(1..15), control, ..Shape::default() };
        let environment = Environment { in_flight, memory_latency: memory, sink: Sink::Always };
        let scripts = || agents.iter().cloned().map(Script::<Echo>::new);
        let mut recorder = Recorder::new("agent", shape.latency, 0, usize::MAX);
        let timing = simulate(scripts(), &environment, echo(&shape), &mut recorder, &|_| true).expect("runs");
        let (cycles, expected) = reference(&agents, in_flight, memory, shape.latency as u64);
        assert_eq!(entries(recorder), expected, "seed {seed}");
        assert_eq!(timing.cycles, cycles, "seed {seed}");
        let (accepted, inside) = (expected.len() as u64, shape.latency as u64);
        assert_eq!((timing.accepted, timing.latency_sum), (accepted, accepted * inside), "seed {seed}");
        assert_eq!(timing.accepted + timing.refused + timing.starved.total(), timing.cycles, "seed {seed}");
        // Skipping unobserved idle cycles does not change the timing.
        assert_eq!(simulate(scripts(), &environment, echo(&shape), &mut (), &|_| true), Ok(timing));
        jobs += expected.len();
    }
    assert!(jobs > 10_000, "{jobs}");
}

/// Jobs without accumulators: each agent receives the outcomes that it would receive alone, despite back pressure.
#[test]
fn outcomes_equal_those_of_the_functional_model_for_each_agent_alone() {
    for seed in 0..20 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let job = |rng: &mut ChaCha8Rng| {
            let kind = [JobKind::Quadbox, JobKind::Triangle][rng.random_range(0..2)];
            Job::<16, 8>::from_ports(kind, |port| match port {
                "ray_kx" | "ray_ky" | "ray_kz" => rng.random_range(0..3),
                _ => rng.random_range(-2.0_f32..2.0).to_bits().into(),
            })
        };
        let plans: Vec<Vec<Action<Job>>> = (0..40).map(|_| random_actions(rng, 30, job)).collect();
        let mut agents: Vec<Script<Functional>> = plans.iter().cloned().map(Script::new).collect();
        let sink = Sink::Stalls { probability: 0.3, seed };
        let environment = Environment { in_flight: 1 + seed as usize, memory_latency: 20, sink };
        let pipeline = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
        simulate(agents.iter_mut(), &environment, pipeline, &mut (), &|_| true).expect("runs");
        for (agent, plan) in agents.iter().zip(&plans) {
            let mut alone = Functional::new(Rules::Paper);
            let jobs = plan.iter().filter_map(|action| if let Action::Issue(job) = action { Some(job) } else { None });
            let expected: Vec<Outcome> = jobs.map(|job| alone.run(job)).collect();
            assert_eq!(agent.outcomes, expected);
            assert!(agent.actions.is_empty());
        }
    }
}
