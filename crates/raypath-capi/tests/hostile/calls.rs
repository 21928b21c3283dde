//! Calls of the C interface whose arguments come from bytes: NULL, misaligned and overlapping pointers, lengths that do
//! not fit into memory, words and numbers of any value, objects whose datapath is closed.
//!
//! A pointer is NULL, or has as many elements as the call says, or the call says more than fit into memory; anything
//! else is excluded by the contract of the interface.

use raypath_capi::*;
use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

/// The words of the memory in which all arrays are.
const WORDS: usize = 512;
/// The calls of an input, so that an input takes milliseconds.
const MAX_CALLS: usize = 64;
/// Lengths that no array has.
const HUGE: [usize; 3] = [usize::MAX, usize::MAX - 1, 1 << 63];

/// Makes the calls that the bytes describe. A call that fails leaves a message and changes nothing; no call ends with
/// an internal error. Returns whether a call succeeded.
pub fn calls(bytes: &[u8]) -> bool {
    thread_local! {
        static CALLER: RefCell<Caller> = RefCell::new(Caller::new());
    }
    CALLER.with_borrow_mut(|caller| caller.run(bytes))
}

/// The objects of a caller, and its memory.
struct Caller {
    datapaths: [*mut Datapath; 2],
    unit: *mut Unit,
    memory: Box<[u64; WORDS]>,
}

/// The objects that an input makes.
struct Made {
    pipeline: *mut Pipeline,
    model: *mut UnitModel,
    beat_bytes: usize,
}

/// What is left of the bytes.
struct Script<'b>(&'b [u8]);

impl Script<'_> {
    fn byte(&mut self) -> usize {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first.into()
    }

    fn word(&mut self) -> u64 {
        (0..8).fold(0, |word, _| word << 8 | self.byte() as u64)
    }

    /// A small number, or now and then any.
    fn number(&mut self) -> u64 {
        match self.byte() {
            255 => self.word(),
            small => small as u64,
        }
    }

    /// A number of elements: up to 7, or more than fit.
    fn count(&mut self) -> usize {
        match self.byte() {
            byte @ 0..240 => byte % 8,
            byte => HUGE[byte % HUGE.len()],
        }
    }

    fn text(&mut self) -> CString {
        let length = self.byte().min(self.0.len());
        let (text, rest) = self.0.split_at(length);
        self.0 = rest;
        CString::new(text.split(|&byte| byte == 0).next().unwrap_or_default()).unwrap_or_default()
    }
}

impl Caller {
    fn new() -> Self {
        let open = |toml: &CStr| {
            let mut datapath = null_mut();
            // SAFETY: a string, and a pointer to a pointer.
            assert_eq!(unsafe { raypath_open(toml.as_ptr(), &mut datapath) }, RAYPATH_OK);
            datapath
        };
        let mut unit = null_mut();
        // SAFETY: as above.
        assert_eq!(unsafe { raypath_unit_open(c"contexts = 8\nqueries = \"full\"".as_ptr(), &mut unit) }, RAYPATH_OK);
        let datapaths = [open(c"lanes = 4\ntag = 3"), open(c"preset = \"compact\"\nexception-flags = true")];
        Self { datapaths, unit, memory: Box::new([0; WORDS]) }
    }

    /// A pointer to `count` elements in the memory: NULL, misaligned or right.
    fn pointer<T>(&mut self, script: &mut Script<'_>, count: usize) -> *mut T {
        let all = size_of::<[u64; WORDS]>();
        // The contract permits any pointer with a length that does not fit.
        let size = count.checked_mul(size_of::<T>()).filter(|&size| size <= all).unwrap_or(0);
        let (kind, place) = (script.byte(), script.byte() << 4);
        let place = place % (all - size + 1);
        let base: *mut u8 = self.memory.as_mut_ptr().cast();
        match kind {
            0..8 => null_mut(),
            8..16 => base.wrapping_add(place).cast(),
            _ => base.wrapping_add(place - place % align_of::<T>()).cast(),
        }
    }

    fn run(&mut self, bytes: &[u8]) -> bool {
        let mut script = Script(bytes);
        for (index, word) in self.memory.iter_mut().enumerate() {
            let chunk = bytes.as_chunks().0;
            *word = chunk.get(index % chunk.len().max(1)).copied().map_or(0, u64::from_le_bytes);
        }
        let mut made = Made { pipeline: null_mut(), model: null_mut(), beat_bytes: 0 };
        let mut is_any = false;
        for _ in 0..MAX_CALLS {
            if script.0.is_empty() {
                break;
            }
            let before = self.memory.clone();
            let status = self.call(&mut script, &mut made);
            assert!((RAYPATH_ERROR_IO..=RAYPATH_NO_RESULT).contains(&status), "status {status}");
            // SAFETY: the message is a string until another call fails.
            let message = unsafe { CStr::from_ptr(raypath_last_error()) };
            assert!(!message.to_bytes().starts_with(b"internal error"), "{message:?}");
            if status < 0 {
                assert!(self.memory == before, "a call that failed with {status} changed the memory");
                assert!(!message.is_empty());
            }
            is_any |= status == RAYPATH_OK;
        }
        // SAFETY: both are NULL or were made and not freed.
        unsafe {
            raypath_pipeline_free(made.pipeline);
            raypath_unit_model_free(made.model);
        }
        is_any
    }

