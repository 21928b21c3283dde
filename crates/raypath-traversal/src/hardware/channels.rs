//! The inputs of the unit by channel, and the wires between its parts that flow backwards.

use super::blocks::data_words;
use super::connect::{Access, Named, named};
use super::parameters::UnitParameters;
use super::queue::bits;
use crate::blocks::NodeKind;
use crate::netlist::{Netlist, from_wires};
use crate::search::{SEARCH_BLOCK, SearchParameters};
use crate::set_up::Entry;
use crate::step::StepParameters;
use raypath_hdl::{Builder, Forward, Register, Wire};

/// The ports of the unit that belong together, by the beginning of their names.
pub const CHANNELS: [(&str, &str); 6] = [
    ("ray_", "A ray enters where valid and ready are 1."),
    ("hit_", "The hit of a ray that has ended, in the order of the ends; it stays until ready is 1."),
    ("cand_", "A candidate, about which the user decides; its tag tells the ray."),
    ("answer_", "The verdict on the candidate with this tag, in any order, after any time."),
    ("search_", "A search enters where valid and ready are 1: the address of its job, a multiple of 64."),
    ("result_", "A result of a search that has ended, the best first; it stays until ready is 1."),
];
/// Those of the memory's channels, and the counts.
pub const OF_MEMORY: [(&str, &str); 5] = [
    ("mem_req_", "The request of a block: it stays until ready is 1; a tag has one request at a time."),
    ("mem_rsp_", "A beat of a block, those of a tag in order of addresses; ready is always 1."),
    ("vec_req_", "The request of 64 bytes of searches: it stays until ready is 1."),
    ("vec_rsp_", "A beat of them, those of a tag in order of addresses; ready is always 1."),
    COUNTED,
];
/// The counts.
pub const COUNTED: (&str, &str) = ("count_", "Events of the cycle, for counters.");

/// The inputs of the unit, by channel. While rays are dropped, none enters, and hits and candidates are taken.
pub struct Ports<'m> {
    pub flush: Wire<'m>,
    pub node_limit: Wire<'m>,
    /// Rays are dropped.
    pub flushes: Register<'m>,
    /// A ray: whether there is one, and its fields besides those of the entry.
    pub ray_valid: Wire<'m>,
    /// With candidates: whether one is taken, and a verdict with its context. While rays are dropped, a candidate that
    /// is taken is its own verdict, if there is no other.
    pub candidate_ready: Option<Wire<'m>>,
    pub verdict: Named<'m>,
    /// With candidates: whether one is at the port, and its context.
    pub candidate: Option<[Forward<'m>; 2]>,
    pub ray: Named<'m>,
    pub entry: Entry<Netlist<'m>>,
    pub hit_ready: Wire<'m>,
    pub request_ready: Wire<'m>,
    /// A beat of the memory: whether there is one, its context, its error and its words.
    pub beat_valid: Wire<'m>,
    pub beat_context: Wire<'m>,
    pub beat_error: Wire<'m>,
    pub beat: Vec<Wire<'m>>,
    /// With searches: their channels, by the names that `raypath_search` has.
    pub search: Named<'m>,
}

