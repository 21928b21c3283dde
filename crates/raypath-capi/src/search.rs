//! Searches of a traversal unit: its functional model, and the ports of its cycle-exact model.

use crate::Unit;
use crate::memory::{array, reference, reference_mut, results};
use crate::status::{RAYPATH_OK, Status, status};
use crate::unit_model::{UnitInputs, UnitModel};
use raypath_embed::{self as embed, SearchStatus};

/// `raypath_search_reply`: the neighbours are complete.
pub const RAYPATH_SEARCH_DONE: u32 = 0;
/// A word of the job is outside its range; there are no neighbours.
pub const RAYPATH_SEARCH_REFUSED: u32 = 1;
/// The memory reported an error, or there is nothing at an address; there are no neighbours.
pub const RAYPATH_SEARCH_MEMORY: u32 = 2;

/// A neighbour of a query.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct Neighbour {
    /// The index of the vector.
    pub index: u32,
    /// The Euclidean distance, the dot product, or the cosine of the angle.
    pub distance: f32,
}

/// How a search ended, and what it did.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct SearchReply {
    /// One of `RAYPATH_SEARCH_…`.
    pub status: u32,
    /// The number of neighbours.
    pub count: u32,
    /// Vectors that were compared with the query.
    pub distances: u64,
    /// Beats of the datapath.
    pub beats: u64,
    /// Blocks of 64 bytes that were read.
    pub blocks: u64,
    /// Candidates whose neighbours were read.
    pub expansions: u64,
}

/// The inputs of searches in a cycle. The members are ports of the unit. What belongs to a channel that is not valid is
/// not read.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SearchInputs {
    /// The id of the job that is offered, which comes out with its results.
    pub search_id: u64,
    /// The address of the job, a multiple of 64.
    pub search_job: u32,
    /// The upper 32 bits of all addresses of the job.
    pub search_base: u32,
    /// Not 0: a job is offered. It is accepted in this cycle if the output `search_ready` is 1; hold it until then.
    pub search_valid: u32,
    /// Not 0: the result at the outputs is taken.
    pub result_ready: u32,
    /// Not 0: the request at the outputs is taken.
    pub vec_req_ready: u32,
    /// Not 0: a beat of a block arrives. The beats of a block arrive in order, in any cycle after that of the request.
    pub vec_rsp_valid: u32,
    /// The tag of the request.
    pub vec_rsp_tag: u32,
    /// Not 0: the memory has no valid data for the beat.
    pub vec_rsp_error: u32,
    /// The bytes of the beat, an eighth of the memory's width, the lowest address first. They are read during the call.
    pub vec_rsp_data: *const u8,
}

/// The outputs of searches in a cycle. The members are ports of the unit. Those of a channel that is not valid are 0.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct SearchOutputs {
    /// The id of the job of the result.
    pub result_id: u64,
    /// The address of the block that is requested.
    pub vec_req_addr: u64,
    /// The tag of its response.
    pub vec_req_tag: u32,
    /// 1: a block of 64 bytes is requested. The request stays at the outputs until a step takes it.
    pub vec_req_valid: u32,
    /// 1: no job is in the unit.
    pub searches_idle: u32,
    /// 1: a job that is offered is accepted in this cycle.
    pub search_ready: u32,
    /// 1: a result, which stays at the outputs until a step takes it.
    pub result_valid: u32,
    /// The number of the job's results before it.
    pub result_rank: u32,
    /// 1: the result is a neighbour; 0: the job has none.
    pub result_found: u32,
    /// The neighbour.
    pub result: Neighbour,
    /// 1: the result is the job's last.
    pub result_last: u32,
    /// With the last result: how the job has ended, one of `RAYPATH_SEARCH_…`.
    pub result_status: u32,
}

