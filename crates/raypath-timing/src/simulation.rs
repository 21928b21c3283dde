use crate::{Action, Agent, Environment, Observer, PortActivity, Progress, Sink, Timing};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{CycleModel, Model};
use raypath_ops::JobKind;
use std::collections::VecDeque;
use thiserror::Error;

/// The reason why a simulation did not complete.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// The environment has no slot for an agent.
    #[error("0 agents in flight, expected at least 1")]
    NoSlots,
    /// The stall probability of the sink is out of range.
    #[error("stall probability {0}, expected at least 0 and less than 1")]
    Probability(f64),
    /// An agent waits for an outcome, but has no outstanding job.
    #[error("agent {agent} waits in cycle {cycle} for an outcome, but has no outstanding job")]
    Deadlock {
        /// The number of the agent, in the order in which agents start.
        agent: u64,
        /// The cycle.
        cycle: u64,
    },
    /// The progress callback returned false.
    #[error("stopped after {agents} agents")]
    Stopped {
        /// The number of completed agents.
        agents: u64,
    },
}

/// Runs all agents to completion and counts the cycles. The same input gives the same cycles.
///
/// The arbiter is a first-in, first-out queue: it issues one job a cycle, in the order in which the agents had them,
/// and a refused job stays at the head. Among agents that get a job in the same cycle, those whose fetch completed come
/// first (in the order of their fetches), then the agent that received an outcome in the previous cycle, then the agent
/// whose job was accepted in the previous cycle. An agent that takes over a slot starts in the cycle in which the
/// previous one was done; at the start, the slots are filled one after another.
///
/// # Errors
/// An environment without slots or with an invalid sink, an agent that waits without an outstanding job, and a stop by
/// `progress`. Agents that fetch forever are not detected.
pub fn simulate<M: Model<Kind = JobKind>, A: Agent<M>>(
    agents: impl IntoIterator<Item = A>,
    environment: &Environment,
    pipeline: CycleModel<M>,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<Timing, SimulationError> {
    if environment.in_flight == 0 {
        return Err(SimulationError::NoSlots);
    }
    let stalls = match environment.sink {
        Sink::Always => None,
        Sink::Stalls { probability, seed } if (0.0..1.0).contains(&probability) => {
            Some((ChaCha8Rng::seed_from_u64(seed), probability))
        }
        Sink::Stalls { probability, .. } => return Err(SimulationError::Probability(probability)),
    };
    let simulation = Simulation {
        agents: agents.into_iter(),
        started: 0,
        memory_latency: environment.memory_latency,
        pipeline,
        stalls,
        progress,
        polls: 0,
        now: 0,
        slots: Vec::new(),
        live: 0,
        waiting: 0,
        fetching: VecDeque::new(),
        queue: VecDeque::new(),
        inside: VecDeque::new(),
        timing: Timing::default(),
    };
    simulation.run(environment.in_flight, observer)
}

/// Polls between two calls of the progress callback.
const POLLS_PER_CALL: u64 = 1 << 16;

struct Simulation<'p, M: Model, A, I> {
    agents: I,
    started: u64,
    memory_latency: u64,
    pipeline: CycleModel<M>,
    stalls: Option<(ChaCha8Rng, f64)>,
    progress: Progress<'p>,
    polls: u64,
    now: u64,
    slots: Vec<Slot<M, A>>,
    /// Slots whose agent is not done.
    live: usize,
    /// Slots whose agent waits for an outcome.
    waiting: usize,
    /// The cycles in which fetches complete, in order because the latency is constant, and the slots of their agents.
    fetching: VecDeque<(u64, usize)>,
    /// Slots with a job to issue.
    queue: VecDeque<usize>,
    /// The slots to which the jobs inside the pipeline belong, and the cycles of acceptance, oldest first.
    inside: VecDeque<(usize, u64)>,
    timing: Timing,
}

