//! The class `Datapath`.

use crate::array::{Items, Output, items, items_like, matrix};
use crate::config::{Around, chosen, toml};
use crate::error::{exception, value_error};
use crate::hits::{QuadboxHits, TriangleHits};
use crate::tables;
use crate::watch::{in_pieces, watched};
use crate::words::{outcomes, words_of};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use raypath_embed::{self as embed, Bounds, QuadboxResult, Ray, TriangleResult, Vertices};
use raypath_rtl::report::picture;
use std::path::PathBuf;
use std::sync::Arc;

/// A datapath: a configuration with its operations, netlist and models.
///
/// It does not change, so that threads can share it. Its methods release the interpreter lock while they compute.
/// Arrays of jobs start with accumulators of zero.
///
/// Inputs are arrays of the stated shape. C-contiguous arrays of the stated type are not copied; others are converted
/// if every value stays what it is, and raise ``ValueError`` if not. NaN and infinity are computed as the hardware
/// computes them; every NaN in a result is the canonical NaN.
///
/// Args:
///     preset: the name of a configuration that the others change; ``raypath.presets()`` lists them. "paper" if neither
///         it nor ``config`` is given.
///     config: in place of a preset, the path of a TOML file, or its text, which contains "=".
///     with_: the names of operations besides those of the paper; ``raypath.operations()`` lists them.
///     flags: the options of the command line, with ``_`` in place of ``-``, such as ``lanes=64`` or
///         ``control="credit"``; ``raypath.parameters()`` lists them.
///
/// Raises:
///     ValueError: a value that a flag does not have; a configuration that cannot be built.
///     TypeError: a keyword that is not a flag.
///
/// Example:
///     >>> import raypath
///     >>> raypath.Datapath(lanes="none", control="credit").flip_flops
///     7104
#[pyclass(module = "raypath", frozen)]
pub struct Datapath {
    pub inner: Arc<embed::Datapath>,
    added: Vec<String>,
}

#[pymethods]
impl Datapath {
    #[new]
    #[pyo3(signature = (preset = None, *, config = None, with_ = None, **flags))]
    fn new(
        py: Python<'_>,
        preset: Option<&str>,
        config: Option<&Bound<'_, PyAny>>,
        with_: Option<&Bound<'_, PyAny>>,
        flags: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let around = Around { of: "a datapath", names: &[], set: &mut |_, _| Ok(()) };
        let chosen = chosen(preset, config, flags, around)?;
        let added = match with_ {
            None => Vec::new(),
            Some(names) => names_of(names)?,
        };
        let names: Vec<&str> = added.iter().map(String::as_str).collect();
        let inner = py.detach(|| embed::Datapath::new(chosen, &names)).map_err(exception)?;
        Ok(Self { inner: Arc::new(inner), added })
    }

    /// Cycles from the acceptance of a job to its outcome in an empty pipeline.
    #[getter]
    fn latency(&self) -> u32 {
        self.inner.netlist().latency()
    }

    /// The number of flip-flops of the netlist.
    #[getter]
    fn flip_flops(&self) -> u64 {
        self.inner.flip_flops()
    }

    /// The coordinates of a Euclidean beat, 0 without distances. An angular beat has half as many.
    #[getter]
    fn lanes(&self) -> usize {
        self.inner.lanes()
    }

