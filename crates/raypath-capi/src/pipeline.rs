//! The cycle-exact model.

use crate::Datapath;
use crate::memory::{array, copied, free, reference, reference_mut, results, written};
use crate::status::{Failure, RAYPATH_BUSY, RAYPATH_NO_RESULT, RAYPATH_OK, Status, status, value_or_zero};
use raypath_embed::{
    self as embed, AngularResult, Beat, Bounds, EuclideanResult, QuadboxResult, Ray, Tagged, TriangleResult, Vertices,
    Words,
};
use std::mem::offset_of;
use std::ptr::{from_ref, null};

/// The cycle-exact model of a datapath. One thread at a time may use it; another thread may use it later.
///
/// A cycle consists of at most one accepted `raypath_pipeline_offer`, then `raypath_pipeline_step`.
#[derive(Clone)]
pub struct Pipeline {
    embedded: embed::Pipeline,
    lanes: usize,
}

/// A job of `raypath_job`: a ray against a triangle.
pub const RAYPATH_JOB_TRIANGLE: i32 = 0;
/// A ray against four boxes.
pub const RAYPATH_JOB_QUADBOX: i32 = 1;
/// A beat of a Euclidean distance.
pub const RAYPATH_JOB_EUCLIDEAN: i32 = 2;
/// A beat of an angular distance.
pub const RAYPATH_JOB_ANGULAR: i32 = 3;
/// A job of any operation, by its opcode, as the words at its ports.
pub const RAYPATH_JOB_WORDS: i32 = 4;
/// The time of a job without its values, by its opcode. Accumulators do not change.
pub const RAYPATH_JOB_TIMING: i32 = 5;

/// A job. `kind` is one of `RAYPATH_JOB_…` and selects the member of `input`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Job {
    /// One of `RAYPATH_JOB_…`.
    pub kind: i32,
    /// The member that `kind` selects.
    pub input: JobInput,
}

/// The input of a job.
#[repr(C)]
#[derive(Clone, Copy)]
pub union JobInput {
    /// Of `RAYPATH_JOB_QUADBOX`.
    pub quadbox: QuadboxInput,
    /// Of `RAYPATH_JOB_TRIANGLE`.
    pub triangle: TriangleInput,
    /// Of `RAYPATH_JOB_EUCLIDEAN` and `RAYPATH_JOB_ANGULAR`.
    pub beat: BeatInput,
    /// Of `RAYPATH_JOB_WORDS` and `RAYPATH_JOB_TIMING`, which reads the opcode alone.
    pub words: WordsInput,
}

/// A ray and four boxes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct QuadboxInput {
    /// The ray.
    pub ray: Ray,
    /// The boxes.
    pub boxes: [Bounds; 4],
}

/// A ray and a triangle.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct TriangleInput {
    /// The ray.
    pub ray: Ray,
    /// The triangle.
    pub triangle: Vertices,
}

/// A beat of a distance. `a` and `b` have `raypath_lanes` elements for a Euclidean beat, and half as many for an
/// angular one; they are read while the job is offered.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct BeatInput {
    /// The query's coordinates.
    pub a: *const f32,
    /// The candidate's coordinates.
    pub b: *const f32,
    /// Bit i says whether lane i counts.
    pub mask: u64,
    /// Not 0: the sums restart at zero after this beat.
    pub reset_accum: u32,
}

/// The words at the input ports of an operation, in the order of `raypath_input`; they are read while the job is
/// offered.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WordsInput {
    /// The operation's opcode.
    pub opcode: u64,
    /// The words.
    pub inputs: *const u64,
    /// The number of words.
    pub count: usize,
}

/// The outcome of a job with the tag of its offer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PipelineResult {
    /// The tag that was given with the job.
    pub tag: u64,
    /// The kind of the job.
    pub kind: i32,
    /// The member that `kind` selects.
    pub output: JobOutput,
}