struct Slot<M: Model, A> {
    agent: A,
    number: u64,
    /// Jobs without an outcome.
    outstanding: usize,
    /// The job to issue, and the cycle in which the agent issued it.
    job: Option<(M::Job, u64)>,
    waits_for: WaitsFor,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum WaitsFor {
    /// No outcome: the agent fetches or has a job to issue.
    Nothing,
    /// The next outcome.
    Outcome,
    /// All outstanding outcomes, after which the agent is done.
    AllOutcomes,
}

/// The slots whose agents may act in the next cycle.
#[derive(Default)]
struct Ready {
    received: Option<usize>,
    accepted: Option<usize>,
}

impl<M: Model<Kind = JobKind>, A: Agent<M>, I: Iterator<Item = A>> Simulation<'_, M, A, I> {
    fn run(mut self, in_flight: usize, observer: &mut impl Observer) -> Result<Timing, SimulationError> {
        self.start(in_flight)?;
        let mut ready = Ready::default();
        loop {
            self.poll()?;
            while let Some((_, slot)) = self.fetching.pop_front_if(|(completion, _)| *completion <= self.now) {
                self.act(slot)?;
            }
            for slot in [ready.received.take(), ready.accepted.take()].into_iter().flatten() {
                self.act(slot)?;
            }
            if self.live == 0 {
                return Ok(Timing { cycles: self.now, ..self.timing });
            }
            let offering = self.queue.front().copied();
            let skipped = if offering.is_none() { self.skip_idle(observer)? } else { 0 };
            if skipped == 0 {
                ready = self.clock(offering, observer);
            }
        }
    }

    fn start(&mut self, in_flight: usize) -> Result<(), SimulationError> {
        while self.slots.len() < in_flight
            && let Some(agent) = self.agents.next()
        {
            let (slot, number) = (self.slots.len(), self.started);
            self.slots.push(Slot { agent, number, outstanding: 0, job: None, waits_for: WaitsFor::Nothing });
            self.started += 1;
            self.live += 1;
            self.act(slot)?;
        }
        Ok(())
    }

    /// Performs the actions of a slot's agent that take no time, and of its successors if it is done.
    fn act(&mut self, slot: usize) -> Result<(), SimulationError> {
        loop {
            self.poll()?;
            let Slot { agent, number, outstanding, job, waits_for } = &mut self.slots[slot];
            let was_done = std::mem::replace(waits_for, WaitsFor::Nothing) == WaitsFor::AllOutcomes;
            match if was_done { Action::Done } else { agent.next_action() } {
                Action::Fetch => {
                    self.timing.fetches += 1;
                    if self.memory_latency > 0 {
                        self.fetching.push_back((self.now.saturating_add(self.memory_latency), slot));
                        return Ok(());
                    }
                }
                Action::Issue(next) => {
                    *job = Some((next, self.now));
                    self.queue.push_back(slot);
                    return Ok(());
                }
                Action::Wait if *outstanding == 0 => {
                    return Err(SimulationError::Deadlock { agent: *number, cycle: self.now });
                }
                Action::Wait => {
                    self.wait(slot, WaitsFor::Outcome);
                    return Ok(());
                }
                Action::Done if *outstanding > 0 => {
                    self.wait(slot, WaitsFor::AllOutcomes);
                    return Ok(());
                }
                Action::Done => {
                    self.timing.agents += 1;
                    let Some(next) = self.agents.next() else {
                        self.live -= 1;
                        return Ok(());
                    };
                    (*agent, *number) = (next, self.started);
                    self.started += 1;
                }
            }
        }
    }

    fn wait(&mut self, slot: usize, waits_for: WaitsFor) {
        self.slots[slot].waits_for = waits_for;
        self.waiting += 1;
    }

