//! The classes `UnitModel` and `UnitOutputs`.

use crate::array::{Output, Truth, items, items_like, structure};
use crate::error::{exception, value_error};
use crate::hits::UnitHits;
use crate::tables::row;
use crate::unit::{Unit, UnitScene, shown};
use crate::watch::watched;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use raypath_embed::{
    self as embed, BlockRequest, Response, SearchInputs, UnitCounts, UnitHit, UnitRay, UnitStalls, UnitVerdict,
};
use raypath_traversal::Memory;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// The cycles between two looks for signals.
const CYCLES: u64 = 1 << 14;

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
    unit: Py<Unit>,
    /// The blocks that `run` has to answer: when, where and for whom, and the beats that were sent.
    due: VecDeque<(u64, BlockRequest, usize)>,
    /// The verdict that `run` has to give in its next cycle.
    verdict: Option<(u32, UnitVerdict)>,
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
        Self {
            inner: Mutex::new(embed::UnitModel::new(&unit.get().inner)),
            unit: unit.clone().unbind(),
            due: VecDeque::new(),
            verdict: None,
        }
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
    ///     candidate_ready: whether a candidate at the outputs is taken. It stays there otherwise.
    ///     verdict: the tag of a candidate that was taken, whether it is accepted, whether its ray ends, and the distance
    ///         of the hit of a box.
    ///     request_ready: whether a request at the outputs is taken. It stays there otherwise.
    ///     flush: drops all rays, from the next cycle until the unit is idle. Beats and verdicts that are owed must
    ///         still come.
    ///     job: the number and the address of a job of a search that is offered, in a unit with ``search``. It is
    ///         accepted if the outputs say so.
    ///     result_ready: whether a result at the outputs is taken. It stays there otherwise.
    ///     vector_request_ready: the same for a request of a block of searches.
    ///     vector_response: as ``response``, for requests of searches.
    ///     vector_response_error: whether that beat has no valid data.
    ///
    /// Returns:
    ///     The outputs in the cycle that has passed: with the defaults, what the unit has delivered.
    ///
    /// Raises:
    ///     ValueError: an item that is not a ray; a number of too many bits; a beat of another size, or with the tag of
    ///         no request that waits for one; a verdict with the tag of no candidate that was taken. Then no cycle
    ///         passes.
    #[pyo3(signature = (ray = None, ray_id = 0, *, response = None, response_error = false, hit_ready = true,
        candidate_ready = true, verdict = None, request_ready = true, flush = false, job = None, result_ready = true,
        vector_request_ready = true, vector_response = None, vector_response_error = false))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn step(
        &mut self,
        ray: Option<&Bound<'_, PyAny>>,
        ray_id: u64,
        response: Option<(u32, Bound<'_, PyBytes>)>,
        response_error: bool,
        hit_ready: bool,
        candidate_ready: bool,
        verdict: Option<(u32, bool, bool, f32)>,
        request_ready: bool,
        flush: bool,
        job: Option<(u64, u64)>,
        result_ready: bool,
        vector_request_ready: bool,
        vector_response: Option<(u32, Bound<'_, PyBytes>)>,
        vector_response_error: bool,
    ) -> PyResult<UnitOutputs> {
        let verdict =
            verdict.map(|(tag, accept, end, t)| (tag, UnitVerdict { accept: accept.into(), end: end.into(), t }));
        let ray = ray.map(|ray| structure::<UnitRay>(ray, "ray")).transpose()?;
        let response = beat(response.as_ref(), response_error);
        let search = SearchInputs {
            job: job.map(|(id, address)| (id, (address >> 32) as u32, address as u32)),
            result_ready,
            request_ready: vector_request_ready,
            response: beat(vector_response.as_ref(), vector_response_error),
        };
        let ray = ray.as_ref().map(|ray| (ray_id, ray));
        let outputs = self.inner().outputs();
        self.inner()
            .step(&embed::UnitInputs {
                flush,
                ray,
                hit_ready,
                candidate_ready,
                verdict,
                request_ready,
                response,
                search,
            })
            .map_err(exception)?;
        Ok(UnitOutputs(outputs))
    }

    /// Many cycles at once: rays are offered in order, each until it is accepted, and a scene answers requests in
    /// order. Of candidates, triangles are accepted and boxes ignored.
    ///
    /// Args:
    ///     cycles: the number of cycles.
    ///     rays: rays of ``scene.rays``; none by default.
    ///     ray_ids: uint64 array of shape (n,): the number of each ray; their places by default.
    ///     scene: the memory; without one, requests are not answered.
    ///     latency: cycles from a request that is taken to the first beat of its block, at least 1.
    ///     hit_ready: bool array of shape (cycles,): whether a hit at the outputs is taken in each cycle; always by
    ///         default.
    ///     request_ready: the same for requests.
    ///
    /// Returns:
    ///     A dictionary: ``accepted``, the number of rays that were accepted; ``hits``, those that were taken, with
    ///     ``hit_ids`` and ``hit_cycles``; ``request_addresses`` and ``request_cycles`` of the requests that were
    ///     taken. Cycles are numbered from 0 in each call.
    ///
    /// Raises:
    ///     ValueError: another type or shape; a number of too many bits; a latency of 0.
    ///     KeyboardInterrupt: after Ctrl-C.
    #[pyo3(signature = (cycles, rays = None, ray_ids = None, *, scene = None, latency = 100, hit_ready = None,
        request_ready = None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        cycles: u64,
        rays: Option<&Bound<'py, PyAny>>,
        ray_ids: Option<&Bound<'py, PyAny>>,
        scene: Option<&Bound<'py, UnitScene>>,
        latency: u64,
        hit_ready: Option<&Bound<'py, PyAny>>,
        request_ready: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        if latency == 0 {
            return Err(value_error("latency: found 0 cycles, expected at least 1"));
        }
        let rays = rays.map(|rays| items::<UnitRay>(rays, "rays")).transpose()?;
        let rays = rays.as_deref().unwrap_or(&[]);
        let ids = ray_ids.map(|ids| items_like::<u64>(ids, "ray_ids", rays.len(), "rays")).transpose()?;
        let bits = self.unit.get().inner.parameters().id_width;
        let last =
            ids.as_ref().map_or(rays.len().checked_sub(1).map(|last| last as u64), |ids| ids.iter().copied().max());
        if let Some(id) = last.filter(|id| *id > u64::MAX >> (64 - bits)) {
            return Err(value_error(format!("ray_ids: found {id}, expected numbers of at most {bits} bits")));
        }
        let ready = |array: Option<&Bound<'py, PyAny>>, name| {
            array.map(|array| items_like::<Truth>(array, name, cycles as usize, "cycles")).transpose()
        };
        let (hit_ready, request_ready) = (ready(hit_ready, "hit_ready")?, ready(request_ready, "request_ready")?);
        let width = self.unit.get().inner.parameters().memory_width as usize / 8;
        let block = self.unit.get().inner.parameters().step.node.block_bytes() as usize;
        scene.map_or(Ok(()), |scene| scene.get().check(&self.unit.get().inner))?;
        let bytes: &[u8] = scene.map_or(&[], |scene| &scene.get().data);
        let nothing = vec![0; width];
        let (hit_ready, request_ready) = (hit_ready.as_deref(), request_ready.as_deref());
        let (ids, answers) = (ids.as_deref(), scene.is_some());
        let Self { inner, due, verdict, .. } = self;
        let inner = inner.get_mut().unwrap_or_else(PoisonError::into_inner);
        let (mut accepted, mut hits, mut hit_ids, mut hit_cycles) = (0, Vec::new(), Vec::new(), Vec::new());
        let (mut addresses, mut request_cycles) = (Vec::new(), Vec::new());
        watched(py, |progress| {
            for now in 0..cycles {
                if now % CYCLES == CYCLES - 1 && !progress(now) {
                    break;
                }
                let outputs = inner.outputs();
                let at = |ready: Option<&[Truth]>| ready.is_none_or(|ready| ready[now as usize].0 != 0);
                let number = |place| ids.map_or(place as u64, |ids| ids[place]);
                let response = due.front().filter(|(when, ..)| *when <= now && answers).map(|(_, request, sent)| {
                    let block = bytes.block(request.address, block as u32).ok();
                    let beat = block.and_then(|block| block.get(sent * width..)?.get(..width));
                    Response { tag: request.tag, is_error: beat.is_none(), beat: beat.unwrap_or(&nothing) }
                });
                let inputs = embed::UnitInputs {
                    flush: false,
                    ray: rays.get(accepted).map(|ray| (number(accepted), ray)),
                    hit_ready: at(hit_ready),
                    candidate_ready: true,
                    verdict: verdict.take(),
                    request_ready: at(request_ready),
                    response,
                    search: SearchInputs::default(),
                };
                inner.step(&inputs).map_err(exception)?;
                // Of candidates, triangles are accepted and boxes ignored.
                *verdict = outputs.candidate.map(|(tag, _, candidate)| {
                    (tag, UnitVerdict { accept: 1 - candidate.is_box, ..UnitVerdict::default() })
                });
                if let Some((_, _, sent)) = due.front_mut().filter(|_| response.is_some()) {
                    *sent += 1;
                    if *sent * width == block {
                        due.pop_front();
                    }
                }
                accepted += usize::from(outputs.ray_ready && inputs.ray.is_some());
                if let Some((id, hit)) = outputs.hit.filter(|_| inputs.hit_ready) {
                    hits.push(shown(hit));
                    hit_ids.push(id);
                    hit_cycles.push(now);
                }
                if let Some(request) = outputs.request.filter(|_| inputs.request_ready) {
                    addresses.push(request.address);
                    request_cycles.push(now);
                    due.push_back((now + latency, request, 0));
                }
            }
            Ok(())
        })?;
        due.iter_mut().for_each(|(when, ..)| *when = when.saturating_sub(cycles));
        let mut output = Output::new::<UnitHit>(py, hits.len())?;
        output.items()?.copy_from_slice(&hits);
        row!(py,
            "accepted": accepted,
            "hits": Bound::new(py, UnitHits::of(output.into_array(), None))?,
            "hit_ids": PyArray1::from_vec(py, hit_ids),
            "hit_cycles": PyArray1::from_vec(py, hit_cycles),
            "request_addresses": PyArray1::from_vec(py, addresses),
            "request_cycles": PyArray1::from_vec(py, request_cycles),
        )
    }

    /// Advances cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the first with a
    /// hit, a candidate or a request at the outputs, or in which a ray is accepted and was not before. Cycles in which the unit
    /// waits for the memory take no time.
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
    /// ``steps``, ``fetches``, ``rays`` (that ended) and ``restarts`` (descents that began again, because the stack had
    /// lost a level); ``rays_inside`` and their sum over all cycles, ``ray_cycles``; the cycles in which a ray
    /// (``ray_stalls``), a hit, a request or a job waited.
    #[getter]
    fn counts<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let UnitCounts { cycles, boxes, triangles, steps, fetches, rays, restarts, job_stalls, .. } =
            self.inner().counts();
        let UnitStalls { rays_inside, ray_cycles, ray_stalls, hit_stalls, request_stalls } = self.inner().stalls();
        row!(py, "cycles": cycles, "boxes": boxes, "triangles": triangles, "steps": steps, "fetches": fetches,
            "rays": rays, "restarts": restarts, "rays_inside": rays_inside, "ray_cycles": ray_cycles,
            "ray_stalls": ray_stalls, "hit_stalls": hit_stalls, "request_stalls": request_stalls,
            "job_stalls": job_stalls)
    }

    /// The whole state as bytes, for ``restore``. Blocks that ``run`` has not yet answered are not part of it.
    fn save<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.inner().save())
    }

    /// Takes over a state that a model of an equal unit saved, in this release of raypath.
    ///
    /// Raises:
    ///     ValueError: other bytes. Then nothing changes.
    fn restore(&mut self, state: &Bound<'_, PyBytes>) -> PyResult<()> {
        self.inner().restore(state.as_bytes()).map_err(exception)?;
        self.due.clear();
        Ok(())
    }

    /// The arguments that make a model of the same unit, for ``copy`` and ``pickle``.
    fn __getnewargs__(&self, py: Python<'_>) -> (Py<Unit>,) {
        (self.unit.clone_ref(py),)
    }

    fn __getstate__<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.save(py)
    }

    fn __setstate__(&mut self, state: &Bound<'_, PyBytes>) -> PyResult<()> {
        self.restore(state)
    }

    /// A cycle of reset: all rays are lost, and requests get no response.
    fn reset(&mut self) {
        self.inner().reset();
        self.due.clear();
    }

    fn __repr__(&mut self) -> String {
        let counts = self.inner().counts();
        format!("<raypath.UnitModel: {} rays ended in {} cycles>", counts.rays, counts.cycles)
    }
}

