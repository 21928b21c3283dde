//! Specifications: operations with stimuli and oracles.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, from_words, to_words};
use raypath_sim::jobs::{any_job, random};
use raypath_sim::{AnyOperation, Datapath, OperationId, WordModel, Words};
use std::fmt;
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
    pub(crate) operation: Arc<dyn AnyOperation>,
    pub(crate) purpose: &'static str,
    pub(crate) stimulus: Option<Stimulus>,
    pub(crate) oracle: Option<Oracle>,
}

/// Generates a job as the words of its input ports.
pub(crate) type Stimulus = Arc<dyn Fn(&mut ChaCha8Rng) -> Vec<u64> + Send + Sync>;
/// Checks the result of a job, both as words. The jobs are passed in order. The error describes a wrong result.
pub(crate) type Check = Box<dyn FnMut(&[u64], &[u64]) -> Result<(), String>>;

#[derive(Clone)]
pub(crate) struct Oracle {
    /// A short description, such as `exact rationals`.
    pub name: &'static str,
    /// Creates the check for a stream of jobs that starts after a reset.
    pub check: Arc<dyn Fn() -> Check + Send + Sync>,
}

impl<O: Operation + Send + Sync + 'static> OperationSpec<O> {
    /// The specification of an operation without an oracle, whose jobs are drawn port by port.
    pub fn of(operation: O) -> Self {
        let inner = AnyOperationSpec { operation: Arc::new(operation), purpose: "", stimulus: None, oracle: None };
        Self { inner, operation: PhantomData }
    }

    /// Sets a short description of the use of the operation.
    pub fn purpose(mut self, purpose: &'static str) -> Self {
        self.inner.purpose = purpose;
        self
    }

    /// Sets the generator of random jobs.
    pub fn stimulus(mut self, job: impl Fn(&mut ChaCha8Rng) -> O::Input<Binary32> + Send + Sync + 'static) -> Self {
        self.inner.stimulus = Some(Arc::new(move |rng| {
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

    /// A short description of its use; may be empty.
    pub fn purpose(&self) -> &'static str {
        self.purpose
    }

    /// The description of the oracle, if there is one.
    pub fn oracle_name(&self) -> Option<&'static str> {
        self.oracle.as_ref().map(|oracle| oracle.name)
    }

    /// A random job for a model that has the operation as `kind`: from the generator of the specification if the model
    /// is in binary32, otherwise from [`any_job`], which also provides the values of other ports, such as a tag.
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

    /// What the oracle says about an outcome: the words at all ports that the operation may have. The job is the first
    /// of its stream. None without an oracle.
    pub fn judges(&self, job: &[u64], outcome: &[u64]) -> Option<Result<(), String>> {
        self.oracle.as_ref().map(|oracle| (oracle.check)()(job, outcome))
    }

    /// The operation.
    pub fn operation(&self) -> Arc<dyn AnyOperation> {
        self.operation.clone()
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
        let model = model.clone();
        let paper = config.kinds().iter().find(|paper| kind == **paper);
        if let Some(spec) = specs.iter().find(|spec| spec.name() == kind.name()).cloned() {
            Box::new(move |rng| spec.job(&model, kind, rng))
        } else if let Some(&paper) = paper {
            let mut jobs = random(&model, config.semantics.format, seed, &[paper]);
            Box::new(move |rng| jobs.next().unwrap_or_else(|| any_job(&model, kind, rng)))
        } else {
            Box::new(move |rng| any_job(&model, kind, rng))
        }
    };
    let mut sources: Vec<Source> = kinds.iter().zip(seed..).map(source).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let chosen = rng.random_range(0..sources.len());
        sources[chosen](&mut rng)
    })
}

type Source = Box<dyn FnMut(&mut ChaCha8Rng) -> Words>;