impl<'m> Ports<'m> {
    pub fn new(m: &'m Builder, parameters: UnitParameters) -> Self {
        let UnitParameters { contexts, memory_width, id_width, step, search, .. } = parameters;
        let base = parameters.base_bits();
        let flush = m.input("flush_i", 1).comment("all rays are dropped, until idle_o is 1");
        let node_limit = m.input("node_limit_i", 32).comment("the nodes that a ray may read; 0: any number");
        let flushes = m.register("flushes_q", 1).reset_to(0);
        let ray_valid = m.input("ray_valid_i", 1) & !flushes.wire();
        let ray = [("id", id_width), ("flags", 10), ("cull_mask", 8), ("root", 32)].into_iter();
        let ray = ray.filter(|(name, _)| step.features.has(name)).chain((base > 0).then_some(("base", base)));
        let ray = ray.map(|(name, width)| named(name, m.input(&format!("ray_{name}_i"), width))).collect();
        let port = |field: &str, width| m.input(&format!("{}_i", field.replace("ray_t_m", "ray_tm")), width);
        let (entry, hit_ready) = (from_wires(m, "ray", port), m.input("hit_ready_i", 1) | flushes.wire());
        let (mut candidate_ready, mut candidate, mut verdict) = (None, None, Vec::new());
        if step.features.has_candidates() {
            let ready = m.input("cand_ready_i", 1);
            verdict = self::verdict(m, contexts);
            let [valid, tag] =
                [("candidate_valid", 1), ("candidate_tag", bits(contexts))].map(|(name, width)| m.forward(name, width));
            let given = verdict[0].1;
            candidate_ready = Some(flushes.wire().mux(!given, ready));
            verdict[0].1 = given | (flushes.wire() & valid.wire());
            verdict[1].1 = given.mux(verdict[1].1, tag.wire());
            candidate = Some([valid, tag]);
        }
        Self {
            flush,
            node_limit,
            flushes,
            ray_valid,
            ray,
            entry,
            hit_ready,
            candidate_ready,
            verdict,
            candidate,
            request_ready: m.input("mem_req_ready_i", 1),
            beat_valid: m.input("mem_rsp_valid_i", 1),
            beat_context: m.input("mem_rsp_tag_i", bits(contexts)),
            beat_error: m.input("mem_rsp_error_i", 1),
            beat: data_words(m, "mem_rsp_data", "_i", memory_width),
            search: search.0.map_or_else(Vec::new, |search| search_ports(m, search, parameters)),
        }
    }
}

