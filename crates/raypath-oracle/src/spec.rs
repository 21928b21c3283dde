//! Specifications: operations with stimuli and oracles.

use crate::exact::Oracle as Exact;
use crate::stimuli::Stimuli;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, from_words, to_words};
use raypath_sim::jobs::{any_job, random};
use raypath_sim::{AnyOperation, Datapath, OperationId, WordModel, Words};
use std::fmt;
use std::iter;
use std::marker::PhantomData;
use std::sync::Arc;

/// The specification of an operation: random jobs, and an oracle that checks their results.
///
/// ```
/// use raypath_oracle::{AnyOperationSpec, OperationSpec};
/// use raypath_ops::{RayTriangle, Rounding, Rules};
///
/// let spec = OperationSpec::of(RayTriangle { rules: Rules::Paper, rounding: Rounding::Unit })
///     .purpose("a ray against a triangle")
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

/// An [`OperationSpec`] for an operation of any type.
#[derive(Clone)]
pub struct AnyOperationSpec {
    operation: Arc<dyn AnyOperation>,
    purpose: &'static str,
    stimulus: Stimulus,
    oracle: Option<Oracle>,
}

/// How jobs are drawn.
#[derive(Clone)]
enum Stimulus {
    /// Port by port.
    ByPort,
    /// By [`Stimuli`].
    Stimuli,
    /// As the words of the input ports, in binary32.
    Binary32(Draw),
}

/// Draws the words of the input ports.
type Draw = Arc<dyn Fn(&mut ChaCha8Rng) -> Vec<u64> + Send + Sync>;

/// An endless source of jobs.
pub(crate) type Source = Box<dyn Iterator<Item = Words>>;
/// Checks the outcome of a job. The jobs are passed in order. The error describes a wrong outcome.
pub(crate) type Check = Box<dyn FnMut(&Words, &Words) -> Result<(), String>>;

#[derive(Clone)]
enum Oracle {
    /// [`Exact`], in any format.
    Exact,
    /// A description of the method, and a function that makes the check of a stream of jobs that starts after a reset,
    /// in binary32.
    Binary32(&'static str, Arc<dyn Fn(&WordModel) -> Check + Send + Sync>),
}

impl<O: Operation + Send + Sync + 'static> OperationSpec<O> {
    /// The specification of an operation without an oracle, whose jobs are drawn port by port.
    pub fn of(operation: O) -> Self {
        let operation = Arc::new(operation);
        let inner = AnyOperationSpec { operation, purpose: "", stimulus: Stimulus::ByPort, oracle: None };
        Self { inner, operation: PhantomData }
    }

    /// Sets a short description of the use of the operation.
    pub fn purpose(mut self, purpose: &'static str) -> Self {
        self.inner.purpose = purpose;
        self
    }

    /// Sets the generator of random jobs.
    pub fn stimulus(mut self, job: impl Fn(&mut ChaCha8Rng) -> O::Input<Binary32> + Send + Sync + 'static) -> Self {
        self.inner.stimulus = Stimulus::Binary32(Arc::new(move |rng| {
            let mut words = Vec::new();
            to_words(&job(rng), &mut words);
            words
        }));
        self
    }

    /// Sets the oracle. `name` is a short description of its method. `check` returns an error that describes a wrong
    /// result, and should not use the equations of the operation. It gets the jobs in order and may keep a state. It is
    /// cloned in its initial state for each stream of jobs that starts after a reset.
    pub fn oracle(
        mut self,
        name: &'static str,
        check: impl FnMut(&O::Input<Binary32>, &O::Output<Binary32>) -> Result<(), String> + Clone + Send + Sync + 'static,
    ) -> Self {
        let make = move |model: &WordModel| -> Check {
            let (mut check, model) = (check.clone(), model.clone());
            Box::new(move |job, outcome| {
                let (job, outcome) = (model.all_inputs(job), model.all_outputs(outcome));
                check(&from_words(Binary32, &job), &from_words(Binary32, &outcome))
            })
        };
        self.inner.oracle = Some(Oracle::Binary32(name, Arc::new(make)));
        self
    }
}

impl<O> From<OperationSpec<O>> for AnyOperationSpec {
    fn from(spec: OperationSpec<O>) -> Self {
        spec.inner
    }
}

