use crate::agent::{Agent, Step};
use crate::machine::{Machine, Sink};
use crate::observer::{Cycle, Observer};
use crate::timing::Timing;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_model::{CycleModel, Model, OnPorts};
use raypath_ops::JobKind;
use std::collections::VecDeque;
use thiserror::Error;

/// Called now and then with how many agents are done; where it answers false the work stops soon.
pub type Watch<'w> = &'w (dyn Fn(u64) -> bool + Sync);

/// Why a run came to no end.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// There is no place for an agent.
    #[error("0 agents in flight, expected at least 1")]
    NoPlace,
    /// The sink would refuse for ever, or its probability is none.
    #[error("a sink that refuses with probability {0}, expected 0 or more and less than 1")]
    Probability(f64),
    /// An agent waits and has no job whose answer could come.
    #[error("agent {agent} waits in cycle {cycle} for an answer, but none of its jobs is outstanding")]
    Stuck {
        /// Which, in the order in which they began.
        agent: u64,
        /// When.
        cycle: u64,
    },
    /// An agent was done though it held the datapath.
    #[error("agent {agent} is done in cycle {cycle}, but holds the datapath for its next job")]
    Abandoned {
        /// Which, in the order in which they began.
        agent: u64,
        /// When.
        cycle: u64,
    },
    /// The watch has said so.
    #[error("stopped after {agents} agents")]
    Stopped {
        /// How many were done.
        agents: u64,
    },
}

/// Runs all agents to their ends, and says how long that took.
///
/// The arbiter is a queue: whoever has a job first issues first, one job a cycle, and a job that is refused stays at the
/// head. Of those that get a job in the same cycle come first who had fetched (in the order in which they did), then the
/// one that was answered in the cycle before, then the one whose last job was accepted in the cycle before. Who
/// [holds](Step::Issue) the datapath passes all others. An agent that takes a finished one's place begins in the cycle
/// in which that was done, and at the start the places are taken one after another. The same input gives the same cycles.
///
/// # Errors
/// No place for agents, a sink that never takes, an agent that waits for nothing or leaves while it holds the datapath,
/// and a watch that stops the run. Agents that fetch for ever are not found out: only the watch ends them.
pub fn simulate<M: Model<Kind = JobKind>, A: Agent<M>>(
    agents: impl IntoIterator<Item = A>,
    machine: &Machine,
    model: CycleModel<M>,
    observer: &mut impl Observer,
    watch: Watch,
) -> Result<Timing, SimulationError> {
    if machine.in_flight == 0 {
        return Err(SimulationError::NoPlace);
    }
    let stalls = match machine.sink {
        Sink::Always => None,
        Sink::Stalls { probability, seed } if (0.0..1.0).contains(&probability) => {
            Some((ChaCha8Rng::seed_from_u64(seed), probability))
        }
        Sink::Stalls { probability, .. } => return Err(SimulationError::Probability(probability)),
    };
    let simulation = Simulation {
        agents: agents.into_iter(),
        begun: 0,
        memory_latency: machine.memory_latency,
        model,
        stalls,
        watch,
        turns: 0,
        now: 0,
        seats: Vec::new(),
        live: 0,
        waiting: 0,
        fetching: VecDeque::new(),
        queue: VecDeque::new(),
        inside: VecDeque::new(),
        holder: None,
        timing: Timing::default(),
    };
    simulation.run(machine.in_flight, observer)
}

/// How many turns pass between two calls of the watch.
const TURNS: u64 = 1 << 16;

struct Simulation<'w, M: Model, A, I> {
    agents: I,
    begun: u64,
    memory_latency: u64,
    model: CycleModel<M>,
    stalls: Option<(ChaCha8Rng, f64)>,
    watch: Watch<'w>,
    turns: u64,
    now: u64,
    seats: Vec<Seat<M, A>>,
    /// Seats whose agent is not done.
    live: usize,
    /// Seats whose agent waits for an answer.
    waiting: usize,
    /// Who reads memory, and the cycle in which that is over. Memory takes equally long for all, so first in, first out.
    fetching: VecDeque<(u64, usize)>,
    /// Seats with a job, but the holder's.
    queue: VecDeque<usize>,
    /// Whose the jobs inside are, and the cycles in which they were accepted. The pipeline keeps their order.
    inside: VecDeque<(usize, u64)>,
    /// Who issues the next job, whoever else has one.
    holder: Option<usize>,
    timing: Timing,
}