    /// Skips cycles without an offered job, a valid output or an observer, and returns their number.
    fn skip_idle(&mut self, observer: &impl Observer) -> Result<u64, SimulationError> {
        let completion = self.fetching.front().map_or(u64::MAX, |(completion, _)| *completion);
        let until = observer.next_observed(self.now).map_or(completion, |observed| observed.min(completion));
        if until == u64::MAX && self.inside.is_empty() {
            // Unreachable unless the simulation loses an agent: `act` detects agents that wait without a job.
            let agent = self.slots.first().map_or(0, |slot| slot.number);
            return Err(SimulationError::Deadlock { agent, cycle: self.now });
        }
        let skipped = self.pipeline.idle(until.saturating_sub(self.now));
        self.count_starved(skipped);
        self.now += skipped;
        Ok(skipped)
    }

    /// Simulates one cycle of the datapath, with the job of slot `offering` at its input.
    fn clock(&mut self, offering: Option<usize>, observer: &mut impl Observer) -> Ready {
        let output_valid = self.pipeline.output().is_some();
        let refused =
            output_valid && self.stalls.as_mut().is_some_and(|(rng, probability)| rng.random_bool(*probability));
        let offer = offering.and_then(|slot| self.slots[slot].job.as_ref().map(|(job, _)| (slot, job)));
        if observer.next_observed(self.now) == Some(self.now) {
            let offered = offer.map(|(slot, job)| (M::kind(job).opcode(), self.slots[slot].number));
            let accepted = offered.is_some_and(|(opcode, _)| self.pipeline.input_ready(opcode));
            let output_taken = output_valid && !refused;
            let ports = PortActivity { cycle: self.now, offered, accepted, output_valid, output_taken };
            observer.observe(&ports, self.pipeline.positions());
        }
        let mut ready = Ready::default();
        let kind = offer.map(|(_, job)| M::kind(job));
        let transfer = self.pipeline.cycle(offer.map(|(_, job)| job), !refused);
        self.timing.sink_refused += u64::from(refused);
        match offering.zip(kind) {
            None => self.count_starved(1),
            Some((slot, kind)) if transfer.accepted => {
                self.accept(slot, kind);
                ready.accepted = Some(slot);
            }
            Some(_) => self.timing.refused += 1,
        }
        if let Some(outcome) = transfer.output {
            ready.received = self.deliver(&outcome);
        }
        self.now += 1;
        ready
    }

    fn accept(&mut self, slot: usize, kind: JobKind) {
        self.queue.pop_front();
        let Slot { outstanding, job, .. } = &mut self.slots[slot];
        *outstanding += 1;
        let since = job.take().map_or(self.now, |(_, since)| since);
        self.inside.push_back((slot, self.now));
        self.timing.accepted += 1;
        self.timing.jobs[kind as usize] += 1;
        self.timing.queueing_sum += self.now - since;
    }

    /// Delivers the outcome of the oldest job. Returns the slot of its agent if that can now act.
    fn deliver(&mut self, outcome: &M::Outcome) -> Option<usize> {
        let (slot, accepted) = self.inside.pop_front()?;
        self.timing.latency_sum += self.now - accepted;
        let Slot { agent, outstanding, waits_for, .. } = &mut self.slots[slot];
        agent.receive(outcome);
        *outstanding -= 1;
        let resumes = match waits_for {
            WaitsFor::Nothing => false,
            WaitsFor::Outcome => true,
            WaitsFor::AllOutcomes => *outstanding == 0,
        };
        self.waiting -= usize::from(resumes);
        resumes.then_some(slot)
    }

    /// Counts cycles without an offered job by their cause.
    fn count_starved(&mut self, cycles: u64) {
        let starved = &mut self.timing.starved;
        let count = match (self.fetching.is_empty(), self.waiting == 0) {
            (false, false) => &mut starved.both,
            (false, true) => &mut starved.memory,
            (true, _) => &mut starved.outcomes,
        };
        *count += cycles;
    }

    fn poll(&mut self) -> Result<(), SimulationError> {
        self.polls += 1;
        let agents = self.timing.agents;
        if self.polls.is_multiple_of(POLLS_PER_CALL) && !(self.progress)(agents) {
            return Err(SimulationError::Stopped { agents });
        }
        Ok(())
    }
}
