//! The jobs that agents issue, in the order in which the datapath accepts them.

use crate::{Action, Agent, Progress, SimulationError, System, simulate};
use raypath_model::Model;
use raypath_ops::JobKind;
use std::cell::RefCell;
use std::rc::Rc;

/// Simulates agents as [`simulate`] does, and returns the accepted jobs in order.
///
/// # Errors
/// The errors of [`simulate`].
pub fn accepted_jobs<M: Model<Kind = JobKind>, A: Agent<M>>(
    agents: impl IntoIterator<Item = A>,
    system: &System,
    model: M,
    progress: Progress,
) -> Result<Vec<M::Job>, SimulationError> {
    let jobs = Rc::new(RefCell::new(Vec::new()));
    let recorder = RecordedModel { model, jobs: jobs.clone() };
    let agents = agents.into_iter().map(Recorded);
    simulate(agents, &system.environment, system.pipeline(recorder), &mut (), progress)?;
    Ok(jobs.take())
}

/// A model that keeps its jobs. The pipeline computes a job when it accepts it.
#[derive(Debug, Clone, PartialEq)]
struct RecordedModel<M: Model> {
    model: M,
    jobs: Rc<RefCell<Vec<M::Job>>>,
}

impl<M: Model> Model for RecordedModel<M> {
    type Kind = M::Kind;
    type Job = M::Job;
    type Outcome = M::Outcome;

    fn kind(job: &M::Job) -> M::Kind {
        M::kind(job)
    }

    fn run(&mut self, job: &M::Job) -> M::Outcome {
        self.jobs.borrow_mut().push(job.clone());
        self.model.run(job)
    }

    fn reset(&mut self) {
        self.model.reset();
    }
}

/// An agent of the recorded model.
struct Recorded<A>(A);

impl<M: Model, A: Agent<M>> Agent<RecordedModel<M>> for Recorded<A> {
    fn next_action(&mut self) -> Action<M::Job> {
        self.0.next_action()
    }

    fn receive(&mut self, outcome: &M::Outcome) {
        self.0.receive(outcome);
    }
}