    fn datapath(&self, script: &mut Script<'_>) -> *const Datapath {
        self.datapaths.get(script.byte() % 8 % 3).copied().unwrap_or(null_mut())
    }

    /// Makes a call.
    fn call(&mut self, script: &mut Script<'_>, made: &mut Made) -> Status {
        match script.byte() % 8 {
            0..3 => self.call_of_arrays(script),
            3..5 => self.call_of_pipeline(script, made),
            5 => self.call_of_unit(script, made),
            6 => self.call_that_inspects(script),
            _ => self.call_that_opens(script, made),
        }
    }

    /// Opens a datapath and a pipeline of it, and closes the datapath.
    fn call_that_opens(&mut self, script: &mut Script<'_>, made: &mut Made) -> Status {
        let (toml, operations) = (script.text(), script.text());
        let mut datapath = null_mut();
        // SAFETY: strings, and pointers to pointers. The pipeline was not freed, and is not used again.
        unsafe {
            let status = raypath_open_with(toml.as_ptr(), operations.as_ptr(), &mut datapath);
            assert_eq!(status == RAYPATH_OK, !datapath.is_null());
            if status == RAYPATH_OK {
                raypath_pipeline_free(made.pipeline);
                made.pipeline = null_mut();
                assert_eq!(raypath_pipeline_new(datapath, &mut made.pipeline), RAYPATH_OK);
            }
            raypath_close(datapath);
            status
        }
    }

    fn call_of_arrays(&mut self, script: &mut Script<'_>) -> Status {
        let datapath = self.datapath(script);
        let (kind, count) = (script.byte() % 6, script.count());
        let dimensions = script.count();
        let all = count.saturating_mul(dimensions);
        // SAFETY: the datapaths are open or NULL; `pointer` keeps the contract of all arrays.
        unsafe {
            match kind {
                0 => {
                    let boxes = self.pointer(script, count.saturating_mul(4));
                    raypath_quadbox(datapath, self.pointer(script, count), boxes, count, self.pointer(script, count))
                }
                1 => raypath_triangle(
                    datapath,
                    self.pointer(script, count),
                    self.pointer(script, count),
                    count,
                    self.pointer(script, count),
                ),
                2 => {
                    let (a, b) = (self.pointer(script, all), self.pointer(script, all));
                    raypath_euclidean(datapath, a, b, dimensions, count, self.pointer(script, count))
                }
                3 => {
                    let (a, b) = (self.pointer(script, all), self.pointer(script, all));
                    let (dots, norms) = (self.pointer(script, count), self.pointer(script, count));
                    raypath_angular(datapath, a, b, dimensions, count, dots, norms)
                }
                4 => {
                    let names = [c"triangle", c"quadbox", c"euclidean", c"angular", c"no operation", c"\xff"];
                    let name = names.get(script.byte() % 7).map_or(null(), |name| name.as_ptr());
                    // No operation has more ports than words that are left for them here.
                    let count = count.min(2);
                    raypath_run(
                        datapath,
                        name,
                        self.pointer(script, 150 * count),
                        count,
                        self.pointer(script, 50 * count),
                    )
                }
                _ => {
                    let extent = f32::from_bits(script.word() as u32);
                    let (ray, origin) = (self.pointer(script, 1), self.pointer(script, 3));
                    raypath_ray_init(ray, origin, self.pointer(script, 3), extent)
                }
            }
        }
    }

    fn call_of_pipeline(&mut self, script: &mut Script<'_>, made: &mut Made) -> Status {
        let kind = script.byte() % 16;
        // SAFETY: the pipeline is NULL or was made and not freed; `pointer` keeps the contract of all arrays.
        unsafe {
            match kind {
                0 => {
                    let datapath = self.datapath(script);
                    raypath_pipeline_free(made.pipeline);
                    made.pipeline = null_mut();
                    raypath_pipeline_new(datapath, &mut made.pipeline)
                }
                1 => raypath_pipeline_reset(made.pipeline),
                2 => {
                    raypath_pipeline_skip(made.pipeline, script.number());
                    RAYPATH_OK
                }
                3 => {
                    raypath_pipeline_input_ready(made.pipeline, script.number());
                    raypath_pipeline_output_valid(made.pipeline);
                    RAYPATH_OK
                }
                4 => raypath_pipeline_peek(made.pipeline, self.pointer(script, 1)),
                5..9 => raypath_pipeline_step(made.pipeline, script.byte() & 1 == 0, self.pointer(script, 1)),
                _ => {
                    let job = self.job(script);
                    raypath_pipeline_offer(made.pipeline, &job, script.number())
                }
            }
        }
    }

