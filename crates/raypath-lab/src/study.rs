//! An operation, and what is needed to study it: which jobs are worth running, and what their answers should be.

use crate::model::{AnyKind, AnyModel, Words};
use crate::operation::AnyOperation;
use crate::stimuli::any_job;
use rand_chacha::ChaCha8Rng;
use raypath_float::Format;
use raypath_model::Model;
use raypath_ops::{Binary32, Operation, from_words, to_words};
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// An operation of one's own, with jobs that are worth running and an oracle for their answers.
///
/// ```
/// use raypath_lab::{AnyStudy, Study};
/// use raypath_ops::{RayTriangle, Rules};
///
/// let study = Study::of(RayTriangle { rules: Rules::Paper })
///     .purpose("no triangle is hit behind the ray's beginning")
///     .oracle("the sign of the distance", |_, answer| {
///         let (t_num, hit) = (f32::from(answer.t_num), bool::from(answer.triangle_hit));
///         if hit && t_num <= 0.0 { Err(format!("a hit at t_num = {t_num}")) } else { Ok(()) }
///     });
/// assert_eq!(AnyStudy::from(study).name(), "triangle");
/// ```
pub struct Study<O> {
    inner: AnyStudy,
    operation: PhantomData<O>,
}

/// A [`Study`] whose operation's type is forgotten.
#[derive(Clone)]
pub struct AnyStudy {
    pub(crate) operation: Arc<dyn AnyOperation>,
    pub(crate) purpose: &'static str,
    pub(crate) stimulus: Option<Stimulus>,
    pub(crate) oracle: Option<Oracle>,
}

/// Makes a job: its words.
pub(crate) type Stimulus = Arc<dyn Fn(&mut ChaCha8Rng) -> Vec<u64> + Send + Sync>;
/// Says what is wrong with an answer to a job, both as words; jobs come in order.
pub(crate) type Judge = Box<dyn FnMut(&[u64], &[u64]) -> Result<(), String>>;

/// Whom answers are held against.
#[derive(Clone)]
pub(crate) struct Oracle {
    /// In a few words.
    pub name: &'static str,
    /// Begins anew, as the operation does after a reset.
    pub judge: Arc<dyn Fn() -> Judge + Send + Sync>,
}

impl<O: Operation + Send + Sync + 'static> Study<O> {
    /// Of an operation; its jobs are drawn port by port until [`stimulus`](Self::stimulus) says better.
    pub fn of(operation: O) -> Self {
        let inner = AnyStudy { operation: Arc::new(operation), purpose: "", stimulus: None, oracle: None };
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

    /// Whom answers are held against; `name` says it in a few words. `judge` says what is wrong with an answer, by other
    /// means than the operation's own. It is told jobs in order, so that it may keep sums: it is cloned as it is here
    /// where the datapath begins anew.
    pub fn oracle(
        mut self,
        name: &'static str,
        judge: impl FnMut(&O::Input<Binary32>, &O::Output<Binary32>) -> Result<(), String> + Clone + Send + Sync + 'static,
    ) -> Self {
        let judge = Arc::new(move || -> Judge {
            let mut judge = judge.clone();
            Box::new(move |job, answer| judge(&from_words(Binary32, job), &from_words(Binary32, answer)))
        });
        self.inner.oracle = Some(Oracle { name, judge });
        self
    }
}

impl<O> From<Study<O>> for AnyStudy {
    fn from(study: Study<O>) -> Self {
        study.inner
    }
}

/// An operation that a crate offers to every program that it is linked into: `raypath_lab::inventory::submit!(Registered(...))` in
/// the operation's own file is all that there is to do.
pub struct Registered(pub fn() -> AnyStudy);

inventory::collect!(Registered);

/// All operations that are registered, by name.
pub fn registered() -> Vec<AnyStudy> {
    let mut all: Vec<AnyStudy> = inventory::iter::<Registered>.into_iter().map(|Registered(study)| study()).collect();
    all.sort_by_key(AnyStudy::name);
    all
}

impl AnyStudy {
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

    /// A random job for a model that has the operation as `kind`: the study's own where it has jobs and the model is in
    /// binary32, and any value at a port that is not the operation's, as that of a tag.
    pub fn job(&self, model: &AnyModel, kind: AnyKind, rng: &mut ChaCha8Rng) -> Words {
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

impl fmt::Debug for AnyStudy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AnyStudy").field("operation", &self.name()).field("oracle", &self.verified_by()).finish()
    }
}