/// What flows backwards: a later part drives what an earlier one reads.
pub struct Backwards<'m> {
    /// Where answers are taken: of rays that start, of blocks, of faults.
    pub taken: [Forward<'m>; 3],
    /// A hit frees the context of its ray.
    pub releases: (Forward<'m>, Forward<'m>),
    /// A block is taken for its jobs.
    pub take: (Forward<'m>, Forward<'m>),
    /// The limits of a ray and the indices of its block are read.
    pub limits: (Forward<'m>, Forward<'m>),
    /// The ray of a step is read.
    pub step: (Forward<'m>, Forward<'m>),
    /// A ray fetches a block, with its number of triangles and the ray's extent.
    pub fetch: (Forward<'m>, Forward<'m>),
    pub fetch_count: Forward<'m>,
    pub fetch_extent: Forward<'m>,
    /// With eight children: which of them are taken.
    pub fetch_window: Option<Forward<'m>>,
    /// With flags: the triangles of the block that are not hit, by name.
    pub fetch_culls: Vec<(String, Forward<'m>)>,
    /// With candidates, by name: whether the id and the ray of one are read, and its context; the closest hit of a
    /// block, with its context, its distance and its index.
    pub candidate: Vec<(String, Forward<'m>)>,
    pub tested: Vec<(String, Forward<'m>)>,
    /// The datapath takes a job.
    pub job_ready: Forward<'m>,
    /// With a decoder: a block enters the decoder's last stage, with its context; the decoder takes a block.
    pub decoder: Option<[Forward<'m>; 3]>,
    /// With instances: to the set-up of rays, and to what is kept of a fetch.
    pub to_rays: Vec<(String, Forward<'m>)>,
    pub to_fetched: Vec<(String, Forward<'m>)>,
}

impl<'m> Backwards<'m> {
    pub fn new(m: &'m Builder, parameters: UnitParameters) -> Self {
        let UnitParameters { contexts, step, .. } = parameters;
        let StepParameters { features, node, .. } = step;
        let width = bits(contexts);
        let taken = ["start_taken", "block_taken", "fault_taken"].map(|name| m.forward(name, 1));
        let [releases, take, limits, steps, fetches, job_ready] =
            ["releases", "take", "limits_read", "step_read", "fetches", "job_ready"].map(|name| m.forward(name, 1));
        let [hit_context, take_context, limits_context, step_context, fetch_context] =
            ["hit_context", "take_context", "limits_context", "step_context", "fetch_context"]
                .map(|name| m.forward(name, width));
        let all = |paths: &[(&str, u32)]| -> Vec<(String, Forward<'m>)> {
            paths.iter().map(|(name, width)| (name.to_string(), m.forward(name, *width))).collect()
        };
        let decoder = step.has_decoder().then(|| {
            [("decodes", 1), ("decodes_context", width), ("issue_ready", 1)].map(|(name, w)| m.forward(name, w))
        });
        let [fetch_count, fetch_extent] =
            [("fetch_count", 2), ("fetch_extent", 32)].map(|(name, w)| m.forward(name, w));
        let of_candidates = |paths: &[(&str, u32)]| if features.has_candidates() { all(paths) } else { Vec::new() };
        let candidate = of_candidates(&[("candidate_read", 1), ("candidate_context", width)]);
        let tested = [("is_tested", 1), ("tested_context", width), ("after_t", 32), ("after_primitive", 32)];
        let of_instances = |paths| if features.instances { all(paths) } else { Vec::new() };
        Self {
            taken,
            releases: (releases, hit_context),
            take: (take, take_context),
            limits: (limits, limits_context),
            step: (steps, step_context),
            fetch: (fetches, fetch_context),
            fetch_count,
            fetch_extent,
            fetch_window: (node == NodeKind::Wide8).then(|| m.forward("fetch_window", 2)),
            fetch_culls: if features.has_flags() {
                all(&CULLS[..if features.has_candidates() { 3 } else { 2 }])
            } else {
                Vec::new()
            },
            candidate,
            tested: of_candidates(&tested),
            job_ready,
            decoder,
            to_rays: of_instances(&[
                ("job_inside", 1),
                ("transformed_valid", 1),
                ("transformed_is_last", 1),
                ("transformed_context", width),
                ("transformed_x", 32),
                ("transformed_y", 32),
                ("transformed_z", 32),
            ]),
            to_fetched: of_instances(&[("fetch_is_instance", 1), ("fetch_inside", 1)]),
        }
    }

    /// The ray is read when its job comes next: with a decoder, when the block leaves it.
    pub fn job(&self) -> Access<'m> {
        let (read, context) = self.decoder.map_or(self.take, |[decodes, context, _]| (decodes, context));
        (read.wire(), context.wire())
    }
}

/// What is kept of a fetch for the hits of its block, with candidates all of it.
const CULLS: [(&str, u32); 3] = [("culls_clockwise", 1), ("culls_counter_clockwise", 1), ("repeats", 1)];

/// The ports of searches.
fn search_ports(m: &Builder, search: SearchParameters, parameters: UnitParameters) -> Named<'_> {
    let UnitParameters { id_width, memory_width, .. } = parameters;
    let base = parameters.base_bits();
    let ports = [("search_valid", 1), ("search_id", id_width), ("search_job", 32)].into_iter();
    let ports = ports.chain((base > 0).then_some(("search_base", base)));
    let of_memory =
        [("vec_req_ready", 1), ("vec_rsp_valid", 1), ("vec_rsp_tag", bits(search.blocks)), ("vec_rsp_error", 1)];
    let ports = ports.chain([("result_ready", 1)]).chain(of_memory);
    let mut ports: Named<'_> = ports.map(|(name, width)| named(name, m.input(&format!("{name}_i"), width))).collect();
    let data = data_words(m, "vec_rsp_data", "_i", memory_width.min(8 * SEARCH_BLOCK));
    ports.extend(data.into_iter().enumerate().map(|(word, wire)| named(&format!("vec_rsp_data_{word}"), wire)));
    ports
}

/// The ports of a verdict, by the names that the steps have for them.
fn verdict(m: &Builder, contexts: u32) -> Named<'_> {
    let ports =
        [("valid", "valid", 1), ("context", "tag", bits(contexts)), ("accepts", "accept", 1), ("ends", "end", 1)];
    let ports = ports.into_iter().chain([("t", "t", 32)]);
    ports.map(|(name, port, width)| named(name, m.input(&format!("answer_{port}_i"), width))).collect()
}
