//! The classes `Job` and `Outcome` of a pipeline.

use crate::array::{item, items, structure};
use crate::datapath::Datapath;
use crate::error::{exception, value_error};
use crate::tables::row;
use crate::words::words_of;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raypath_embed::{
    self as embed, AngularResult, Beat, Bounds, EuclideanResult, QuadboxResult, Ray, TriangleResult, Vertices,
};
use raypath_float::Format;
use raypath_ops::PortKind;

/// A job for a ``Pipeline``. The static methods make jobs.
#[pyclass(module = "raypath", frozen)]
pub struct Job(Kind);

enum Kind {
    Quadbox { ray: Ray, boxes: [Bounds; 4] },
    Triangle { ray: Ray, triangle: Vertices },
    Beat { is_angular: bool, a: Vec<f32>, b: Vec<f32>, mask: u64, reset_accum: bool },
    Words { opcode: u64, inputs: Vec<u64> },
    Timing { opcode: u64 },
}

#[pymethods]
impl Job {
    /// A ray against four boxes.
    ///
    /// Args:
    ///     ray: an item of ``raypath.rays``.
    ///     boxes: float32 array of shape (4, 2, 3).
    ///
    /// Raises:
    ///     ValueError: another type or shape.
    #[staticmethod]
    fn quadbox(ray: &Bound<'_, PyAny>, boxes: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(Kind::Quadbox { ray: structure(ray, "ray")?, boxes: item(boxes, "boxes")? }))
    }

    /// A ray against a triangle.
    ///
    /// Args:
    ///     ray: an item of ``raypath.rays``.
    ///     triangle: float32 array of shape (3, 3).
    ///
    /// Raises:
    ///     ValueError: another type or shape.
    #[staticmethod]
    fn triangle(ray: &Bound<'_, PyAny>, triangle: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(Kind::Triangle { ray: structure(ray, "ray")?, triangle: item(triangle, "triangle")? }))
    }

    /// A beat of a Euclidean distance: the squared distance of up to ``lanes`` coordinates is added to the accumulator.
    ///
    /// Args:
    ///     a: float32 array of shape (k,), with k at most the lanes of the datapath. Further lanes are masked.
    ///     b: float32 array of the same shape.
    ///     mask: bit i says whether coordinate i counts; all if it is None.
    ///     reset: whether the accumulator is zero for the next beat.
    ///
    /// Raises:
    ///     ValueError: another type or shape; more than 64 coordinates.
    #[staticmethod]
    #[pyo3(signature = (a, b, *, mask = None, reset = true))]
    fn euclidean(a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>, mask: Option<u64>, reset: bool) -> PyResult<Self> {
        beat(false, a, b, mask, reset)
    }

    /// A beat of an angular distance: dot product and squared norm of up to ``lanes / 2`` coordinates are added to the
    /// accumulators.
    ///
    /// Args:
    ///     q: float32 array of shape (k,), with k at most half the lanes of the datapath. Further lanes are masked.
    ///     c: float32 array of the same shape.
    ///     mask: bit i says whether coordinate i counts; all if it is None.
    ///     reset: whether the accumulators are zero for the next beat.
    ///
    /// Raises:
    ///     ValueError: another type or shape; more than 64 coordinates.
    #[staticmethod]
    #[pyo3(signature = (q, c, *, mask = None, reset = true))]
    fn angular(q: &Bound<'_, PyAny>, c: &Bound<'_, PyAny>, mask: Option<u64>, reset: bool) -> PyResult<Self> {
        beat(true, q, c, mask, reset)
    }

    /// A job of any operation of a datapath, from the values at its input ports.
    ///
    /// Args:
    ///     datapath: the datapath of the pipeline.
    ///     operation: the name of the operation.
    ///     ports: a number for each input port, as for ``Datapath.run``.
    ///
    /// Raises:
    ///     ValueError: a datapath without the operation; a port that is missing or unknown; arrays of other than one
    ///         item.
    #[staticmethod]
    #[pyo3(signature = (datapath, operation, /, **ports))]
    fn words(datapath: &Bound<'_, Datapath>, operation: &str, ports: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let datapath = &datapath.get().inner;
        let operation = datapath.operation(operation).map_err(exception)?;
        let (inputs, count) = words_of(datapath, operation, ports)?;
        if count != 1 {
            return Err(value_error(format!("{operation}: found arrays of shape ({count},), expected one job")));
        }
        Ok(Self(Kind::Words { opcode: operation.opcode(), inputs }))
    }

    /// A job of an operation without values, for its exact timing. Accumulators do not change.
    ///
    /// Args:
    ///     datapath: the datapath of the pipeline.
    ///     operation: the name of the operation.
    ///
    /// Raises:
    ///     ValueError: a datapath without the operation.
    #[staticmethod]
    fn timing(datapath: &Bound<'_, Datapath>, operation: &str) -> PyResult<Self> {
        let operation = datapath.get().inner.operation(operation).map_err(exception)?;
        Ok(Self(Kind::Timing { opcode: operation.opcode() }))
    }
}