/// The outcome of a job.
#[repr(C)]
#[derive(Clone, Copy)]
pub union JobOutput {
    /// Of `RAYPATH_JOB_QUADBOX`.
    pub quadbox: QuadboxResult,
    /// Of `RAYPATH_JOB_TRIANGLE`.
    pub triangle: TriangleResult,
    /// Of `RAYPATH_JOB_EUCLIDEAN`.
    pub euclidean: EuclideanResult,
    /// Of `RAYPATH_JOB_ANGULAR`.
    pub angular: AngularResult,
    /// Of `RAYPATH_JOB_WORDS` and `RAYPATH_JOB_TIMING`, which has no words.
    pub words: WordsOutput,
}

/// The words at the output ports of an operation, in the order of `raypath_output`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WordsOutput {
    /// The operation's opcode.
    pub opcode: u64,
    /// The words. They are valid until the next `raypath_pipeline_step`, `_skip`, `_reset` or `_free` of the pipeline.
    pub outputs: *const u64,
    /// The number of words.
    pub count: usize,
}

/// Makes an empty pipeline with accumulators of zero, and sets `*pipeline`. The datapath may be closed before the
/// pipeline. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `pipeline` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_new(datapath: *const Datapath, pipeline: *mut *mut Pipeline) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, pipeline) = unsafe { (reference("datapath", datapath)?, reference_mut("pipeline", pipeline)?) };
        let embedded = embed::Pipeline::new(&datapath.embedded);
        let made = Pipeline { embedded, lanes: datapath.embedded.lanes() };
        *pipeline = Box::into_raw(Box::new(made));
        Ok(RAYPATH_OK)
    })
}

/// Frees a pipeline. NULL is ignored.
///
/// # Safety
/// `pipeline` is NULL or came from `raypath_pipeline_new` and was not freed; no other call uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_free(pipeline: *mut Pipeline) {
    // SAFETY: by the contract of this function.
    unsafe { free(pipeline) };
}

/// Offers a job with a tag, any number, in this cycle: `RAYPATH_OK` if it is accepted, `RAYPATH_BUSY` if not. At most
/// one job is accepted in a cycle. The job is read before the call returns.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for a kind that is not one of `RAYPATH_JOB_…` or another number of words than the
/// operation has; `RAYPATH_ERROR_OPERATION`; `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread uses; `job` is NULL or points to a job whose pointers are NULL
/// or have as many elements as [`JobInput`] says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_offer(pipeline: *mut Pipeline, job: *const Job, tag: u64) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, job) = unsafe { (reference_mut("pipeline", pipeline)?, reference("job", job)?) };
        // SAFETY: by the contract of this function.
        let accepted = unsafe { offer(pipeline, job, tag)? };
        Ok(if accepted { RAYPATH_OK } else { RAYPATH_BUSY })
    })
}

/// One clock cycle. The job that was accepted in this cycle enters. If `output_ready` and there is an outcome at the
/// output, it leaves: `RAYPATH_OK`, and `*result` is set. Otherwise `RAYPATH_NO_RESULT`. If `result` is NULL, the
/// outcome is discarded.
///
/// Errors: `RAYPATH_ERROR_NULL` for the pipeline; `RAYPATH_ERROR_ALIGNMENT`. Then no cycle passes.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread uses; `result` is NULL or points to a result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_step(
    pipeline: *mut Pipeline,
    output_ready: bool,
    result: *mut PipelineResult,
) -> Status {
    status(|| {
        let count = usize::from(!result.is_null());
        // SAFETY: by the contract of this function.
        let (pipeline, result) = unsafe { (reference_mut("pipeline", pipeline)?, results("result", result, count)?) };
        let Some(tagged) = pipeline.embedded.step(output_ready) else { return Ok(RAYPATH_NO_RESULT) };
        if let [result] = result {
            *result = PipelineResult::of(tagged);
            result.complete(pipeline.embedded.left_words());
        }
        Ok(RAYPATH_OK)
    })
}

/// Sets `*result` to the outcome at the output in this cycle, which stays until a step takes it: `RAYPATH_OK`.
/// `RAYPATH_NO_RESULT` if there is none. No cycle passes.
///
/// Errors: `RAYPATH_ERROR_NULL`; `RAYPATH_ERROR_ALIGNMENT`.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes; `result` is NULL or points to a result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_peek(pipeline: *const Pipeline, result: *mut PipelineResult) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, result) = unsafe { (reference("pipeline", pipeline)?, reference_mut("result", result)?) };
        let Some((tagged, words)) = pipeline.embedded.output() else { return Ok(RAYPATH_NO_RESULT) };
        *result = PipelineResult::of(tagged);
        result.complete(words);
        Ok(RAYPATH_OK)
    })
}

