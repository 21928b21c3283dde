//! An operation, and what is needed to spec it: which jobs are worth running, and what their answers should be.

use rand::rngs::ChaCha8Rng;
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, from_words, to_words};
use raypath_sim::AnyOperation;
use raypath_sim::jobs::any_job;
use raypath_sim::{OperationId, WordModel, Words};
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// An operation of one's own, with jobs that are worth running and an oracle for their answers.
///
/// ```
/// use raypath_oracle::{AnyOperationSpec, OperationSpec};
/// use raypath_ops::{RayTriangle, Rules};
///
/// let spec = OperationSpec::of(RayTriangle { rules: Rules::Paper })
///     .purpose("no triangle is hit behind the ray's beginning")
///     .oracle("the sign of the distance", |_, answer| {
///         let (t_num, hit) = (f32::from(answer.t_num), bool::from(answer.triangle_hit));
///         if hit && t_num <= 0.0 { Err(format!("a hit at t_num = {t_num}")) } else { Ok(()) }
///     });
/// assert_eq!(AnyOperationSpec::from(spec).name(), "triangle");
/// ```
pub struct OperationSpec<O> {
    inner: AnyOperationSpec,
    operation: PhantomData<O>,
}

/// A [`OperationSpec`] whose operation's type is forgotten.
#[derive(Clone)]
pub struct AnyOperationSpec {
    pub(crate) operation: Arc<dyn AnyOperation>,
    pub(crate) purpose: &'static str,
    pub(crate) stimulus: Option<Stimulus>,
    pub(crate) oracle: Option<Oracle>,
}

/// Makes a job: its words.
pub(crate) type Stimulus = Arc<dyn Fn(&mut ChaCha8Rng) -> Vec<u64> + Send + Sync>;
/// Says what is wrong with an answer to a job, both as words; jobs come in order.
pub(crate) type Check = Box<dyn FnMut(&[u64], &[u64]) -> Result<(), String>>;

/// Whom answers are held against.
#[derive(Clone)]
pub(crate) struct Oracle {
    /// In a few words.
    pub name: &'static str,
    /// Begins anew, as the operation does after a reset.
    pub check: Arc<dyn Fn() -> Check + Send + Sync>,
}

impl<O: Operation + Send + Sync + 'static> OperationSpec<O> {
    /// Of an operation; its jobs are drawn port by port until [`stimulus`](Self::stimulus) says better.
    pub fn of(operation: O) -> Self {
        let inner = AnyOperationSpec { operation: Arc::new(operation), purpose: "", stimulus: None, oracle: None };
        Self { inner, operation: PhantomData }
    }

    /// What the operation is for, in a few words.
    pub fn purpose(mut self, purpose: &'static str) -> Self {
        self.inner.purpose = purpose;
        self
    }

    /// Jobs that are worth running: `job` makes one.
    pub fn stimulus(mut self, job: impl Fn(&mut ChaCha8Rng) -> O::Input<Binary32> + Send + Sync + 'static) -> Self {
        self.inner.stimulus = Some(Arc::new(move |rng| {
            let mut words = Vec::new();
            to_words(&job(rng), &mut words);
            words
        }));
        self
    }

    /// Whom answers are held against; `name` says it in a few words. `check` says what is wrong with an answer, by
    /// other means than the operation's own. It is told jobs in order, so that it may keep sums: it is cloned as it is
    /// here where the datapath begins anew.
    pub fn oracle(
        mut self,
        name: &'static str,
        check: impl FnMut(&O::Input<Binary32>, &O::Output<Binary32>) -> Result<(), String> + Clone + Send + Sync + 'static,
    ) -> Self {
        let check = Arc::new(move || -> Check {
            let mut check = check.clone();
            Box::new(move |job, answer| check(&from_words(Binary32, job), &from_words(Binary32, answer)))
        });
        self.inner.oracle = Some(Oracle { name, check });
        self
    }
}

impl<O> From<OperationSpec<O>> for AnyOperationSpec {
    fn from(spec: OperationSpec<O>) -> Self {
        spec.inner
    }
}

impl AnyOperationSpec {
    /// The operation's name.
    pub fn name(&self) -> &'static str {
        self.operation.name()
    }

    /// What it is for, in a few words; may be empty.
    pub fn for_what(&self) -> &'static str {
        self.purpose
    }

    /// Whom its answers are held against, in a few words.
    pub fn verified_by(&self) -> Option<&'static str> {
        self.oracle.as_ref().map(|oracle| oracle.name)
    }

    /// A random job for a model that has the operation as `kind`: the spec's own where it has jobs and the model is in
    /// binary32, and any value at a port that is not the operation's, as that of a tag.
    pub fn job(&self, model: &WordModel, kind: OperationId, rng: &mut ChaCha8Rng) -> Words {
        match &self.stimulus {
            Some(stimulus) if model.format() == Format::BINARY32 => {
                let mut words = model.present_inputs(kind, stimulus(rng));
                words.extend(any_job(model, kind, rng).as_words().iter().skip(words.len()));
                model.job_of_words(kind, &words)
            }
            _ => any_job(model, kind, rng),
        }
    }

    /// The operation itself.
    pub fn operation(&self) -> Arc<dyn AnyOperation> {
        self.operation.clone()
    }
}

impl fmt::Debug for AnyOperationSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AnyOperationSpec")
            .field("operation", &self.name())
            .field("oracle", &self.verified_by())
            .finish()
    }
}