    fn job(&mut self, script: &mut Script<'_>) -> Job {
        let kind = script.byte() as i32 % 8 - 1;
        let numbers = self.memory.as_ptr();
        // SAFETY: the memory is longer than a job and aligned for it; all members consist of numbers, or are set below.
        let mut job = Job { kind, input: unsafe { numbers.cast::<JobInput>().read() } };
        match kind {
            RAYPATH_JOB_EUCLIDEAN | RAYPATH_JOB_ANGULAR => {
                // Datapaths have at most 64 lanes.
                let (a, b) = (self.pointer(script, 64), self.pointer(script, 64));
                job.input.beat = BeatInput { a, b, mask: script.word(), reset_accum: script.byte() as u32 };
            }
            RAYPATH_JOB_WORDS | RAYPATH_JOB_TIMING => {
                let count = [script.count(), 37, 22, 10][script.byte() % 4];
                job.input.words = WordsInput { opcode: script.number(), inputs: self.pointer(script, count), count };
            }
            _ => {}
        }
        job
    }

    fn call_of_unit(&mut self, script: &mut Script<'_>, made: &mut Made) -> Status {
        let unit: *const Unit = if script.byte().is_multiple_of(8) { null() } else { self.unit };
        let kind = script.byte() % 9;
        // SAFETY: the unit is open or NULL, the model NULL or made and not freed; `pointer` keeps the contract of
        // arrays.
        unsafe {
            match kind {
                0 => {
                    // Less than a block, so that no ray takes as long as `VISIT_LIMIT` permits.
                    let (size, count) = (script.count().saturating_mul(16), script.count());
                    let (scene, rays) = (self.pointer(script, size), self.pointer(script, count));
                    raypath_unit_trace(unit, scene, size, rays, count, self.pointer(script, count))
                }
                1 => {
                    raypath_unit_model_free(made.model);
                    made.model = null_mut();
                    let mut parameters = std::mem::zeroed();
                    if raypath_unit_parameters(unit, &mut parameters) == RAYPATH_OK {
                        made.beat_bytes = parameters.memory_width as usize / 8;
                    }
                    raypath_unit_model_new(unit, &mut made.model)
                }
                2 => raypath_unit_model_outputs(made.model, self.pointer(script, 1)),
                3 => raypath_unit_model_counts(made.model, self.pointer(script, 1)),
                4 => {
                    raypath_unit_model_skip(made.model, script.number());
                    RAYPATH_OK
                }
                5 if script.byte() == 0 => raypath_unit_model_reset(made.model),
                6 => {
                    // Less than a block, as above.
                    let (mut query, size) = (null_mut(), script.count().saturating_mul(16));
                    let begun = raypath_query_new(unit, self.pointer(script, 1), &mut query);
                    let mut last =
                        raypath_query_proceed(query, self.pointer(script, size), size, self.pointer(script, 1));
                    raypath_query_answer(query, self.pointer(script, 1));
                    last = last.min(raypath_query_hit(query, self.pointer(script, 1)));
                    raypath_query_free(query);
                    begun.min(last)
                }
                _ => {
                    let flags = script.byte() as u32;
                    let inputs = UnitInputs {
                        ray_id: script.number(),
                        ray: self.memory.as_ptr().cast::<UnitRay>().read(),
                        ray_valid: flags & 1,
                        mem_rsp_data: self.pointer(script, made.beat_bytes),
                        mem_rsp_valid: flags & 2,
                        mem_rsp_tag: script.number() as u32,
                        mem_rsp_error: flags & 4,
                        answer_valid: flags & 32,
                        answer_tag: script.number() as u32,
                        answer: UnitVerdict { accept: flags & 64, end: flags & 128, t: 1.0 },
                        cand_ready: flags & 8,
                        hit_ready: flags & 8,
                        mem_req_ready: flags & 16,
                        flush: u32::from(flags == 255),
                    };
                    raypath_unit_model_step(made.model, &inputs)
                }
            }
        }
    }

    fn call_that_inspects(&mut self, script: &mut Script<'_>) -> Status {
        let datapath = self.datapath(script);
        let (kind, first, second) = (script.byte() % 6, script.number() as usize, script.number() as usize);
        // SAFETY: the datapath is open or NULL; `pointer` keeps the contract of what is set.
        unsafe {
            match kind {
                0 => raypath_operation(datapath, first, self.pointer(script, 1)),
                1 => raypath_input(datapath, first, second, self.pointer(script, 1)),
                2 => raypath_output(datapath, first, second, self.pointer(script, 1)),
                3 => raypath_step_cost(datapath, first, self.pointer(script, 1)),
                4 => raypath_cost(datapath, self.pointer(script, 1)),
                _ => {
                    let is_open = !datapath.is_null();
                    assert_eq!(raypath_latency(datapath) > 0, is_open);
                    assert_eq!(raypath_capacity(datapath) > 0, is_open);
                    assert_eq!(raypath_operation_count(datapath) > 0, is_open);
                    assert_eq!(raypath_description(datapath).is_null(), !is_open);
                    raypath_lanes(datapath);
                    RAYPATH_OK
                }
            }
        }
    }
}