/// Advances up to `cycles` cycles in which no further job is offered and the sink is not ready, and stops in the first
/// with an outcome at the output. Returns the number of cycles that passed: 0 if there is an outcome already, and after
/// an error. A job that was accepted in this cycle enters in the first. Equivalent to that many calls of
/// `raypath_pipeline_step`, but faster.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_skip(pipeline: *mut Pipeline, cycles: u64) -> u64 {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference_mut("pipeline", pipeline)? }.embedded.skip(cycles)))
}

/// The number of jobs inside, with the one that was accepted in this cycle; 0 after an error.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_occupancy(pipeline: *const Pipeline) -> usize {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("pipeline", pipeline)? }.embedded.occupancy()))
}

/// Sets the first `capacity` elements of `stages` to the stages of the jobs inside, oldest first, without a job that
/// was accepted in this cycle: 1 after the input's registers, the latency at the output. Returns the number of jobs;
/// 0 after an error.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes; `stages` is NULL or has `capacity` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_stages(
    pipeline: *const Pipeline,
    stages: *mut u32,
    capacity: usize,
) -> usize {
    value_or_zero(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, stages) = unsafe { (reference("pipeline", pipeline)?, results("stages", stages, capacity)?) };
        Ok(written(pipeline.embedded.positions().map(|position| position.stage as u32), stages))
    })
}

/// Whether a job with this opcode would be accepted in this cycle; false after an error.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_input_ready(pipeline: *const Pipeline, opcode: u64) -> bool {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("pipeline", pipeline)? }.embedded.input_ready(opcode)))
}

/// Whether there is an outcome at the output in this cycle; false after an error.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_output_valid(pipeline: *const Pipeline) -> bool {
    // SAFETY: by the contract of this function.
    value_or_zero(|| Ok(unsafe { reference("pipeline", pipeline)? }.embedded.output_valid()))
}

/// A cycle in which `rst_ni` is 0: all jobs are lost, and the accumulators are zero.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_reset(pipeline: *mut Pipeline) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        unsafe { reference_mut("pipeline", pipeline)? }.embedded.reset();
        Ok(RAYPATH_OK)
    })
}

/// Copies the whole state as bytes into `bytes`, if they fit into `capacity`, and returns their number; 0 after an
/// error. With a capacity of 0 it says how many are needed. `raypath_pipeline_restore` takes them over, also in another
/// process.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes; `bytes` is NULL or has `capacity` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_save(pipeline: *const Pipeline, bytes: *mut u8, capacity: usize) -> usize {
    value_or_zero(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, bytes) = unsafe { (reference("pipeline", pipeline)?, results("bytes", bytes, capacity)?) };
        Ok(copied(&pipeline.embedded.save(), bytes))
    })
}

/// Takes over a state that `raypath_pipeline_save` copied, of an equal datapath in the same release of raypath.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for other bytes; `RAYPATH_ERROR_NULL`. Then nothing changes.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread uses; `bytes` is NULL or has `size` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_restore(pipeline: *mut Pipeline, bytes: *const u8, size: usize) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, bytes) = unsafe { (reference_mut("pipeline", pipeline)?, array("bytes", bytes, size)?) };
        pipeline.embedded.restore(bytes)?;
        Ok(RAYPATH_OK)
    })
}

/// Makes a copy with the same state, and sets `*copy`, which is freed like the original.
///
/// Errors: `RAYPATH_ERROR_NULL`.
///
/// # Safety
/// `pipeline` is NULL or a pipeline that no other thread changes; `copy` is NULL or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_pipeline_clone(pipeline: *const Pipeline, copy: *mut *mut Pipeline) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (pipeline, copy) = unsafe { (reference("pipeline", pipeline)?, reference_mut("copy", copy)?) };
        *copy = Box::into_raw(Box::new(pipeline.clone()));
        Ok(RAYPATH_OK)
    })
}