/// A place for an agent.
struct Seat<M: Model, A> {
    agent: A,
    number: u64,
    /// Jobs accepted and not answered.
    outstanding: usize,
    /// The job to issue, whether it holds, and the cycle from which it stands in line.
    job: Option<(M::Job, bool, u64)>,
    pause: Pause,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Pause {
    /// It fetches, or has a job in line.
    None,
    /// It wants an answer before it goes on.
    Wait,
    /// It is done, but has answers outstanding.
    Leave,
}

/// Who may go on in the next cycle, for what happened in this one.
#[derive(Default)]
struct Woken {
    answered: Option<usize>,
    accepted: Option<usize>,
}

impl<M: Model<Kind = JobKind>, A: Agent<M>, I: Iterator<Item = A>> Simulation<'_, M, A, I> {
    fn run(mut self, in_flight: usize, observer: &mut impl Observer) -> Result<Timing, SimulationError> {
        self.fill(in_flight)?;
        let mut woken = Woken::default();
        loop {
            self.turn()?;
            while let Some((_, seat)) = self.fetching.pop_front_if(|(over, _)| *over <= self.now) {
                self.act(seat)?;
            }
            for seat in [woken.answered.take(), woken.accepted.take()].into_iter().flatten() {
                self.act(seat)?;
            }
            if self.live == 0 {
                return Ok(Timing { cycles: self.now, ..self.timing });
            }
            let offering = match self.holder {
                Some(holder) => Some(holder).filter(|holder| self.seats[*holder].job.is_some()),
                None => self.queue.front().copied(),
            };
            let idle = if offering.is_none() { self.idle(observer)? } else { 0 };
            if idle == 0 {
                woken = self.cycle(offering, observer);
            }
        }
    }

    /// Seats the first agents.
    fn fill(&mut self, in_flight: usize) -> Result<(), SimulationError> {
        while self.seats.len() < in_flight
            && let Some(agent) = self.agents.next()
        {
            let seat = self.seats.len();
            self.seats.push(Seat { agent, number: self.begun, outstanding: 0, job: None, pause: Pause::None });
            self.begun += 1;
            self.live += 1;
            self.act(seat)?;
        }
        Ok(())
    }

    /// Lets the agent do what it does without passing time, and those that follow it in its seat.
    fn act(&mut self, seat: usize) -> Result<(), SimulationError> {
        loop {
            self.turn()?;
            let Seat { agent, number, outstanding, job, pause } = &mut self.seats[seat];
            let left = std::mem::replace(pause, Pause::None) == Pause::Leave;
            match if left { Step::Done } else { agent.step() } {
                Step::Fetch => {
                    self.timing.fetches += 1;
                    if self.memory_latency > 0 {
                        self.fetching.push_back((self.now.saturating_add(self.memory_latency), seat));
                        return Ok(());
                    }
                }
                Step::Issue { job: next, holds } => {
                    *job = Some((next, holds, self.now));
                    if self.holder != Some(seat) {
                        self.queue.push_back(seat);
                    }
                    return Ok(());
                }
                Step::Wait if *outstanding == 0 => {
                    return Err(SimulationError::Stuck { agent: *number, cycle: self.now });
                }
                Step::Done if self.holder == Some(seat) => {
                    return Err(SimulationError::Abandoned { agent: *number, cycle: self.now });
                }
                Step::Wait => {
                    self.pause(seat, Pause::Wait);
                    return Ok(());
                }
                Step::Done if *outstanding > 0 => {
                    self.pause(seat, Pause::Leave);
                    return Ok(());
                }
                Step::Done => {
                    self.timing.agents += 1;
                    let Some(next) = self.agents.next() else {
                        self.live -= 1;
                        return Ok(());
                    };
                    (*agent, *number) = (next, self.begun);
                    self.begun += 1;
                }
            }
        }
    }

    fn pause(&mut self, seat: usize, pause: Pause) {
        self.seats[seat].pause = pause;
        self.waiting += 1;
    }

