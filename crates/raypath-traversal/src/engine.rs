//! What runs the unit cycle by cycle: its ports, and the simulated netlist behind them.

use crate::candidate::{Candidate, Verdict};
use crate::cycle::UnitCounts;
use crate::hardware::UnitNetlist;
use crate::model::{Hit, HitInstance, RayRequest, Reply};
use crate::query::Queries;
use crate::search::{Neighbour, SearchStatus};
use crate::state::status;
use crate::step::{NODE_LIMIT, UnitFeatures};
use raypath_hdl::{Error, InputPort, Module, OutputPort, Simulator};
use std::sync::Arc;

/// The inputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitInputs<'b> {
    /// All rays are dropped, from the next cycle until [`UnitOutputs::is_idle`].
    pub flush: bool,
    /// A ray that is offered, with its number.
    pub ray: Option<(u64, RayRequest)>,
    /// Whether a hit is taken.
    pub hit_ready: bool,
    /// Whether a candidate is taken.
    pub candidate_ready: bool,
    /// The verdict on a candidate, with its tag. It may come from the cycle after the candidate was taken on.
    pub verdict: Option<(u32, Verdict)>,
    /// Whether a request is taken.
    pub request_ready: bool,
    /// A beat of the memory.
    pub response: Option<Response<'b>>,
    /// The inputs of searches, in a unit that has them.
    pub search: SearchInputs<'b>,
}

/// The inputs of searches in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchInputs<'b> {
    /// A job that is offered: its number, the upper 32 bits of its addresses, and its address.
    pub job: Option<(u64, u32, u32)>,
    /// Whether a result is taken.
    pub result_ready: bool,
    /// Whether a request is taken.
    pub request_ready: bool,
    /// A beat of the memory.
    pub response: Option<Response<'b>>,
}

/// The outputs of searches in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchOutputs {
    /// No job is in the unit.
    pub is_idle: bool,
    /// Whether a job is accepted.
    pub ready: bool,
    /// A result.
    pub result: Option<SearchResult>,
    /// A request to the memory, of [`SEARCH_BLOCK`](crate::search::SEARCH_BLOCK) bytes.
    pub request: Option<BlockRequest>,
}

/// A result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchResult {
    /// The number of the job.
    pub id: u64,
    /// The neighbours of the job before it.
    pub rank: u32,
    /// The neighbour; none if the job has none.
    pub neighbour: Option<Neighbour>,
    /// How the job has ended, if the result is the last.
    pub status: SearchStatus,
    /// Whether it is the job's last.
    pub is_last: bool,
}

/// A beat of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response<'b> {
    /// The tag of the request.
    pub tag: u32,
    /// The memory reports an error.
    pub is_error: bool,
    /// The bytes of the beat: an eighth of the memory's width.
    pub beat: &'b [u8],
}

/// The outputs of the unit in a cycle. They depend on the cycles before alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitOutputs {
    /// No ray is in the unit.
    pub is_idle: bool,
    /// Whether a ray is accepted.
    pub ray_ready: bool,
    /// The number of a ray that has ended, and its reply.
    pub hit: Option<(u64, Reply)>,
    /// A candidate.
    pub candidate: Option<AskedCandidate>,
    /// A request to the memory.
    pub request: Option<BlockRequest>,
    /// Whether a beat is taken, which is so in every cycle.
    pub response_ready: bool,
    /// The outputs of searches, in a unit that has them.
    pub search: Option<SearchOutputs>,
}

/// A candidate that waits for a verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedCandidate {
    /// The tag of the verdict.
    pub tag: u32,
    /// The number of the ray.
    pub id: u64,
    /// The candidate.
    pub candidate: Candidate,
}

/// A request to the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BlockRequest {
    /// The address of the block.
    pub address: u64,
    /// The tag of the response.
    pub tag: u32,
}

