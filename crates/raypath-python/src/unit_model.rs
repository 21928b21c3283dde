//! The classes `UnitModel` and `UnitOutputs`.

use crate::array::items;
use crate::error::{exception, value_error};
use crate::tables::row;
use crate::unit::Unit;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use raypath_embed::{self as embed, Response, UnitCounts, UnitHit, UnitRay};
use std::sync::{Mutex, PoisonError};

/// The cycle-exact model of a traversal unit. In every cycle its outputs are those of the hardware.
///
/// A cycle is a ``step``. The caller is the memory: it answers requests with beats of blocks of 128 bytes, or 64
/// with quantised nodes. A model belongs to one thread at a time.
///
/// Args:
///     unit: the unit, which other models may share.
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> unit = raypath.Unit(memory_width=1024)
///     >>> scene = unit.scene(np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
///     >>> model = raypath.UnitModel(unit)
///     >>> outputs = model.step(scene.rays(np.float32([[0, 0, 4]]), np.float32([[0, 0, -1]]))[0], ray_id=7)
///     >>> while outputs.hit is None:
///     ...     response = None
///     ...     if outputs.request:
///     ...         address, tag = outputs.request
///     ...         response = tag, scene.data[address : address + 128]
///     ...     outputs = model.step(response=response)
///     >>> outputs.hit_id, outputs.hit["t"], model.counts["boxes"], model.counts["triangles"]
///     (7, 4.0, 1, 1)
#[pyclass(module = "raypath")]
pub struct UnitModel {
    // Not locked: the mutex only makes the model shareable between threads, as a class must be.
    inner: Mutex<embed::UnitModel>,
}

impl UnitModel {
    fn inner(&mut self) -> &mut embed::UnitModel {
        self.inner.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl UnitModel {
    #[new]
    fn new(unit: &Bound<'_, Unit>) -> Self {
        Self { inner: Mutex::new(embed::UnitModel::new(&unit.get().inner)) }
    }

    /// The outputs in this cycle. They depend on earlier cycles alone.
    #[getter]
    fn outputs(&mut self) -> UnitOutputs {
        UnitOutputs(self.inner().outputs())
    }

    /// One clock cycle.
    ///
    /// Args:
    ///     ray: an item of ``scene.rays`` that is offered in this cycle. It is accepted if ``ray_ready`` is true; offer
    ///         it again otherwise.
    ///     ray_id: the number of the ray, with at most ``id_width`` bits, which comes out with its hit.
    ///     response: the tag of a request and the bytes of a beat, an eighth of ``memory_width``. The beats of a block
    ///         arrive in order, in any cycle after that of the request.
    ///     response_error: whether the memory has no valid data for the beat.
    ///     hit_ready: whether a hit at the outputs is taken. It stays there otherwise.
    ///     request_ready: whether a request at the outputs is taken. It stays there otherwise.
    ///
    /// Returns:
    ///     The outputs in the cycle that has passed: with the defaults, what the unit has delivered.
    ///
    /// Raises:
    ///     ValueError: an item that is not a ray; a number of too many bits; a beat of another size, or with the tag of
    ///         no request that waits for one. Then no cycle passes.
    #[pyo3(signature = (ray = None, ray_id = 0, *, response = None, response_error = false, hit_ready = true,
        request_ready = true))]
    fn step(
        &mut self,
        ray: Option<&Bound<'_, PyAny>>,
        ray_id: u64,
        response: Option<(u32, Bound<'_, PyBytes>)>,
        response_error: bool,
        hit_ready: bool,
        request_ready: bool,
    ) -> PyResult<UnitOutputs> {
        let ray = ray.map(one_ray).transpose()?;
        let response = response.as_ref().map(|(tag, beat)| Response {
            tag: *tag,
            is_error: response_error,
            beat: beat.as_bytes(),
        });
        let ray = ray.as_ref().map(|ray| (ray_id, ray));
        let outputs = self.inner().outputs();
        self.inner().step(&embed::UnitInputs { ray, hit_ready, request_ready, response }).map_err(exception)?;
        Ok(UnitOutputs(outputs))
    }

    /// Advances cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the first with a
    /// hit or a request at the outputs. Cycles in which the unit waits for the memory take no time.
    ///
    /// Args:
    ///     cycles: the maximum number of cycles.
    ///
    /// Returns:
    ///     The number of cycles.
    fn skip(&mut self, cycles: u64) -> u64 {
        self.inner().skip(cycles)
    }

    /// What the unit did since its last reset: ``cycles``, ``boxes`` and ``triangles`` (jobs of the datapath),
    /// ``steps``, ``fetches`` and ``rays`` (that ended).
    #[getter]
    fn counts<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let UnitCounts { cycles, boxes, triangles, steps, fetches, rays, .. } = self.inner().counts();
        row!(py, "cycles": cycles, "boxes": boxes, "triangles": triangles, "steps": steps, "fetches": fetches,
            "rays": rays)
    }

    /// A cycle of reset: all rays are lost, and requests get no response.
    fn reset(&mut self) {
        self.inner().reset();
    }

    fn __repr__(&mut self) -> String {
        let counts = self.inner().counts();
        format!("<raypath.UnitModel: {} rays ended in {} cycles>", counts.rays, counts.cycles)
    }
}

/// The outputs of a ``UnitModel`` in a cycle.
#[pyclass(module = "raypath", frozen)]
pub struct UnitOutputs(embed::UnitOutputs);

#[pymethods]
impl UnitOutputs {
    /// Whether a ray is accepted in this cycle.
    #[getter]
    fn ray_ready(&self) -> bool {
        self.0.ray_ready
    }

    /// The number of the ray that has ended, or None.
    #[getter]
    fn hit_id(&self) -> Option<u64> {
        self.0.hit.map(|(id, _)| id)
    }

    /// Its hit, with the fields of ``UnitHits``, or None.
    #[getter]
    fn hit<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some((_, hit)) = self.0.hit else { return Ok(None) };
        let UnitHit { status, triangle, instance, t, t_num, t_denom, u, v, back_face, nodes, triangles } = hit;
        let row = row!(py, "status": status, "triangle": triangle, "instance": instance, "t": t, "t_num": t_num,
            "t_denom": t_denom, "u": u, "v": v, "back_face": back_face == 1, "nodes": nodes, "triangles": triangles)?;
        Ok(Some(row))
    }

    /// The address of a block that is requested and the tag of its response, or None.
    #[getter]
    fn request(&self) -> Option<(u32, u32)> {
        self.0.request.map(|request| (request.address, request.tag))
    }

    fn __repr__(&self) -> String {
        let embed::UnitOutputs { ray_ready, hit, request } = self.0;
        let hit = hit.map_or_else(|| "none".to_string(), |(id, _)| format!("of ray {id}"));
        let request = request.map_or_else(|| "none".to_string(), |request| format!("for {:#x}", request.address));
        format!("<raypath.UnitOutputs: ray_ready {ray_ready}, hit {hit}, request {request}>")
    }
}

/// An item of an array of rays, or an array of one ray.
fn one_ray(ray: &Bound<'_, PyAny>) -> PyResult<UnitRay> {
    let array = ray.py().import("numpy")?.call_method1("ravel", (ray,))?;
    match items::<UnitRay>(&array, "ray")? {
        [ray] => Ok(*ray),
        rays => Err(value_error(format!("ray: found {} rays, expected 1", rays.len()))),
    }
}