/// A beat of a response, with its tag.
fn beat<'b>(response: Option<&'b (u32, Bound<'_, PyBytes>)>, is_error: bool) -> Option<Response<'b>> {
    response.map(|(tag, beat)| Response { tag: *tag, is_error, beat: beat.as_bytes() })
}

/// The outputs of a ``UnitModel`` in a cycle.
#[pyclass(module = "raypath", frozen)]
pub struct UnitOutputs(embed::UnitOutputs);

#[pymethods]
impl UnitOutputs {
    /// Whether no ray is in the unit.
    #[getter]
    fn idle(&self) -> bool {
        self.0.is_idle
    }

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
        let hit = shown(hit);
        let row = row!(py,
            "status": hit.status,
            "primitive": hit.primitive.cast_signed(),
            "instance": hit.instance.cast_signed(),
            "t": hit.t,
            "t_num": hit.t_num,
            "t_denom": hit.t_denom,
            "u": hit.u,
            "v": hit.v,
            "back_face": hit.back_face == 1,
            "nodes": hit.nodes,
            "triangles": hit.triangles,
            "geometry": hit.geometry.cast_signed(),
            "custom_index": hit.custom_index,
            "shader_offset": hit.shader_offset,
        )?;
        Ok(Some(row))
    }

    /// A candidate at the outputs: the tag of its verdict, the number of its ray, and its fields by name; or None.
    #[getter]
    fn candidate<'py>(&self, py: Python<'py>) -> PyResult<Option<(u32, u64, Bound<'py, PyDict>)>> {
        let Some((tag, id, found)) = self.0.candidate else { return Ok(None) };
        let row = row!(py,
            "is_box": found.is_box == 1,
            "is_opaque": found.is_opaque == 1,
            "primitive": found.primitive,
            "geometry": found.geometry,
            "instance": found.instance.cast_signed(),
            "custom_index": found.custom_index,
            "shader_offset": found.shader_offset,
            "t": found.t,
            "u": found.u,
            "v": found.v,
            "back_face": found.back_face == 1,
            "origin": found.origin,
            "direction": found.direction,
        )?;
        Ok(Some((tag, id, row)))
    }

    /// The address of a block that is requested and the tag of its response, or None.
    #[getter]
    fn request(&self) -> Option<(u64, u32)> {
        self.0.request.map(|request| (request.address, request.tag))
    }

    /// Whether no job of a search is in the unit.
    #[getter]
    fn searches_idle(&self) -> bool {
        self.0.search.is_none_or(|search| search.is_idle)
    }

    /// Whether a job of a search is accepted in this cycle.
    #[getter]
    fn job_ready(&self) -> bool {
        self.0.search.is_some_and(|search| search.ready)
    }

    /// A result of a search: the number of its job, its ``rank`` from 0, ``index`` and ``distance`` (None if the job has
    /// no neighbours), whether it is the ``last``, and with the last the ``status``: 0 complete, 1 refused, 2 an error of
    /// the memory. Or None.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(found) = self.0.search.and_then(|search| search.result) else { return Ok(None) };
        let row = row!(py,
            "job": found.id,
            "rank": found.rank,
            "index": found.neighbour.map(|near| near.index),
            "distance": found.neighbour.map(|near| near.distance),
            "last": found.is_last,
            "status": found.status as u32,
        )?;
        Ok(Some(row))
    }

    /// The address of a block of 64 bytes that a search requests and the tag of its response, or None.
    #[getter]
    fn vector_request(&self) -> Option<(u64, u32)> {
        self.0.search.and_then(|search| search.request).map(|request| (request.address, request.tag))
    }

    fn __repr__(&self) -> String {
        let embed::UnitOutputs { ray_ready, hit, request, .. } = self.0;
        let hit = hit.map_or_else(|| "none".to_string(), |(id, _)| format!("of ray {id}"));
        let request = request.map_or_else(|| "none".to_string(), |request| format!("for {:#x}", request.address));
        format!("<raypath.UnitOutputs: ray_ready {ray_ready}, hit {hit}, request {request}>")
    }
}
