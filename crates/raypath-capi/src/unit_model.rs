//! The cycle-exact model of a traversal unit.

use crate::Unit;
use crate::memory::{array, copied, free, reference, reference_mut, results, written};
use crate::status::{Failure, RAYPATH_OK, Status, status, value_or_zero};
use raypath_embed::{self as embed, RayPhase, Response, UnitCandidate, UnitHit, UnitRay, UnitVerdict};

/// The cycle-exact model of a traversal unit. One thread at a time may use it; another thread may use it later.
///
/// A cycle consists of `raypath_unit_model_outputs`, which depend on earlier cycles alone, then
/// `raypath_unit_model_step`. The caller is the memory.
#[derive(Clone)]
pub struct UnitModel {
    pub(crate) embedded: embed::UnitModel,
    pub(crate) beat_bytes: usize,
}

/// The inputs of a unit in a cycle. The members are its ports. What belongs to a channel that is not valid is not read.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct UnitInputs {
    /// The id of the ray that is offered, which comes out with its hit.
    pub ray_id: u64,
    /// The ray that is offered.
    pub ray: UnitRay,
    /// Not 0: a ray is offered. It is accepted in this cycle if the output `ray_ready` is 1; hold it until then.
    pub ray_valid: u32,
    /// The bytes of the beat, an eighth of the memory's width, the lowest address first. They are read during the call.
    pub mem_rsp_data: *const u8,
    /// Not 0: a beat of a block arrives. The beats of a block arrive in order, in any cycle after that of the request.
    pub mem_rsp_valid: u32,
    /// The tag of the request.
    pub mem_rsp_tag: u32,
    /// Not 0: the memory has no valid data for the beat.
    pub mem_rsp_error: u32,
    /// Not 0: a verdict on a candidate is given. It may come from the cycle after the candidate was taken on.
    pub answer_valid: u32,
    /// The tag of the candidate.
    pub answer_tag: u32,
    /// The verdict.
    pub answer: UnitVerdict,
    /// Not 0: the candidate at the outputs is taken.
    pub cand_ready: u32,
    /// Not 0: the hit at the outputs is taken.
    pub hit_ready: u32,
    /// Not 0: the request at the outputs is taken.
    pub mem_req_ready: u32,
    /// Not 0: all rays are dropped, from the next cycle until the output `idle` is 1. Beats and verdicts that are owed
    /// must still come.
    pub flush: u32,
}

/// The outputs of a unit in a cycle. The members are its ports. Those of a channel that is not valid are 0.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct UnitOutputs {
    /// The id of the ray that has ended.
    pub hit_id: u64,
    /// Its hit.
    pub hit: UnitHit,
    /// 1: a ray that is offered is accepted in this cycle.
    pub ray_ready: u32,
    /// 1: a ray has ended. Its hit stays at the outputs until a step takes it.
    pub hit_valid: u32,
    /// 1: a ray waits for a verdict on a candidate, which stays at the outputs until a step takes it.
    pub cand_valid: u32,
    /// The tag of its verdict.
    pub cand_tag: u32,
    /// The id of its ray.
    pub cand_id: u64,
    /// The candidate.
    pub cand: UnitCandidate,
    /// 1: a block is requested. The request stays at the outputs until a step takes it.
    pub mem_req_valid: u32,
    /// The address of the block.
    pub mem_req_addr: u64,
    /// The tag of its response.
    pub mem_req_tag: u32,
    /// 1: no ray is in the unit.
    pub idle: u32,
}

/// What a unit did since its last reset.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct UnitCounts {
    /// Cycles.
    pub cycles: u64,
    /// Box jobs of the datapath.
    pub boxes: u64,
    /// Triangle jobs of the datapath.
    pub triangles: u64,
    /// Steps of rays.
    pub steps: u64,
    /// Blocks that were requested.
    pub fetches: u64,
    /// Rays that ended.
    pub rays: u64,
}

/// Where rays, hits, requests and jobs of a unit waited since its last reset.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct UnitStalls {
    /// The rays inside, accepted and not taken as hits.
    pub rays_inside: u64,
    /// The sum of the rays inside over all cycles: divided by the cycles, the contexts in use.
    pub ray_cycles: u64,
    /// Cycles in which a ray was offered and not accepted.
    pub ray_stalls: u64,
    /// Cycles in which a hit was not taken.
    pub hit_stalls: u64,
    /// Cycles in which a request was not taken.
    pub request_stalls: u64,
    /// Cycles in which a job waited for the datapath.
    pub job_stalls: u64,
    /// Descents that began again at the root, because the stack of a ray had lost a level.
    pub restarts: u64,
}

/// The phase of a ray whose constants are computed.
pub const RAYPATH_PHASE_SET_UP: u32 = 0;
/// The phase of a ray that waits for a block of the memory.
pub const RAYPATH_PHASE_MEMORY: u32 = 1;
/// The phase of a ray that waits for the jobs of a block, or for its next step.
pub const RAYPATH_PHASE_JOBS: u32 = 2;
/// The phase of a ray that has ended and waits for the channel of hits.
pub const RAYPATH_PHASE_ENDED: u32 = 3;
/// The phase of a ray that waits for a verdict on a candidate.
pub const RAYPATH_PHASE_VERDICT: u32 = 4;