/// What runs the unit cycle by cycle.
pub trait UnitEngine {
    /// The outputs in this cycle.
    fn outputs(&mut self) -> UnitOutputs;
    /// The clock edge that ends this cycle.
    fn cycle(&mut self, inputs: &UnitInputs<'_>);
    /// A cycle in which `rst_ni` is 0.
    fn reset(&mut self);
    /// What the unit did since its last reset, if the engine counts it.
    fn counts(&self) -> Option<UnitCounts> {
        None
    }
}

/// The simulated netlist of the unit. Inputs of channels that are not valid have arbitrary values.
pub struct NetlistEngine {
    simulator: Simulator,
    inputs: Vec<InputPort>,
    outputs: Vec<OutputPort>,
    ports: UnitPorts,
    arbitrary: u64,
    counts: [u64; COUNTS.len()],
    cycles: u64,
}

impl NetlistEngine {
    /// A unit after a reset.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn new(unit: &UnitNetlist) -> Result<Self, Error> {
        let mut engine = Self::of_module(&unit.top)?;
        engine.ports = engine.ports.with_node_limit(unit.parameters.step.node_limit);
        Ok(engine)
    }

    /// A module with the ports of a unit, such as a unit with a fault, after a reset.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn of_module(top: &Arc<Module>) -> Result<Self, Error> {
        Self::observing(top, |_| false)
    }

    /// As [`of_module`](Self::of_module), with signals that can be observed: those whose hierarchical name is `wanted`
    /// ([`Simulator::observing`]).
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn observing(top: &Arc<Module>, wanted: impl Fn(&str) -> bool) -> Result<Self, Error> {
        let simulator = Simulator::observing(top, wanted)?;
        let input = |port: &raypath_hdl::Port| simulator.input(&port.name);
        let inputs = top.inputs().iter().map(input).collect::<Result<_, _>>()?;
        let output = |port: &raypath_hdl::Port| simulator.output(&port.name);
        let outputs = top.outputs().iter().map(output).collect::<Result<_, _>>()?;
        Ok(Self {
            simulator,
            inputs,
            outputs,
            ports: UnitPorts::of(top),
            arbitrary: 1,
            counts: [0; COUNTS.len()],
            cycles: 0,
        })
    }

    /// The simulator, from which observed signals are read.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// The state after a reset, with random values in registers without a reset value and in memories, on which nothing
    /// may depend. They, and the values of inputs that are not valid, follow from the seed.
    pub fn restart_randomly(&mut self, seed: u64) {
        self.simulator.restart_randomly(seed);
        self.arbitrary = seed | 1;
        (self.counts, self.cycles) = ([0; COUNTS.len()], 0);
    }
}

impl UnitEngine for NetlistEngine {
    fn outputs(&mut self) -> UnitOutputs {
        self.simulator.settle();
        let words: Vec<u64> = self.outputs.iter().map(|&port| self.simulator.get(port)).collect();
        self.ports.outputs(&words)
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        let arbitrary = &mut self.arbitrary;
        let words = self.ports.words(inputs, || {
            *arbitrary = arbitrary.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            *arbitrary >> 8 ^ *arbitrary << 30
        });
        self.inputs.iter().zip(words).for_each(|(&port, word)| self.simulator.set(port, word));
        // They come last, and depend on no input.
        let counted = &self.outputs[self.outputs.len() - COUNTS.len()..];
        self.counts.iter_mut().zip(counted).for_each(|(count, &port)| *count += self.simulator.get(port));
        self.cycles += 1;
        self.simulator.cycle();
    }

    fn counts(&self) -> Option<UnitCounts> {
        let [boxes, triangles, transforms, steps, fetches, rays, restarts, job_stalls, candidates] = self.counts;
        let cycles = self.cycles;
        Some(UnitCounts {
            cycles,
            boxes,
            triangles,
            transforms,
            steps,
            fetches,
            rays,
            restarts,
            job_stalls,
            candidates,
        })
    }

    fn reset(&mut self) {
        (self.counts, self.cycles) = ([0; COUNTS.len()], 0);
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}

/// What the unit counts besides cycles: the ports `count_<name>_o`, the last ones, are 1 in the cycle of an event.
pub const COUNTS: [&str; 9] =
    ["boxes", "triangles", "transforms", "steps", "fetches", "rays", "restarts", "job_stalls", "candidates"];

/// The ports of `raypath_unit`, by which words in the order of their declaration are made and read.
#[derive(Debug, Clone)]
pub struct UnitPorts {
    /// The width of each input.
    widths: Vec<u32>,
    features: UnitFeatures,
    /// Rays have a base.
    has_base: bool,
    /// The inputs before those of searches; none without searches.
    before_searches: Option<usize>,
    node_limit: u32,
}

impl UnitPorts {
    /// The ports of a module that has those of a unit.
    pub fn of(top: &Module) -> Self {
        let has = |port: &str| top.port_width(port).is_some();
        let queries = match (has("hit_geometry_o"), has("cand_valid_o")) {
            (false, _) => Queries::None,
            (true, false) => Queries::Flags,
            (true, true) => Queries::Full,
        };
        let (barycentrics, instances) = (has("hit_u_o"), has("hit_instance_o"));
        let features = UnitFeatures { barycentrics, instances, queries, ..UnitFeatures::OFF };
        let widths = top.inputs().iter().map(|port| top.signal(port.signal).width).collect();
        let before_searches = top.inputs().iter().position(|port| port.name == "search_valid_i");
        Self { widths, features, has_base: has("ray_base_i"), before_searches, node_limit: NODE_LIMIT }
    }