impl Job {
    /// Passes the job to `offer`, for a datapath of `lanes` Euclidean lanes.
    pub fn offered<T>(&self, lanes: usize, offer: impl FnOnce(&embed::Job<'_>) -> T) -> T {
        match &self.0 {
            Kind::Quadbox { ray, boxes } => offer(&embed::Job::Quadbox { ray, boxes }),
            Kind::Triangle { ray, triangle } => offer(&embed::Job::Triangle { ray, triangle }),
            Kind::Words { opcode, inputs } => offer(&embed::Job::Words { opcode: *opcode, inputs }),
            Kind::Timing { opcode } => offer(&embed::Job::Timing { opcode: *opcode }),
            Kind::Beat { is_angular, a, b, mask, reset_accum } => {
                let lanes = if *is_angular { lanes / 2 } else { lanes };
                // A beat of more coordinates than lanes is an error of the pipeline.
                let padded = |vector: &[f32]| {
                    let mut vector = vector.to_vec();
                    vector.resize(vector.len().max(lanes), 0.0);
                    vector
                };
                let (a, b) = (padded(a), padded(b));
                let beat = Beat { a: &a, b: &b, mask: *mask, reset_accum: *reset_accum };
                offer(&if *is_angular { embed::Job::Angular(beat) } else { embed::Job::Euclidean(beat) })
            }
        }
    }
}

fn beat(is_angular: bool, a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>, mask: Option<u64>, reset: bool) -> PyResult<Job> {
    let [name_a, name_b] = if is_angular { ["q", "c"] } else { ["a", "b"] };
    let a = items::<f32>(a, name_a)?;
    let b = crate::array::items_like::<f32>(b, name_b, a.len(), name_a)?;
    if !(1..=64).contains(&a.len()) {
        return Err(value_error(format!("{name_a}: found {} coordinates, expected 1 to 64", a.len())));
    }
    let all = u64::MAX >> (64 - a.len());
    let (a, b, mask) = (a.to_vec(), b.to_vec(), mask.unwrap_or(all) & all);
    Ok(Job(Kind::Beat { is_angular, a, b, mask, reset_accum: reset }))
}

/// The outcome of a job that left a ``Pipeline``.
#[pyclass(module = "raypath", frozen)]
pub struct Outcome {
    tag: u64,
    outcome: embed::Outcome,
    words: Option<embed::Words>,
    operation: &'static str,
    format: Format,
}

impl Outcome {
    /// `words` are those of an outcome of words.
    pub fn new(
        embed::Tagged { tag, outcome }: embed::Tagged,
        words: Option<embed::Words>,
        operations: &[embed::OperationId],
        format: Format,
    ) -> Self {
        let named = |opcode: u64| operations.iter().find(|operation| operation.opcode() == opcode);
        let operation = match outcome {
            embed::Outcome::Quadbox(_) => "quadbox",
            embed::Outcome::Triangle(_) => "triangle",
            embed::Outcome::Euclidean(_) => "euclidean",
            embed::Outcome::Angular(_) => "angular",
            embed::Outcome::Words(opcode) | embed::Outcome::Timing(opcode) => {
                named(opcode).map_or("", |operation| operation.name())
            }
        };
        Self { tag, outcome, words, operation, format }
    }
}

#[pymethods]
impl Outcome {
    /// The tag with which the job was offered.
    #[getter]
    fn tag(&self) -> u64 {
        self.tag
    }

    /// The name of the operation.
    #[getter]
    fn operation(&self) -> &'static str {
        self.operation
    }

    /// The values by name: those of the arrays of ``Datapath`` for the paper's operations (``is_intersect``, ``tmin``
    /// and ``box_index`` have four items), ``accumulator`` or ``dot_product`` and ``norm`` with ``reset_accum`` for
    /// beats, those at the output ports for jobs of words, none for jobs without values.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.outcome {
            embed::Outcome::Quadbox(QuadboxResult { tmin, is_intersect, box_index }) => {
                row!(py, "is_intersect": is_intersect.map(|hit| hit == 1), "tmin": tmin,
                    "box_index": box_index.map(u32::from))
            }
            embed::Outcome::Triangle(TriangleResult { t_num, t_denom, triangle_hit }) => {
                row!(py, "triangle_hit": *triangle_hit == 1, "t_num": t_num, "t_denom": t_denom)
            }
            embed::Outcome::Euclidean(EuclideanResult { accumulator, reset_accum }) => {
                row!(py, "accumulator": accumulator, "reset_accum": *reset_accum == 1)
            }
            embed::Outcome::Angular(AngularResult { dot_product, norm, reset_accum }) => {
                row!(py, "dot_product": dot_product, "norm": norm, "reset_accum": *reset_accum == 1)
            }
            embed::Outcome::Words(_) => {
                let values = PyDict::new(py);
                for port in self.words.iter().flat_map(embed::Words::ports) {
                    if port.kind == PortKind::Number && self.format == Format::BINARY32 {
                        values.set_item(port.name, f32::from_bits(port.bits as u32))?;
                    } else {
                        values.set_item(port.name, port.bits)?;
                    }
                }
                Ok(values)
            }
            embed::Outcome::Timing(_) => Ok(PyDict::new(py)),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<raypath.Outcome: {} tag {}: {}>", self.operation, self.tag, self.values(py)?))
    }
}