/// A ray in a context of a unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RayInside {
    /// The id of the ray.
    pub id: u64,
    /// The number of the context, which is the tag of its requests.
    pub context: u32,
    /// One of `RAYPATH_PHASE_…`.
    pub phase: u32,
    /// The address of the block that it asked for last; before, the first of its window.
    pub address: u64,
}

/// Makes a model of the unit after a reset, and sets `*model`. The unit may be closed before the model. Any thread may
/// call it.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `unit` is NULL or an open unit; `model` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_new(unit: *const Unit, model: *mut *mut UnitModel) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, model) = unsafe { (reference("unit", unit)?, reference_mut("model", model)?) };
        let beat_bytes = unit.embedded.parameters().memory_width as usize / 8;
        let embedded = embed::UnitModel::new(&unit.embedded);
        *model = Box::into_raw(Box::new(UnitModel { embedded, beat_bytes }));
        Ok(RAYPATH_OK)
    })
}

/// Frees a model. NULL is ignored.
///
/// # Safety
/// `model` is NULL or came from `raypath_unit_model_new` and was not freed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_free(model: *mut UnitModel) {
    // SAFETY: by the contract of this function.
    unsafe { free(model) };
}

/// Sets `*outputs` to the outputs in this cycle. No cycle passes.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// `model` is NULL or a model that no other thread changes; `outputs` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_outputs(model: *const UnitModel, outputs: *mut UnitOutputs) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, outputs) = unsafe { (reference("model", model)?, reference_mut("outputs", outputs)?) };
        *outputs = model.embedded.outputs().into();
        Ok(RAYPATH_OK)
    })
}

/// The clock edge that ends this cycle.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for an id with more bits than the unit has for it, flags, a mask or a base out of
/// range, a beat whose tag is that of no request that waits for one, and a verdict whose tag is that of no candidate that
/// was taken; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`. Then no cycle passes.
///
/// # Safety
/// `model` is NULL or a model that no other thread uses; `inputs` is NULL or points to a structure, whose beat has an
/// eighth of the memory's width if it is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_step(model: *mut UnitModel, inputs: *const UnitInputs) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, inputs) = unsafe { (reference_mut("model", model)?, reference("inputs", inputs)?) };
        // SAFETY: as above.
        unsafe { model.step(inputs, embed::SearchInputs::default()) }
    })
}

impl UnitModel {
    /// The clock edge.
    ///
    /// # Safety
    /// The beat has an eighth of the memory's width if it is valid.
    pub(crate) unsafe fn step(
        &mut self,
        inputs: &UnitInputs,
        search: embed::SearchInputs<'_>,
    ) -> Result<Status, Failure> {
        let UnitInputs { mem_rsp_valid, mem_rsp_tag, mem_rsp_error, mem_rsp_data, .. } = *inputs;
        let flags = [mem_rsp_valid, mem_rsp_tag, mem_rsp_error];
        // SAFETY: by the contract of this function.
        let response = unsafe { self.response("mem_rsp_data", flags, mem_rsp_data)? };
        self.embedded.step(&embed::UnitInputs {
            ray: (inputs.ray_valid != 0).then_some((inputs.ray_id, &inputs.ray)),
            hit_ready: inputs.hit_ready != 0,
            candidate_ready: inputs.cand_ready != 0,
            verdict: (inputs.answer_valid != 0).then_some((inputs.answer_tag, inputs.answer)),
            request_ready: inputs.mem_req_ready != 0,
            response,
            flush: inputs.flush != 0,
            search,
        })?;
        Ok(RAYPATH_OK)
    }

    /// The beat of a channel whose `valid`, `tag` and `error` these are.
    ///
    /// # Safety
    /// The data have an eighth of the memory's width if the beat is valid.
    pub(crate) unsafe fn response<'b>(
        &self,
        name: &str,
        [valid, tag, error]: [u32; 3],
        data: *const u8,
    ) -> Result<Option<Response<'b>>, Failure> {
        if valid == 0 {
            return Ok(None);
        }
        // SAFETY: by the contract of this function.
        let beat = unsafe { array(name, data, self.beat_bytes)? };
        Ok(Some(Response { tag, is_error: error != 0, beat }))
    }
}

/// Advances up to `cycles` cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the
/// first with a hit, a candidate or a request at the outputs, or in which `ray_ready` is 1 and was 0 before. Returns the
/// number of cycles that passed: 0 if there is one already, and after an error. Equivalent to that many calls of
/// `raypath_unit_model_step`, but cycles in which the unit waits for the memory take no time.
///
/// # Safety
/// `model` is NULL or a model that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_skip(model: *mut UnitModel, cycles: u64) -> u64 {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference_mut("model", model)? }.embedded.skip(cycles)))
}