    /// The same with another [`StepParameters::node_limit`](crate::StepParameters::node_limit).
    #[must_use]
    pub fn with_node_limit(self, node_limit: u32) -> Self {
        Self { node_limit, ..self }
    }

    /// The words of the inputs. Inputs of channels that are not valid have the values of `arbitrary`.
    pub fn words(&self, inputs: &UnitInputs<'_>, mut arbitrary: impl FnMut() -> u64) -> Vec<u64> {
        let Self { widths, features, has_base, before_searches, node_limit } = self;
        let mut words: Vec<u64> = Vec::with_capacity(widths.len());
        words.extend([inputs.flush.into(), u64::from(*node_limit), inputs.ray.is_some().into()]);
        let has_mask = features.has("cull_mask");
        match inputs.ray {
            Some((id, ray)) => {
                words.extend([id, ray.flags.into()]);
                words.extend(has_mask.then_some(u64::from(ray.cull_mask)));
                words.push(ray.root.into());
                words.extend(has_base.then_some(u64::from(ray.base)));
                let numbers = ray.origin.into_iter().chain(ray.direction).chain([ray.t_min, ray.t_max]);
                words.extend(numbers.map(|number| u64::from(number.to_bits())));
            }
            None => {
                let count = RAY_PORTS + usize::from(has_mask) + usize::from(*has_base);
                words.extend((0..count).map(|_| arbitrary()));
            }
        }
        words.push(inputs.hit_ready.into());
        if features.has_candidates() {
            words.extend([inputs.candidate_ready, inputs.verdict.is_some()].map(u64::from));
            match inputs.verdict {
                Some((tag, Verdict { accepts, ends, t })) => {
                    words.extend([tag.into(), accepts.into(), ends.into(), u64::from(t.to_bits())]);
                }
                None => words.extend((0..4).map(|_| arbitrary())),
            }
        }
        words.extend([inputs.request_ready, inputs.response.is_some()].map(u64::from));
        match inputs.response {
            Some(Response { tag, is_error, beat }) => {
                words.extend([u64::from(tag), is_error.into()]);
                words.extend(beat.as_chunks().0.iter().map(|bytes| u64::from(u32::from_le_bytes(*bytes))));
            }
            None => words.extend((words.len()..before_searches.unwrap_or(widths.len())).map(|_| arbitrary())),
        }
        if before_searches.is_some() {
            self.search_words(&inputs.search, &mut words, arbitrary);
        }
        words.iter_mut().zip(widths).for_each(|(word, width)| *word &= u64::MAX >> (64 - width));
        words
    }

    /// The outputs from their words; 0 stands for words that are missing.
    pub fn outputs(&self, words: &[u64]) -> UnitOutputs {
        let mut words = words.iter().copied();
        let mut word = || words.next().unwrap_or(0);
        // After `idle_o` comes its inverse.
        let (is_idle, _, ray_ready) = (word() == 1, word(), word() == 1);
        let (has_hit, id, end) = (word() == 1, word(), word() as u32);
        let number = |word: u64| f32::from_bits(word as u32);
        let mut hit = Hit { t: number(word()), primitive: word() as u32, ..Hit::default() };
        (hit.t_num, hit.t_denom, hit.back_face) = (number(word()), number(word()), word() == 1);
        let (nodes, triangles) = (word() as u32, word() as u32);
        let UnitFeatures { barycentrics, instances, .. } = self.features;
        hit.barycentric = barycentrics.then(|| [number(word()), number(word())]);
        let mut instance = instances.then(|| HitInstance { index: word() as u32, ..HitInstance::default() });
        if self.features.has_flags() {
            hit.geometry = word() as u32;
            if let Some(instance) = &mut instance {
                (instance.custom_index, instance.shader_offset) = (word() as u32, word() as u32);
            }
        }
        hit.instance = instance.and_then(HitInstance::or_none);
        let reply = Reply { status: end, hit: status::is_hit(end).then_some(hit), nodes, triangles };
        let candidate = if self.features.has_candidates() { self.candidate(&mut word) } else { None };
        let (has_request, address, tag) = (word() == 1, word(), word() as u32);
        UnitOutputs {
            is_idle,
            ray_ready,
            hit: has_hit.then_some((id, reply)),
            candidate,
            request: has_request.then_some(BlockRequest { address, tag }),
            response_ready: word() == 1,
            search: self.before_searches.map(|_| search_outputs(&mut word)),
        }
    }