    /// Skips cycles in which nothing is offered, shown or observed. Answers how many.
    fn idle(&mut self, observer: &impl Observer) -> Result<u64, SimulationError> {
        let over = self.fetching.front().map_or(u64::MAX, |(over, _)| *over);
        let until = observer.wants(self.now).map_or(over, |wanted| wanted.min(over));
        if until == u64::MAX && self.inside.is_empty() {
            // Agents that wait without a job are found where they say so; this is for one that this harness lost.
            let agent = self.seats.first().map_or(0, |seat| seat.number);
            return Err(SimulationError::Stuck { agent, cycle: self.now });
        }
        let passed = self.model.idle(until.saturating_sub(self.now));
        self.starve(passed);
        self.now += passed;
        Ok(passed)
    }

    /// One cycle of the datapath.
    fn cycle(&mut self, offering: Option<usize>, observer: &mut impl Observer) -> Woken {
        let shown = self.model.output().is_some();
        let refused = shown && self.stalls.as_mut().is_some_and(|(rng, probability)| rng.random_bool(*probability));
        let offer = offering.and_then(|seat| self.seats[seat].job.as_ref().map(|(job, ..)| (seat, job)));
        if observer.wants(self.now) == Some(self.now) {
            let offered = offer.map(|(seat, job)| (job.kind().opcode(), self.seats[seat].number));
            let accepted = offered.is_some_and(|(opcode, _)| self.model.input_ready(opcode));
            let cycle = Cycle { number: self.now, offered, accepted, shown, taken: shown && !refused };
            observer.cycle(&cycle, self.model.positions());
        }
        let mut woken = Woken::default();
        let kind = offer.map(|(_, job)| job.kind());
        let transfer = self.model.cycle(offer.map(|(_, job)| job), !refused);
        self.timing.sink_refused += u64::from(refused);
        match offering.zip(kind) {
            None => self.starve(1),
            Some((seat, kind)) if transfer.accepted => {
                self.accept(seat, kind);
                woken.accepted = Some(seat);
            }
            Some(_) => self.timing.refused += 1,
        }
        if let Some(outcome) = transfer.output {
            woken.answered = self.answer(&outcome);
        }
        self.now += 1;
        woken
    }

    fn accept(&mut self, seat: usize, kind: JobKind) {
        if self.holder != Some(seat) {
            self.queue.pop_front();
        }
        let Seat { outstanding, job, .. } = &mut self.seats[seat];
        *outstanding += 1;
        let (holds, since) = job.take().map_or((false, self.now), |(_, holds, since)| (holds, since));
        self.holder = holds.then_some(seat);
        self.inside.push_back((seat, self.now));
        self.timing.accepted += 1;
        self.timing.jobs[kind as usize] += 1;
        self.timing.queued += self.now - since;
    }

    /// Hands on the oldest job's answer. Answers whose it was, if that has been waiting.
    fn answer(&mut self, outcome: &M::Outcome) -> Option<usize> {
        let (seat, accepted) = self.inside.pop_front()?;
        self.timing.inside += self.now - accepted;
        let Seat { agent, outstanding, pause, .. } = &mut self.seats[seat];
        agent.answer(outcome);
        *outstanding -= 1;
        let goes_on = match pause {
            Pause::None => false,
            Pause::Wait => true,
            Pause::Leave => *outstanding == 0,
        };
        self.waiting -= usize::from(goes_on);
        goes_on.then_some(seat)
    }

    /// Counts cycles in which nothing was offered.
    fn starve(&mut self, cycles: u64) {
        let starved = &mut self.timing.starved;
        let count = match (self.queue.is_empty(), self.fetching.is_empty(), self.waiting == 0) {
            (false, ..) => &mut starved.held,
            (true, false, false) => &mut starved.both,
            (true, false, true) => &mut starved.memory,
            (true, true, _) => &mut starved.answers,
        };
        *count += cycles;
    }

    /// Asks the watch now and then.
    fn turn(&mut self) -> Result<(), SimulationError> {
        self.turns += 1;
        let agents = self.timing.agents;
        if self.turns.is_multiple_of(TURNS) && !(self.watch)(agents) {
            return Err(SimulationError::Stopped { agents });
        }
        Ok(())
    }
}