/// Does the job at an address of a memory of `size` bytes by the functional model, and sets `neighbours`, the best
/// first, and `*reply`. The first byte of the memory has the address 0; an address outside of it is an error of the
/// memory. `base` has the upper 32 bits of all addresses. The layout of a job is that of `docs/reference/searching.md`.
/// Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for a unit without searches, an address that is not a multiple of 64, and a
/// capacity below the number of neighbours; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`. Then nothing is set.
///
/// # Safety
/// `unit` is NULL or an open unit; `reply` is NULL or points to a structure; the arrays are NULL or have that many
/// elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_search(
    unit: *const Unit,
    memory: *const u8,
    size: usize,
    base: u32,
    job: u32,
    neighbours: *mut Neighbour,
    capacity: usize,
    reply: *mut SearchReply,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (unit, memory) = unsafe { (reference("unit", unit)?, array("memory", memory, size)?) };
        // SAFETY: as above.
        let (to, reply) = unsafe { (results("neighbours", neighbours, capacity)?, reference_mut("reply", reply)?) };
        let found = unit.embedded.search(memory, base, job)?;
        let (count, room) = (found.neighbours.len(), to.len());
        if count > room {
            let problem = format!("neighbours: capacity {room}, expected at least {count}");
            return Err(embed::Error::Argument(problem).into());
        }
        for (to, near) in to.iter_mut().zip(found.neighbours) {
            *to = near.into();
        }
        let embed::SearchCounts { distances, beats, blocks, expansions } = found.counts;
        let status = code(found.status);
        *reply = SearchReply { status, count: count as u32, distances, beats, blocks, expansions };
        Ok(RAYPATH_OK)
    })
}

/// `raypath_unit_model_step` of a unit with searches, with their inputs.
///
/// Errors: those of `raypath_unit_model_step`; `RAYPATH_ERROR_ARGUMENT` for a job of a unit without searches, one with
/// an id or a base of too many bits, or an address that is not a multiple of 64. Then no cycle passes.
///
/// # Safety
/// That of `raypath_unit_model_step`, also for `search`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_step_with(
    model: *mut UnitModel,
    inputs: *const UnitInputs,
    search: *const SearchInputs,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, inputs) = unsafe { (reference_mut("model", model)?, reference("inputs", inputs)?) };
        // SAFETY: as above.
        let search = unsafe { reference("search", search)? };
        let flags = [search.vec_rsp_valid, search.vec_rsp_tag, search.vec_rsp_error];
        // SAFETY: as above.
        let response = unsafe { model.response("vec_rsp_data", flags, search.vec_rsp_data)? };
        let job = (search.search_id, search.search_base, search.search_job);
        let search = embed::SearchInputs {
            job: (search.search_valid != 0).then_some(job),
            result_ready: search.result_ready != 0,
            request_ready: search.vec_req_ready != 0,
            response,
        };
        // SAFETY: as above.
        unsafe { model.step(inputs, search) }
    })
}

/// Sets `*outputs` to the outputs of searches in this cycle; all are 0 in a unit without searches. No cycle passes.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// That of `raypath_unit_model_outputs`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_unit_model_search_outputs(
    model: *const UnitModel,
    outputs: *mut SearchOutputs,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (model, outputs) = unsafe { (reference("model", model)?, reference_mut("outputs", outputs)?) };
        *outputs = model.embedded.outputs().search.map(SearchOutputs::from).unwrap_or_default();
        Ok(RAYPATH_OK)
    })
}

fn code(status: SearchStatus) -> u32 {
    match status {
        SearchStatus::Done => RAYPATH_SEARCH_DONE,
        SearchStatus::Refused => RAYPATH_SEARCH_REFUSED,
        SearchStatus::Memory => RAYPATH_SEARCH_MEMORY,
    }
}

impl From<embed::Neighbour> for Neighbour {
    fn from(embed::Neighbour { index, distance }: embed::Neighbour) -> Self {
        Self { index, distance }
    }
}

impl From<embed::SearchOutputs> for SearchOutputs {
    fn from(embed::SearchOutputs { is_idle, ready, result, request }: embed::SearchOutputs) -> Self {
        let asked = request.unwrap_or_default();
        let mut outputs = Self {
            vec_req_addr: asked.address,
            vec_req_tag: asked.tag,
            vec_req_valid: request.is_some().into(),
            searches_idle: is_idle.into(),
            search_ready: ready.into(),
            ..Self::default()
        };
        if let Some(embed::SearchResult { id, rank, neighbour, status, is_last }) = result {
            outputs.result_id = id;
            outputs.result_valid = 1;
            outputs.result_rank = rank;
            outputs.result_found = neighbour.is_some().into();
            outputs.result = neighbour.map(Neighbour::from).unwrap_or_default();
            outputs.result_last = is_last.into();
            outputs.result_status = if is_last { code(status) } else { 0 };
        }
        outputs
    }
}