    /// Adds the words of the inputs of searches.
    fn search_words(&self, inputs: &SearchInputs<'_>, words: &mut Vec<u64>, mut arbitrary: impl FnMut() -> u64) {
        let SearchInputs { job, result_ready, request_ready, response } = inputs;
        words.push(job.is_some().into());
        let (id, base, address) = job.unwrap_or_else(|| (arbitrary(), arbitrary() as u32, arbitrary() as u32));
        words.extend([id, address.into()]);
        words.extend(self.has_base.then_some(u64::from(base)));
        words.extend([*result_ready, *request_ready, response.is_some()].map(u64::from));
        match response {
            Some(Response { tag, is_error, beat }) => {
                words.extend([u64::from(*tag), (*is_error).into()]);
                words.extend(beat.as_chunks().0.iter().map(|bytes| u64::from(u32::from_le_bytes(*bytes))));
            }
            None => words.extend((words.len()..self.widths.len()).map(|_| arbitrary())),
        }
    }
}

/// The outputs of searches from their words.
fn search_outputs(word: &mut impl FnMut() -> u64) -> SearchOutputs {
    let (is_idle, ready) = (word() == 1, word() == 1);
    let (is_shown, id, rank) = (word() == 1, word(), word() as u32);
    let (index, distance) = (word() as u32, f32::from_bits(word() as u32));
    let neighbour = (word() == 1).then_some(Neighbour { index, distance });
    let status = [SearchStatus::Done, SearchStatus::Refused, SearchStatus::Memory][word().min(2) as usize];
    let is_last = word() == 1;
    let status = if is_last { status } else { SearchStatus::Done };
    let result = is_shown.then_some(SearchResult { id, rank, neighbour, status, is_last });
    let (has_request, address, tag) = (word() == 1, word(), word() as u32);
    // Whether a beat is taken, which is so in every cycle.
    word();
    SearchOutputs { is_idle, ready, result, request: has_request.then_some(BlockRequest { address, tag }) }
}

impl UnitPorts {
    /// The candidate at the ports of its channel, whose words are these.
    fn candidate(&self, word: &mut impl FnMut() -> u64) -> Option<AskedCandidate> {
        let UnitFeatures { barycentrics, instances, .. } = self.features;
        let number = |word: u64| f32::from_bits(word as u32);
        let (is_valid, tag, id) = (word() == 1, word() as u32, word());
        let [origin, direction] = [(); 2].map(|()| [(); 3].map(|()| number(word())));
        let (is_box, is_opaque) = (word() == 1, word() == 1);
        let instance = instances.then(|| HitInstance {
            index: word() as u32,
            custom_index: word() as u32,
            shader_offset: word() as u32,
        });
        let mut hit = Hit { instance: instance.and_then(HitInstance::or_none), ..Hit::default() };
        (hit.t, hit.primitive, hit.geometry) = (number(word()), word() as u32, word() as u32);
        (hit.t_num, hit.t_denom) = (number(word()), number(word()));
        let weights = barycentrics.then(|| [number(word()), number(word())]);
        hit.barycentric = weights.filter(|_| !is_box).map(|weights| weights.map(|weight| weight / hit.t_denom));
        hit.back_face = word() == 1;
        // The port that says that verdicts are taken.
        word();
        let candidate = Candidate { hit, is_box, is_opaque, origin, direction };
        is_valid.then_some(AskedCandidate { tag, id, candidate })
    }
}

/// The ports of a ray besides `ray_valid_i`, without its mask and its base.
const RAY_PORTS: usize = 11;