impl AnyOperationSpec {
    /// The specification of an operation that [`Stimuli`] and [`Exact`] know.
    pub(crate) fn known(operation: impl Operation + Send + Sync + 'static, purpose: &'static str) -> Self {
        let operation = Arc::new(operation);
        Self { operation, purpose, stimulus: Stimulus::Stimuli, oracle: Some(Oracle::Exact) }
    }

    /// The operation's name.
    pub fn name(&self) -> &'static str {
        self.operation.name()
    }

    /// A short description of its use; may be empty.
    pub fn purpose(&self) -> &'static str {
        self.purpose
    }

    /// The description of the oracle, if there is one.
    pub fn oracle_name(&self) -> Option<&'static str> {
        self.oracle.as_ref().map(|oracle| match oracle {
            Oracle::Exact => "exact arithmetic",
            Oracle::Binary32(name, _) => name,
        })
    }

    /// The operation.
    pub fn operation(&self) -> Arc<dyn AnyOperation> {
        self.operation.clone()
    }

    /// The check of a stream of jobs of a datapath that starts after a reset; none without an oracle for its format.
    pub(crate) fn check(&self, datapath: &Datapath) -> Option<Check> {
        let model = datapath.model();
        match self.oracle.as_ref()? {
            Oracle::Exact => {
                let mut oracle = Exact::new(datapath.config().semantics, &model);
                Some(Box::new(move |job, outcome| match oracle.run(job)? {
                    expected if expected == *outcome => Ok(()),
                    expected => Err(format!("expected {expected:?}")),
                }))
            }
            Oracle::Binary32(_, make) => (model.format() == Format::BINARY32).then(|| make(&model)),
        }
    }

    /// Random jobs for a model that has the operation as `kind`, reproducible by `seed`. If the specification has no
    /// generator for the model's format, they are those of [`any_job`], which also provides the values of ports that a
    /// generator lacks, such as a tag.
    pub(crate) fn source(&self, model: &WordModel, kind: OperationId, seed: u64) -> Source {
        let (model, mut rng) = (model.clone(), ChaCha8Rng::seed_from_u64(seed));
        match &self.stimulus {
            Stimulus::Stimuli => {
                let (mut stimuli, mut words) = (Stimuli::new(&model, seed), Vec::new());
                Box::new(iter::repeat_with(move || {
                    stimuli.next_of(kind, &mut words);
                    model.job_of_words(kind, &words)
                }))
            }
            Stimulus::Binary32(draw) if model.format() == Format::BINARY32 => {
                let draw = draw.clone();
                Box::new(iter::repeat_with(move || {
                    let mut words = model.present_inputs(kind, draw(&mut rng));
                    words.extend(any_job(&model, kind, &mut rng).as_words().iter().skip(words.len()));
                    model.job_of_words(kind, &words)
                }))
            }
            Stimulus::ByPort | Stimulus::Binary32(_) => {
                Box::new(iter::repeat_with(move || any_job(&model, kind, &mut rng)))
            }
        }
    }
}

impl fmt::Debug for AnyOperationSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AnyOperationSpec")
            .field("operation", &self.name())
            .field("oracle", &self.oracle_name())
            .finish()
    }
}

/// An endless stream of jobs of the operations `kinds` of a datapath, reproducible by `seed`. Jobs of an operation in
/// `specs` come from its specification, jobs of the paper's operations from [`random`](fn@random), and others from
/// [`any_job`]. `kinds` must not be empty.
pub fn jobs(
    datapath: &Datapath,
    specs: &[AnyOperationSpec],
    seed: u64,
    kinds: &[OperationId],
) -> impl Iterator<Item = Words> + use<> {
    let (model, config) = (datapath.model(), datapath.config());
    let source = |(&kind, seed): (&OperationId, u64)| -> Source {
        let paper = config.kinds().iter().find(|paper| kind == **paper);
        match (specs.iter().find(|spec| spec.name() == kind.name()), paper) {
            (Some(spec), _) => spec.source(&model, kind, seed),
            (None, Some(&paper)) => Box::new(random(&model, config.semantics.format, seed, &[paper])),
            (None, None) => {
                let (model, mut rng) = (model.clone(), ChaCha8Rng::seed_from_u64(seed));
                Box::new(iter::repeat_with(move || any_job(&model, kind, &mut rng)))
            }
        }
    };
    let mut sources: Vec<Source> = kinds.iter().zip(seed..).map(source).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    iter::from_fn(move || {
        let chosen = rng.random_range(0..sources.len());
        sources[chosen].next()
    })
}