/// Sets `*counts` to what the unit did since its last reset.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// That of `raypath_unit_model_outputs`; `counts` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_counts(model: *const UnitModel, counts: *mut UnitCounts) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, counts) = unsafe { (reference("model", model)?, reference_mut("counts", counts)?) };
        let embed::UnitCounts { cycles, boxes, triangles, steps, fetches, rays, .. } = model.embedded.counts();
        *counts = UnitCounts { cycles, boxes, triangles, steps, fetches, rays };
        Ok(RAYPATH_OK)
    })
}

/// Sets `*stalls` to where rays, hits, requests and jobs waited since the last reset.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// That of `raypath_unit_model_outputs`; `stalls` is NULL or points to a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_stalls(model: *const UnitModel, stalls: *mut UnitStalls) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, stalls) = unsafe { (reference("model", model)?, reference_mut("stalls", stalls)?) };
        let embed::UnitStalls { rays_inside, ray_cycles, ray_stalls, hit_stalls, request_stalls } =
            model.embedded.stalls();
        let embed::UnitCounts { job_stalls, restarts, .. } = model.embedded.counts();
        *stalls = UnitStalls { rays_inside, ray_cycles, ray_stalls, hit_stalls, request_stalls, job_stalls, restarts };
        Ok(RAYPATH_OK)
    })
}

/// Sets the first `capacity` elements of `rays` to the rays in contexts, by context, and returns their number; 0 after
/// an error. From cycle to cycle they are the timeline of the unit. A ray whose hit is at the outputs has left its
/// context.
///
/// # Safety
/// `model` is NULL or a model that no other thread changes; `rays` is NULL or has `capacity` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_rays(
    model: *const UnitModel,
    rays: *mut RayInside,
    capacity: usize,
) -> usize {
    value_or_zero(|| {
        // SAFETY: by the contract of this function.
        let (model, rays) = unsafe { (reference("model", model)?, results("rays", rays, capacity)?) };
        Ok(written(model.embedded.rays().map(RayInside::from), rays))
    })
}

impl From<embed::RayInside> for RayInside {
    fn from(embed::RayInside { context, id, phase, address }: embed::RayInside) -> Self {
        let phase = match phase {
            RayPhase::SetUp => RAYPATH_PHASE_SET_UP,
            RayPhase::Memory => RAYPATH_PHASE_MEMORY,
            RayPhase::Jobs => RAYPATH_PHASE_JOBS,
            RayPhase::Verdict => RAYPATH_PHASE_VERDICT,
            RayPhase::Ended => RAYPATH_PHASE_ENDED,
        };
        Self { id, context, phase, address }
    }
}

/// Copies the whole state as bytes into `bytes`, if they fit into `capacity`, and returns their number; 0 after an
/// error. With a capacity of 0 it says how many are needed. `raypath_unit_model_restore` takes them over, also in
/// another process.
///
/// # Safety
/// `model` is NULL or a model that no other thread changes; `bytes` is NULL or has `capacity` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_save(model: *const UnitModel, bytes: *mut u8, capacity: usize) -> usize {
    value_or_zero(|| {
        // SAFETY: by the contract of this function.
        let (model, bytes) = unsafe { (reference("model", model)?, results("bytes", bytes, capacity)?) };
        Ok(copied(&model.embedded.save(), bytes))
    })
}

/// Takes over a state that `raypath_unit_model_save` copied, of an equal unit in the same release of raypath.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for other bytes; `RAYPATH_ERROR_NULL`. Then nothing changes.
///
/// # Safety
/// `model` is NULL or a model that no other thread uses; `bytes` is NULL or has `size` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_restore(model: *mut UnitModel, bytes: *const u8, size: usize) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, bytes) = unsafe { (reference_mut("model", model)?, array("bytes", bytes, size)?) };
        model.embedded.restore(bytes)?;
        Ok(RAYPATH_OK)
    })
}

/// Makes a copy with the same state, and sets `*copy`, which is freed like the original.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `model` is NULL or a model that no other thread changes; `copy` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_clone(model: *const UnitModel, copy: *mut *mut UnitModel) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, copy) = unsafe { (reference("model", model)?, reference_mut("copy", copy)?) };
        *copy = Box::into_raw(Box::new(model.clone()));
        Ok(RAYPATH_OK)
    })
}

/// A cycle in which `rst_ni` is 0: all rays are lost, and requests get no response.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `model` is NULL or a model that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_reset(model: *mut UnitModel) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        unsafe { reference_mut("model", model)? }.embedded.reset();
        Ok(RAYPATH_OK)
    })
}

impl From<embed::UnitOutputs> for UnitOutputs {
    fn from(outputs: embed::UnitOutputs) -> Self {
        let (hit_id, hit) = outputs.hit.unwrap_or_default();
        let request = outputs.request.unwrap_or_default();
        let (cand_tag, cand_id, cand) = outputs.candidate.unwrap_or_default();
        Self {
            hit_id,
            hit,
            ray_ready: outputs.ray_ready.into(),
            idle: outputs.is_idle.into(),
            hit_valid: outputs.hit.is_some().into(),
            cand_valid: outputs.candidate.is_some().into(),
            cand_tag,
            cand_id,
            cand,
            mem_req_valid: outputs.request.is_some().into(),
            mem_req_addr: request.address,
            mem_req_tag: request.tag,
        }
    }
}
