//! A job in a folded pipeline: its positions, and what registers hold while it moves and waits.

use super::{At, FALSE, Literal, SymbolicJob, TRUE, Time, Word, is_exit};
use raypath_hdl::{Module, RegisterInfo};
use raypath_model::{Control, Shape};

/// The positions of a folded pipeline. They are counted as moves of the job: 0 at the ports, 1 at position 0.
#[derive(Debug, Clone, Copy)]
pub struct Rounds {
    /// The least number of positions between two jobs.
    interval: u32,
    /// The moves after which the job is at the last position.
    last: u32,
    /// Whether jobs wait, at the last position and at those a multiple of the interval before it.
    waits: bool,
}

/// The position in the name of a port such as `at_3_o` or `moves_3_i`.
pub fn position(port: &str) -> Option<u32> {
    let number = port.strip_prefix("at_").or_else(|| port.strip_prefix("moves_"))?;
    number.split_once('_')?.0.parse().ok()
}

impl Rounds {
    /// `None` if the pipeline is not folded.
    pub fn new(shape: &Shape) -> Option<Self> {
        let (interval, latency) = (shape.interval as u32, shape.latency as u32);
        let rounds = Self { interval, last: latency - 1, waits: shape.control == Control::Skid };
        (interval > 1).then_some(rounds)
    }

    fn waits_after(self, moves: u32) -> bool {
        self.waits && moves > 0 && (self.last - moves).is_multiple_of(self.interval)
    }

    /// What the control says about a job after these moves; `None` if it depends on jobs that are an interval away.
    pub fn control_value(self, module: &str, port: &str, time: Time) -> Option<u64> {
        let (moves, is_moving) = match time {
            Time::Moving(moves) => (moves, true),
            Time::Waiting(moves) => (moves, false),
            _ => return None,
        };
        let place = match (module, port) {
            ("raypath_rounds", "enters_o") | ("raypath_credit", "valid_o") => 0,
            ("raypath_rounds", _) => position(port)? + 1,
            _ => return None,
        };
        match place.abs_diff(moves) {
            0 => Some((is_moving || port.starts_with("at_")).into()),
            distance if distance < self.interval => Some(0),
            _ => None,
        }
    }
}

impl SymbolicJob<'_> {
    /// A register without reset after so many moves of the job, and after any wait there.
    pub fn after_moves(&mut self, scope: usize, info: &RegisterInfo, moves: u32) -> Word {
        let Some(before) = moves.checked_sub(1) else { return self.arbitrary(scope, info, Time::Moving(0)) };
        let arrived = self.next(At { scope, time: Time::Moving(before) }, info);
        if !self.job.rounds.is_some_and(|rounds| rounds.waits_after(moves)) {
            return arrived;
        }
        let waiting = At { scope, time: Time::Waiting(moves) };
        let enable = info.enable.map_or(TRUE, |enable| self.word(waiting, enable)[0]);
        if enable == FALSE {
            return arrived;
        }
        let next = self.word(waiting, info.next);
        if next == arrived {
            return arrived;
        }
        // How often it loads is not known, but from what it loads.
        let width = arrived.len() as u32;
        self.logic.function(format!("after a wait {width}"), [arrived, vec![enable], next].concat(), width)
    }

    /// What the control says about a position that another job may have: jobs are an interval apart, so that at most
    /// one of so many neighbouring positions has one. `None` for other ports.
    pub fn of_another_job(&mut self, instance: &str, module: &Module, port: &str, time: Time) -> Option<Word> {
        let (rounds, place) = (self.job.rounds?, position(port).filter(|_| module.name() == "raypath_rounds")?);
        let (Time::Moving(moves) | Time::Waiting(moves)) = time else { return None };
        let mut jobs: Vec<Literal> = Vec::new();
        for place in 0..=place {
            let is_near = (place + 1).abs_diff(moves) < rounds.interval;
            let others = jobs.len().saturating_sub(rounds.interval as usize - 1);
            let arbitrary = self.arbitrary_output(instance, &format!("at_{place}_o"), time, 1)[0];
            let is_at = jobs[others..].iter().fold(arbitrary, |is_at, &other| self.logic.and(is_at, other ^ 1));
            jobs.push(if is_near { FALSE } else { is_at });
        }
        let is_at = jobs.pop()?;
        if port.starts_with("at_") {
            return Some(vec![is_at]);
        }
        let moves = self.arbitrary_output(instance, port, time, 1)[0];
        Some(vec![self.logic.and(is_at, moves)])
    }

    /// When the outputs of a module are compared: those of the outermost one, and the opcode of a stage.
    pub fn times_of_outputs(&self, module: &Module, scope: usize) -> Vec<Time> {
        match self.job.rounds {
            Some(rounds) if scope != 0 && !is_exit(module) => (1..=rounds.last).map(Time::Moving).collect(),
            Some(_) => vec![Time::After],
            None => vec![if module.is_clocked() && scope != 0 { Time::After } else { Time::Arriving }],
        }
    }

    /// When the next states of a module are compared.
    pub fn times_of_states(&self, module: &Module) -> Vec<Time> {
        match self.job.rounds {
            Some(rounds) if !is_exit(module) => {
                let all = 0..=rounds.last;
                let waits = all.clone().filter(|&moves| rounds.waits_after(moves)).map(Time::Waiting);
                all.clone().map(Time::Moving).chain(waits).collect()
            }
            _ => vec![Time::Arriving],
        }
    }

    /// The moment around a module at which its inputs have the job's values; `None` if they are arbitrary.
    pub fn time_outside(&self, module: &Module, time: Time) -> Option<Time> {
        match (self.job.rounds, time) {
            (_, Time::Moving(_) | Time::Waiting(_)) => Some(time),
            (Some(rounds), Time::Arriving) => Some(Time::Moving(rounds.last)),
            (Some(_), Time::After) => (!module.is_clocked()).then_some(Time::After),
            (None, Time::Arriving) => Some(Time::Arriving),
            (None, Time::After) | (_, Time::Leaving) => None,
        }
    }

    /// The moment in a module that belongs to a moment around it; `None` if its outputs do not depend on the job then.
    pub fn time_inside(&self, module: &Module, time: Time) -> Option<Time> {
        match (self.job.rounds, time) {
            (None, _) => Some(if module.is_clocked() { Time::After } else { Time::Arriving }),
            (Some(_), _) if !module.is_clocked() => Some(time),
            (Some(_), Time::After) => is_exit(module).then_some(Time::After),
            (Some(_), _) => (!is_exit(module)).then_some(time),
        }
    }
}