impl PipelineResult {
    /// The outcome, without the pointer to words.
    #[inline(always)]
    fn of(tagged: &Tagged) -> Self {
        // SAFETY: both have the same layout, as the assertions below state, and no member has invalid values.
        unsafe { from_ref(tagged).cast::<Self>().read() }
    }

    /// Adds the pointer to the words of an outcome of words, which stay where they are.
    #[inline(always)]
    fn complete(&mut self, words: Option<&Words>) {
        if self.kind >= RAYPATH_JOB_WORDS {
            let words = words.filter(|_| self.kind == RAYPATH_JOB_WORDS).map(Words::as_words);
            // SAFETY: for these kinds, the member `words` has its opcode.
            let output = unsafe { &mut self.output.words };
            (output.outputs, output.count) = words.map_or((null(), 0), |words| (words.as_ptr(), words.len()));
        }
    }
}

// `Tagged` and `Outcome` are `repr(C)`: the tag, the kind, then the outcome, where a union has it.
const _: () = {
    assert!(size_of::<Tagged>() == size_of::<PipelineResult>() && align_of::<Tagged>() == align_of::<PipelineResult>());
    assert!(offset_of!(Tagged, tag) == offset_of!(PipelineResult, tag));
    assert!(offset_of!(Tagged, outcome) == offset_of!(PipelineResult, kind));
};

/// Offers a job, which is read where it is.
///
/// # Safety
/// The pointers of the job are NULL or have as many elements as [`JobInput`] says.
// `embed::Pipeline::offer` is inlined into each arm, where the kind of its job is a constant: of two branches on the
// kind, the processor would mispredict both.
#[inline(always)]
unsafe fn offer(pipeline: &mut Pipeline, job: &Job, tag: u64) -> Result<bool, Failure> {
    let Pipeline { embedded, lanes } = pipeline;
    let input = &job.input;
    // SAFETY (all reads of the union): every member consists of numbers and pointers, which have no invalid values.
    let accepted = match job.kind {
        RAYPATH_JOB_QUADBOX => {
            let QuadboxInput { ray, boxes } = unsafe { &input.quadbox };
            embedded.offer(&embed::Job::Quadbox { ray, boxes }, tag)
        }
        RAYPATH_JOB_TRIANGLE => {
            let TriangleInput { ray, triangle } = unsafe { &input.triangle };
            embedded.offer(&embed::Job::Triangle { ray, triangle }, tag)
        }
        RAYPATH_JOB_EUCLIDEAN => {
            let beat = unsafe { beat(&input.beat, *lanes)? };
            embedded.offer(&embed::Job::Euclidean(beat), tag)
        }
        RAYPATH_JOB_ANGULAR => {
            let beat = unsafe { beat(&input.beat, *lanes / 2)? };
            embedded.offer(&embed::Job::Angular(beat), tag)
        }
        RAYPATH_JOB_WORDS => {
            let WordsInput { opcode, inputs, count } = unsafe { input.words };
            let inputs = unsafe { array("inputs", inputs, count)? };
            embedded.offer(&embed::Job::Words { opcode, inputs }, tag)
        }
        RAYPATH_JOB_TIMING => {
            let opcode = unsafe { input.words.opcode };
            embedded.offer(&embed::Job::Timing { opcode }, tag)
        }
        kind => {
            let expected = "expected RAYPATH_JOB_TRIANGLE (0) to RAYPATH_JOB_TIMING (5)";
            return Err(Failure::argument(format!("{kind} is not a valid kind of job, {expected}")));
        }
    };
    Ok(accepted?)
}

/// # Safety
/// The pointers are NULL or have `lanes` elements.
#[inline(always)]
unsafe fn beat<'j>(beat: &BeatInput, lanes: usize) -> Result<Beat<'j>, Failure> {
    let &BeatInput { a, b, mask, reset_accum } = beat;
    // SAFETY: by the contract of this function.
    let (a, b) = unsafe { (array("a", a, lanes)?, array("b", b, lanes)?) };
    Ok(Beat { a, b, mask, reset_accum: reset_accum != 0 })
}
