//! The class `Pipeline`.

use crate::datapath::Datapath;
use crate::error::exception;
use crate::job::{Job, Outcome};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use raypath_embed as embed;
use std::sync::{Mutex, PoisonError};

/// The cycle-exact model of a datapath, whose jobs carry a tag. In every cycle it accepts and delivers what the
/// hardware does.
///
/// A cycle consists of at most one accepted ``offer``, then a ``step``. A pipeline belongs to one thread at a time.
///
/// Args:
///     datapath: the datapath, which other pipelines may share.
///
/// Example:
///     >>> import raypath
///     >>> datapath = raypath.Datapath()
///     >>> pipeline = raypath.Pipeline(datapath)
///     >>> pipeline.offer(raypath.Job.timing(datapath, "quadbox"), tag=7)
///     True
///     >>> pipeline.skip(100)
///     12
///     >>> pipeline.step().tag
///     7
#[pyclass(module = "raypath")]
pub struct Pipeline {
    // Not locked: the mutex only makes the pipeline shareable between threads, as a class must be.
    inner: Mutex<embed::Pipeline>,
    datapath: Py<Datapath>,
    operations: Vec<embed::OperationId>,
}

impl Pipeline {
    fn inner(&mut self) -> &mut embed::Pipeline {
        self.inner.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Pipeline {
    #[new]
    fn new(datapath: &Bound<'_, Datapath>) -> Self {
        let embedded = &datapath.get().inner;
        let inner = Mutex::new(embed::Pipeline::new(embedded));
        Self { inner, operations: embedded.operations(), datapath: datapath.clone().unbind() }
    }

    /// Offers a job in this cycle.
    ///
    /// Args:
    ///     job: the job, of an operation of the datapath.
    ///     tag: an integer of 0 to 2**64 - 1 that its outcome carries.
    ///
    /// Returns:
    ///     Whether the job is accepted in this cycle. A second job in a cycle is not.
    ///
    /// Raises:
    ///     ValueError: a datapath without the operation; a beat of more coordinates than the datapath has lanes.
    #[pyo3(signature = (job, tag = 0))]
    fn offer(&mut self, job: &Bound<'_, Job>, tag: u64) -> PyResult<bool> {
        let lanes = self.datapath.get().inner.lanes();
        job.get().offered(lanes, |job| self.inner().offer(job, tag)).map_err(exception)
    }

    /// One clock cycle: the job that was accepted enters, and an outcome may leave.
    ///
    /// Args:
    ///     output_ready: whether the outcome at the output leaves in this cycle.
    ///
    /// Returns:
    ///     The outcome that leaves, or None.
    #[pyo3(signature = (output_ready = true))]
    fn step(&mut self, output_ready: bool) -> Option<Outcome> {
        let tagged = *self.inner().step(output_ready)?;
        let words = self.inner().left_words().cloned();
        Some(Outcome::new(tagged, words, &self.operations, self.datapath.get().inner.config().semantics.format))
    }

    /// Advances cycles in which nothing else is offered and the sink is not ready, and stops in the first with an
    /// outcome at the output.
    ///
    /// Args:
    ///     cycles: the maximum number of cycles.
    ///
    /// Returns:
    ///     The number of cycles.
    fn skip(&mut self, cycles: u64) -> u64 {
        self.inner().skip(cycles)
    }

    /// The number of jobs inside, with the one that was accepted in this cycle.
    #[getter]
    fn occupancy(&mut self) -> usize {
        self.inner().occupancy()
    }

    /// Whether there is an outcome at the output in this cycle.
    #[getter]
    fn output_valid(&mut self) -> bool {
        self.inner().output_valid()
    }

    /// Whether a job of an operation would be accepted in this cycle.
    ///
    /// Raises:
    ///     ValueError: a datapath without the operation.
    fn input_ready(&mut self, operation: &str) -> PyResult<bool> {
        let opcode = self.datapath.get().inner.operation(operation).map_err(exception)?.opcode();
        Ok(self.inner().input_ready(opcode))
    }

    /// The whole state as bytes, for ``restore``.
    fn save<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.inner().save())
    }

    /// Takes over a state that a pipeline of an equal datapath saved, in this release of raypath.
    ///
    /// Raises:
    ///     ValueError: other bytes. Then nothing changes.
    fn restore(&mut self, state: &Bound<'_, PyBytes>) -> PyResult<()> {
        self.inner().restore(state.as_bytes()).map_err(exception)
    }

    /// The arguments that make a pipeline of the same datapath, for ``copy`` and ``pickle``.
    fn __getnewargs__(&self, py: Python<'_>) -> (Py<Datapath>,) {
        (self.datapath.clone_ref(py),)
    }

    fn __getstate__<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.save(py)
    }

    fn __setstate__(&mut self, state: &Bound<'_, PyBytes>) -> PyResult<()> {
        self.restore(state)
    }

    /// A cycle of reset: all jobs are lost, and the accumulators are zero.
    fn reset(&mut self) {
        self.inner().reset();
    }

    fn __repr__(&mut self) -> String {
        format!(
            "<raypath.Pipeline: {} jobs inside; {}>",
            self.inner().occupancy(),
            self.datapath.get().inner.description()
        )
    }
}