    /// The names of the operations, in the order of their opcodes.
    #[getter]
    fn operations(&self) -> Vec<&'static str> {
        self.inner.operations().into_iter().map(|operation| operation.name()).collect()
    }

    /// The configuration as TOML, which ``Datapath(config=...)`` and ``--config`` read.
    #[getter]
    fn config(&self) -> String {
        toml(&self.inner.config())
    }

    /// Tests each ray against four boxes, and sorts the four boxes of each job.
    ///
    /// Args:
    ///     rays: n rays of ``raypath.rays``.
    ///     boxes: float32 array of shape (n, 4, 2, 3): for each ray four boxes, of which each is min and max.
    ///
    /// Returns:
    ///     n outcomes with the attributes ``is_intersect``, ``tmin`` and ``box_index``, each of shape (n, 4).
    ///
    /// Raises:
    ///     ValueError: another type or shape; a datapath without the operation.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
    ///     >>> near, far, aside = [[-1, -1, -1], [1, 1, 1]], [[-1, -1, 7], [1, 1, 9]], [[4, 4, 4], [5, 5, 5]]
    ///     >>> hits = raypath.Datapath().quadbox(rays, np.float32([[far, aside, near, aside]]))
    ///     >>> hits.is_intersect, hits.box_index
    ///     (array([[ True,  True, False, False]]), array([[2, 0, 1, 3]], dtype=uint8))
    fn quadbox(&self, py: Python<'_>, rays: &Bound<'_, PyAny>, boxes: &Bound<'_, PyAny>) -> PyResult<QuadboxHits> {
        let rays = items::<Ray>(rays, "rays")?;
        let boxes = items_like::<[Bounds; 4]>(boxes, "boxes", rays.len(), "rays")?;
        let mut output = Output::new::<QuadboxResult>(py, rays.len())?;
        let (rays, boxes, results) = (&*rays, &*boxes, output.items()?);
        in_pieces(py, rays.len(), |at| self.inner.quadbox(&rays[at.clone()], &boxes[at.clone()], &mut results[at]))?;
        Ok(QuadboxHits::of(output.into_array(), None))
    }

    /// Tests each ray against a triangle, which is hit from the side where its vertices run counter-clockwise.
    ///
    /// Args:
    ///     rays: n rays of ``raypath.rays``. Their extents are not tested.
    ///     triangles: float32 array of shape (n, 3, 3): for each ray three vertices.
    ///
    /// Returns:
    ///     n outcomes with the attributes ``triangle_hit``, ``t_num`` and ``t_denom``, each of shape (n,).
    ///
    /// Raises:
    ///     ValueError: another type or shape; a datapath without the operation.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> rays = raypath.rays(np.float32([[0, 0, -5]]), np.float32([[0, 0, 1]]))
    ///     >>> hit = raypath.Datapath().triangle(rays, np.float32([[[-1, -1, 0], [0, 1, 0], [1, -1, 0]]]))
    ///     >>> hit.triangle_hit, hit.t_num / hit.t_denom
    ///     (array([ True]), array([5.], dtype=float32))
    fn triangle(
        &self,
        py: Python<'_>,
        rays: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
    ) -> PyResult<TriangleHits> {
        let rays = items::<Ray>(rays, "rays")?;
        let triangles = items_like::<Vertices>(triangles, "triangles", rays.len(), "rays")?;
        let mut output = Output::new::<TriangleResult>(py, rays.len())?;
        let (rays, triangles, results) = (&*rays, &*triangles, output.items()?);
        in_pieces(py, rays.len(), |at| {
            self.inner.triangle(&rays[at.clone()], &triangles[at.clone()], &mut results[at])
        })?;
        Ok(TriangleHits::of(output.into_array(), None))
    }

    /// The squared Euclidean distance of each pair of vectors, added in the order of the hardware.
    ///
    /// Args:
    ///     a: float32 array of shape (n, k), for any k of at least 1. Vectors are divided into beats of ``lanes``
    ///         coordinates, of which the last is masked.
    ///     b: float32 array of the same shape.
    ///
    /// Returns:
    ///     A float32 array of shape (n,).
    ///
    /// Raises:
    ///     ValueError: another type or shape; a datapath without the operation.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> raypath.Datapath().euclidean(np.zeros((2, 40), np.float32), np.full((2, 40), 2, np.float32))
    ///     array([160., 160.], dtype=float32)
    fn euclidean<'py>(
        &self,
        py: Python<'py>,
        a: &Bound<'py, PyAny>,
        b: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (a, b, count, dimensions) = pairs(["a", "b"], a, b)?;
        let mut output = Output::new::<f32>(py, count)?;
        let (a, b, distances) = (&*a, &*b, output.items()?);
        in_pieces(py, count, |at| {
            let numbers = dimensions * at.start..dimensions * at.end;
            self.inner.euclidean(&a[numbers.clone()], &b[numbers], dimensions, &mut distances[at])
        })?;
        Ok(output.into_array())
    }

    /// The dot product of each query with its candidate, and the squared norm of the candidate.
    ///
    /// The cosine of the angle is ``dot / sqrt(norm * norm_of_query)``; the datapath does not divide.
    ///
    /// Args:
    ///     q: float32 array of shape (n, k), for any k of at least 1.
    ///     c: float32 array of the same shape.
    ///
    /// Returns:
    ///     Two float32 arrays of shape (n,): the dot products and the squared norms.
    ///
    /// Raises:
    ///     ValueError: another type or shape; a datapath without the operation.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> dot, norm = raypath.Datapath().angular(np.float32([[1, 2]]), np.float32([[3, 4]]))
    ///     >>> dot, norm
    ///     (array([11.], dtype=float32), array([25.], dtype=float32))
    fn angular<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        c: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (q, c, count, dimensions) = pairs(["q", "c"], q, c)?;
        let (mut dots, mut norms) = (Output::new::<f32>(py, count)?, Output::new::<f32>(py, count)?);
        let (q, c, to_dots, to_norms) = (&*q, &*c, dots.items()?, norms.items()?);
        in_pieces(py, count, |at| {
            let numbers = dimensions * at.start..dimensions * at.end;
            let (q, c) = (&q[numbers.clone()], &c[numbers]);
            self.inner.angular(q, c, dimensions, &mut to_dots[at.clone()], &mut to_norms[at])
        })?;
        Ok((dots.into_array(), norms.into_array()))
    }

    /// Computes n jobs of any operation, in order, from the values at its input ports.
    ///
    /// This copies its inputs, and is slower than the methods of the paper's operations.
    ///
    /// Args:
    ///     operation: the name of the operation.
    ///     ports: for each input port (``ports()`` lists them) an array of shape (n,), or a number that counts for all
    ///         jobs. Numbers in binary32 are float32 arrays. Flags, words, and the bits of numbers in other formats are
    ///         arrays of integers or truth values; bits beyond the width of a port are ignored.
    ///
    /// Returns:
    ///     For each output port an array of shape (n,): float32, bool for a single flag, or uint64.
    ///
    /// Raises:
    ///     ValueError: a datapath without the operation; a port that is missing or unknown; another type or shape.
    ///     KeyboardInterrupt: after Ctrl-C.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> datapath = raypath.Datapath(lanes=2)
    ///     >>> beat = {"euclidean_a_0": np.float32([1, 2]), "euclidean_a_1": 0, "euclidean_b_0": 0, "euclidean_b_1": 0}
    ///     >>> found = datapath.run("euclidean", euclidean_mask=0b11, euclidean_reset_accum=False, **beat)
    ///     >>> found["euclidean_accumulator"]
    ///     array([1., 5.], dtype=float32)
    #[pyo3(signature = (operation, /, **ports))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        operation: &str,
        ports: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let operation = self.inner.operation(operation).map_err(exception)?;
        let (inputs, count) = words_of(&self.inner, operation, ports)?;
        let outputs = self.inner.outputs(operation);
        let mut words = vec![0; count * outputs.len()];
        watched(py, |progress| self.inner.run_watched(operation, &inputs, &mut words, progress).map_err(exception))?;
        outcomes(py, outputs, self.inner.config().semantics.format, &words)
    }

    /// Writes SystemVerilog, assertions, wrapper, manifests and a picture of the pipeline, as ``raypath generate``
    /// does.
    ///
    /// Args:
    ///     folder: the folder to write to, which is created if it does not exist.
    ///
    /// Returns:
    ///     The number of files.
    ///
    /// Raises:
    ///     OSError: a file or folder that cannot be written; then no file is changed.
    fn generate(&self, py: Python<'_>, folder: PathBuf) -> PyResult<usize> {
        py.detach(|| self.inner.generate(&folder)).map_err(exception)
    }

    /// The figures for architecture simulators, as ``raypath card`` writes them, without measured ones.
    ///
    /// Returns:
    ///     The document as a dictionary; ``absent`` says why a value is None.
    fn card<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        tables::card(py, &self.inner.card())
    }

    /// The work of each operation in each step of the pipeline (Table VII of the paper).
    ///
    /// Returns:
    ///     A row for each step and operation, for example for ``pandas.DataFrame``: ``step`` (0 is the input's
    ///     registers), ``stage`` (its name: "2", or "2.1" if a stage has several steps), ``operation``, ``work`` (a
    ///     description; empty if values only pass through) and the number of units of each kind.
    fn schedule<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tables::schedule(py, self.inner.netlist())
    }

    /// The floating-point units of each step of the pipeline, counted in the netlist (Table VIII of the paper).
    ///
    /// Returns:
    ///     A row for each step: ``step``, ``stage``, and the number of units of each kind: ``encode``, ``add``,
    ///     ``mul``, ``compare``, ``decode``.
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tables::units(py, self.inner.netlist())
    }

    /// The register bits after each step of the pipeline, counted in the netlist.
    ///
    /// Returns:
    ///     A row for each step: ``step``, ``stage``, ``live`` (bits of a job), ``data``, ``control`` and ``state``
    ///     (flip-flops by purpose), and ``flip_flops``, the sum of the three.
    fn registers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tables::registers(py, self.inner.netlist())
    }

    /// The ports of each operation, without those of the handshake and the opcode.
    ///
    /// Returns:
    ///     A row for each port: ``operation``, ``direction`` ("input" or "output"), ``name``, ``kind`` ("number",
    ///     "flags" or "word") and ``width`` in bits.
    fn ports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        tables::ports(py, &self.inner)
    }

    /// The picture of the pipeline as SVG, which notebooks show.
    fn _repr_svg_(&self) -> String {
        picture::pipeline(self.inner.netlist(), self.inner.config())
    }

    fn __repr__(&self) -> String {
        format!("<raypath.Datapath: {}>", self.inner.description())
    }

    /// The arguments that make an equal datapath, for ``pickle``.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("config", self.config())?;
        arguments.set_item("with_", &self.added)?;
        Ok((PyTuple::empty(py), arguments))
    }
}

/// Two arrays of n vectors of k dimensions, with n and k.
fn pairs<'py>(
    [name_a, name_b]: [&str; 2],
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
) -> PyResult<(Items<'py, f32>, Items<'py, f32>, usize, usize)> {
    let (a, count, dimensions) = matrix(a, name_a)?;
    let (b, rows, columns) = matrix(b, name_b)?;
    if (rows, columns) != (count, dimensions) {
        let problem = format!("found shape ({rows}, {columns}), expected ({count}, {dimensions}) as {name_a}");
        return Err(value_error(format!("{name_b}: {problem}")));
    }
    if dimensions == 0 {
        return Err(value_error(format!("{name_a}: found shape ({count}, 0), expected at least 1 dimension")));
    }
    Ok((a, b, count, dimensions))
}

/// Names in a list, or separated by commas.
fn names_of(names: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    match names.extract::<String>() {
        Ok(text) => Ok(text.split(',').map(|name| name.trim().to_string()).collect()),
        Err(_) => names.extract(),
    }
}
