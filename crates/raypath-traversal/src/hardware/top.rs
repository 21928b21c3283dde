//! The top module: the datapath and the parts around it.

use super::blocks::{blocks, data_words, job_words};
use super::connect::{Inputs, Named, Outputs, keep, named, prefixed};
use super::decoder::decoder;
use super::distance::distance;
use super::hits::hits;
use super::issue::issue;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use super::rays::rays;
use super::walk::walk;
use crate::blocks::{BOX_WORDS, NodeKind};
use crate::error::UnitError;
use crate::instance::{TRANSFORM_OPCODE, Transform, TransformInput};
use crate::netlist::{Netlist, from_wires, wires};
use crate::set_up::Entry;
use crate::step::UnitFeatures;
use raypath_hdl::{Builder, Forward, Module, Wire};
use raypath_model::{Control, Shape};
use raypath_ops::{Binary32, Culling, JobKind, RayBoxInput, RayTriangleInput, ports_of};
use raypath_rtl::{Config, Datapath, Features, Lanes, Operations, PARAMETER_GROUPS, Parameter};
use std::sync::Arc;

/// The unit's netlist and that of its datapath.
#[derive(Debug)]
pub struct UnitNetlist {
    /// The module `raypath_unit`.
    pub top: Arc<Module>,
    /// Its datapath.
    pub datapath: Datapath,
    /// The configuration of the datapath, with what the unit needs.
    pub config: Config,
    /// The parameters of the unit.
    pub parameters: UnitParameters,
}

/// The bits of a job's tag besides the context: the triangle's place, and whether it is the last of its block.
/// Blocks of quantised nodes have one.
const fn tag_bits(nodes: NodeKind) -> u32 {
    match nodes {
        NodeKind::Wide4 => 3,
        NodeKind::Quantised => 0,
    }
}

impl UnitNetlist {
    /// Builds the unit around a datapath of this configuration. Distance operations are left out, and the features that
    /// the unit needs are added: a tag, facing, and hits of both faces. The feature `barycentrics` is that of the unit.
    ///
    /// # Errors
    /// A parameter out of its range; rules, a format, an encoding or features that the unit does not have.
    pub fn new(config: Config, parameters: UnitParameters) -> Result<Self, UnitError> {
        let mut parameters = parameters;
        parameters.step.features.barycentrics |= config.semantics.features.barycentrics;
        parameters.check()?;
        check(config)?;
        let tag = bits(parameters.contexts) + tag_bits(parameters.step.node);
        let UnitFeatures { barycentrics, .. } = parameters.step.features;
        let features = Features { tag, facing: true, barycentrics, culling: Culling::None, ..Features::OFF };
        let config = config.lanes(Lanes::None).features(features);
        let datapath = datapath(config, parameters)?;
        let top = top(datapath.top(), parameters)?;
        Ok(Self { top, datapath, config, parameters })
    }

    /// The shape of the datapath's pipeline.
    pub fn shape(&self) -> Shape {
        let control = match self.config.microarchitecture.control {
            raypath_rtl::Control::Skid => Control::Skid,
            raypath_rtl::Control::Credit => Control::Credit,
        };
        // Boxes and triangles have no accumulators.
        let (latency, interval) = (self.datapath.latency() as usize, self.datapath.interval() as usize);
        Shape { latency, control, interval, loops: Vec::new() }
    }
}

/// An error for what the unit does not have.
fn check(config: Config) -> Result<(), UnitError> {
    match fixed_parameters().find(|parameter| parameter.get(&config) != parameter.default()) {
        None => Ok(()),
        Some(fixed) => {
            Err(UnitError::Datapath { parameter: fixed.name, value: fixed.get(&config), expected: fixed.default() })
        }
    }
}

/// The parameters of the datapath that a unit has at their defaults alone: the rules and the numbers at its ports, and
/// all features but barycentric coordinates, because it adds those that it needs.
pub fn fixed_parameters() -> impl Iterator<Item = &'static Parameter> {
    let [semantics, microarchitecture, features] = PARAMETER_GROUPS;
    let of_ports = semantics.parameters.iter().chain(microarchitecture.parameters);
    of_ports
        .filter(|parameter| ["rules", "box-bits", "format", "io"].contains(&parameter.name))
        .chain(features.parameters.iter().filter(|parameter| parameter.name != "barycentrics"))
}

/// The datapath of this configuration; with instances, it has the operation that transforms rays too.
fn datapath(config: Config, parameters: UnitParameters) -> Result<Datapath, UnitError> {
    if !parameters.step.features.instances {
        return Ok(Datapath::new(config)?);
    }
    config.check()?;
    let mut operations = Operations::new().tag(config.semantics.features.tag);
    config.semantics.operations(&mut operations)?;
    Ok(Datapath::build(operations.with(&Transform, TRANSFORM_OPCODE)?, config.microarchitecture)?)
}

fn top(datapath: &Arc<Module>, parameters: UnitParameters) -> Result<Arc<Module>, UnitError> {
    let UnitParameters { contexts, memory_width, id_width, step, .. } = parameters;
    let (features, nodes, offset_bits) = (step.features, step.node, step.node.offset_bits());
    let builder = Builder::new("raypath_unit");
    let m = &builder;
    m.doc("A ray goes in, the closest or any hit comes out.");
    m.doc(format!("{parameters}."));
    let width = bits(contexts);
    let ray_valid = m.input("ray_valid_i", 1);
    let ray = [("id", id_width), ("any_hit", 1), ("cull", 2), ("root", 32)];
    let ray = ray.map(|(name, width)| named(name, m.input(&format!("ray_{name}_i"), width)));
    let port = |field: &str, width| m.input(&format!("{}_i", field.replace("ray_t_m", "ray_tm")), width);
    let entry: Entry<Netlist<'_>> = from_wires(m, "ray", port);
    let hit_ready = m.input("hit_ready_i", 1);
    let request_ready = m.input("mem_req_ready_i", 1);
    let arrives = m.input("mem_rsp_valid_i", 1);
    let arrived_context = m.input("mem_rsp_tag_i", width);
    let error = m.input("mem_rsp_error_i", 1);
    let data = data_words(m, "mem_rsp_data", "_i", memory_width);

    // What flows backwards.
    let [start_taken, block_taken, fault_taken] =
        ["start_taken", "block_taken", "fault_taken"].map(|name| m.forward(name, 1));
    let [releases, take, limits_read, step_read, fetches, job_ready] =
        ["releases", "take", "limits_read", "step_read", "fetches", "job_ready"].map(|name| m.forward(name, 1));
    let [hit_context, take_context, limits_context, step_context, fetch_context] =
        ["hit_context", "take_context", "limits_context", "step_context", "fetch_context"]
            .map(|name| m.forward(name, width));
    // The ray is read when its job comes next: with quantised nodes, when the block leaves the decoder.
    let decodes = (nodes == NodeKind::Quantised)
        .then(|| [("decodes", 1), ("decodes_context", width), ("issue_ready", 1)].map(|(name, w)| m.forward(name, w)));
    let [job_read, job_context, issue_ready] = match &decodes {
        None => [take.wire(), take_context.wire(), job_ready.wire()],
        Some(decodes) => decodes.map(Forward::wire),
    };
    let [fetch_count, fetch_extent] = [("fetch_count", 2), ("fetch_extent", 32)].map(|(name, w)| m.forward(name, w));
    // With instances: to the set-up of rays, and to what is kept of a fetch.
    let backwards = |paths: &[(&str, u32)]| -> Vec<(String, Forward<'_>)> {
        let paths = if features.instances { paths } else { &[] };
        paths.iter().map(|(name, width)| (name.to_string(), m.forward(name, *width))).collect()
    };
    let to_rays = backwards(&[
        ("job_inside", 1),
        ("transformed_valid", 1),
        ("transformed_is_last", 1),
        ("transformed_context", width),
        ("transformed_x", 32),
        ("transformed_y", 32),
        ("transformed_z", 32),
    ]);
    let to_fetched = backwards(&[("fetch_is_instance", 1), ("fetch_inside", 1)]);

    m.section("Rays");
    let rays = Inputs::default()
        .port("valid", ray_valid)
        .ports(wires("entry", &entry))
        .ports(ray)
        .port("start_taken", start_taken.wire())
        .port("release", releases.wire())
        .port("hit_context", hit_context.wire())
        .port("job_read", job_read)
        .port("job_context", job_context)
        .port("limits_read", limits_read.wire())
        .port("limits_context", limits_context.wire())
        .port("step_read", step_read.wire())
        .port("step_context", step_context.wire())
        .ports(to_rays.iter().map(|(name, forward)| named(name, forward.wire())))
        .place(m, "u_rays", &rays(parameters)?);

    m.section("Blocks and their jobs");
    let data = data.into_iter().enumerate().map(|(word, wire)| named(&format!("data_{word}"), wire));
    let blocks = Inputs::default()
        .port("valid", arrives)
        .port("context", arrived_context)
        .port("error", error)
        .ports(data)
        .port("job_read", take.wire())
        .port("job_context", take_context.wire())
        .port("child_read", step_read.wire())
        .port("child_context", step_context.wire())
        .port("index_read", limits_read.wire())
        .port("index_context", limits_context.wire())
        .place(m, "u_blocks", &blocks(contexts, memory_width, nodes)?);
    let mut fetched = vec![named("count", fetch_count.wire()), named("extent", fetch_extent.wire())];
    fetched.extend(to_fetched.iter().map(|(name, forward)| named(name.trim_start_matches("fetch_"), forward.wire())));
    let by_fetch = (fetches.wire(), fetch_context.wire());
    let fetched = keep("u_fetched", contexts, by_fetch, fetched, (job_read, job_context));
    let words = prefixed("word", blocks.under("word"));
    let count = named("count", fetched[0].1);
    let of_block: Named<'_> = match nodes {
        NodeKind::Wide4 => [count].into_iter().chain(words.iter().cloned()).collect(),
        NodeKind::Quantised => Vec::new(),
    };
    let issue = Inputs::default()
        .port("arrived", blocks.port("arrived"))
        .port("arrived_failed", blocks.port("failed"))
        .port("arrived_context", arrived_context)
        .ports(of_block)
        .port("ready", issue_ready)
        .port("fault_taken", fault_taken.wire())
        .place(m, "u_issue", &issue(contexts, nodes)?);
    take.drive(issue.port("take"));
    take_context.drive(issue.port("take_context"));
    let decoder = match decodes {
        None => None,
        Some([decodes, context, ready]) => {
            let decoder = Inputs::default()
                .port("valid", issue.port("offer"))
                .port("context", issue.port("context"))
                .ports(words)
                .ports(prefixed("exists", blocks.under("exists")))
                .port("ready", job_ready.wire())
                .place(m, "u_decoder", &decoder(contexts)?);
            decodes.drive(decoder.port("read"));
            context.drive(decoder.port("read_context"));
            ready.drive(decoder.port("ready"));
            Some(decoder)
        }
    };

    m.section("The datapath");
    let opcode = |opcode: u64| m.constant(datapath.port_width("opcode_i").unwrap_or(1), opcode);
    let [boxes, triangle] = [JobKind::Quadbox, JobKind::Triangle].map(|kind| opcode(kind.opcode()));
    let other = fetched.get(2).map_or(triangle, |(_, is_instance)| is_instance.mux(opcode(TRANSFORM_OPCODE), triangle));
    let job = Job { rays: &rays, blocks: &blocks, issue: &issue, decoder: decoder.as_ref(), extent: fetched[1].1 };
    let (offer, is_node, tag) = match &decoder {
        None => {
            let tag = m.concat(&[issue.port("context"), issue.port("place"), issue.port("is_last")]);
            (issue.port("offer"), issue.port("is_node"), tag)
        }
        Some(decoder) => (decoder.port("valid"), fetched[0].1.is(0).named("is_node"), decoder.port("context")),
    };
    let outcome_ready = m.forward("outcome_ready", 1);
    let outcome = Inputs::default()
        .port("input_valid", offer)
        .port("output_ready", outcome_ready.wire())
        .port("opcode", is_node.mux(boxes, other))
        .port("tag", tag)
        .ports(job.inputs(m, datapath))
        .place(m, "u_datapath", datapath);
    job_ready.drive(outcome.port("input_ready"));
    let is_boxes = outcome.port("opcode").equals(boxes).named("is_boxes");
    let tag = outcome.port("tag");
    let outcome_context = tag.upper(width).named("outcome_context");
    let is_transform =
        features.instances.then(|| outcome.port("opcode").equals(opcode(TRANSFORM_OPCODE)).named("is_transform"));

    m.section("Distances of triangles");
    let weights = ["u", "v"].map(|name| (format!("{name}_num"), format!("barycentric_{name}")));
    let weights = weights.into_iter().filter(|(name, _)| features.has(name));
    let weights: Named<'_> = weights.map(|(name, port)| (name, outcome.port(&port))).collect();
    let place: Named<'_> = match nodes {
        NodeKind::Wide4 => vec![named("place", tag.bits(2, 1)), named("is_last", tag.bit(0))],
        NodeKind::Quantised => Vec::new(),
    };
    let is_triangle = is_transform.map_or(!is_boxes, |is_transform| !is_boxes & !is_transform);
    let closest = Inputs::default()
        .port("valid", outcome.port("output_valid") & is_triangle)
        .port("context", outcome_context)
        .ports(place)
        .port("is_hit", outcome.port("triangle_hit"))
        .port("is_front", outcome.port("facing"))
        .port("t_num", outcome.port("t_num"))
        .port("t_denom", outcome.port("t_denom"))
        .ports(weights)
        .ports(prefixed("limits", rays.under("limits")))
        .ports(prefixed("index", blocks.under("index")))
        .port("taken", block_taken.wire())
        .place(m, "u_distance", &distance(parameters)?);
    limits_read.drive(closest.port("read"));
    limits_context.drive(closest.port("read_context"));
    // Outcomes of box jobs wait in a memory.
    let is_taken = closest.port("ready");
    let is_taken = is_transform.map_or(is_taken, |is| is.mux(rays.port("transformed_ready"), is_taken));
    outcome_ready.drive(is_boxes | is_taken);

    m.section("Steps");
    let tmin = (1..4).map(|k| named(&format!("boxes_tmin_{}", k - 1), outcome.port(&format!("tmin_{k}"))));
    let walk = Inputs::default()
        .port("boxes_valid", outcome.port("output_valid") & is_boxes)
        .port("boxes_context", outcome_context)
        .port("boxes_hit", outcome.port("is_intersect"))
        .ports(tmin)
        .ports(prefixed("boxes_box_index", outcome.under("box_index")))
        .port("block_valid", closest.port("valid"))
        .port("block_context", closest.port("context"))
        .ports(prefixed("closest", closest.under("closest")))
        .port("fault_valid", issue.port("fault_valid"))
        .port("fault_context", issue.port("context"))
        .ports(prefixed("start", rays.under("start")))
        .ports(prefixed("child", blocks.under("child")))
        .ports(prefixed("begin", rays.under("begin")))
        .place(m, "u_walk", &walk(parameters)?);
    for (forward, name) in [(start_taken, "start"), (block_taken, "block"), (fault_taken, "fault")] {
        forward.drive(walk.port(&format!("{name}_taken")));
    }
    step_read.drive(walk.port("read"));
    step_context.drive(walk.port("read_context"));
    fetches.drive(walk.port("fetches"));
    fetch_context.drive(walk.port("context"));
    fetch_count.drive(walk.port("count"));
    fetch_extent.drive(walk.port("next_extent"));

    if let Some(is_transform) = is_transform {
        let to_set_up = [outcome.port("output_valid") & is_transform, tag.bit(0), outcome_context].into_iter();
        let transformed = outcome.under("transformed").into_iter().map(|(_, wire)| wire);
        let wires = [fetched[3].1].into_iter().chain(to_set_up).chain(transformed);
        to_rays.into_iter().zip(wires).for_each(|((_, forward), wire)| forward.drive(wire));
        let wires = [walk.port("is_instance"), walk.port("is_inside")];
        to_fetched.into_iter().zip(wires).for_each(|((_, forward), wire)| forward.drive(wire));
    }

    m.section("Requests to the memory, and hits");
    let columns = [("context", width), ("block", 32 - offset_bits)];
    let request = Inputs::default()
        .port("push", walk.port("fetches"))
        .port("context", walk.port("context"))
        .port("block", walk.port("block"))
        .port("pop", request_ready)
        .place(m, "u_requests", &queue("raypath_unit_requests", contexts, &columns)?);
    let hits = Inputs::default()
        .port("ends", walk.port("ends"))
        .port("context", walk.port("context"))
        .port("status", walk.port("status"))
        .ports(prefixed("next", walk.under("next")))
        .port("ready", hit_ready)
        .place(m, "u_hits", &hits(parameters)?);
    releases.drive(hits.port("release"));
    hit_context.drive(hits.port("context"));

    m.output("ray_ready_o", rays.port("ready"));
    m.output("hit_valid_o", hits.port("valid"));
    m.output("hit_id_o", rays.port("id"));
    for name in ["status", "t", "triangle", "t_num", "t_denom", "back_face", "nodes", "triangles"] {
        m.output(&format!("hit_{name}_o"), hits.port(name));
    }
    if features.barycentrics {
        ["u", "v"].into_iter().for_each(|name| m.output(&format!("hit_{name}_o"), hits.port(name)));
    }
    if features.instances {
        m.output("hit_instance_o", hits.port("instance"));
    }
    m.output("mem_req_valid_o", request.port("valid"));
    m.output("mem_req_addr_o", m.concat(&[request.port("block"), m.constant(offset_bits, 0)]));
    m.output("mem_req_tag_o", request.port("context"));
    m.output("mem_rsp_ready_o", m.constant(1, 1));
    Ok(builder.finish()?)
}

/// Where the inputs of a job come from.
struct Job<'a, 'm> {
    rays: &'a Outputs<'m>,
    blocks: &'a Outputs<'m>,
    issue: &'a Outputs<'m>,
    decoder: Option<&'a Outputs<'m>>,
    extent: Wire<'m>,
}

impl<'m> Job<'_, 'm> {
    /// The inputs of the datapath's operations.
    fn inputs(&self, m: &'m Builder, datapath: &Module) -> Named<'m> {
        let mut found: Named<'m> = Vec::new();
        let mut corners = 0..;
        let mut vertices = 0..;
        let mut matrix = 0..;
        let boxes = ports_of::<RayBoxInput<Binary32>>().into_iter();
        let triangles = ports_of::<RayTriangleInput<Binary32>>().into_iter();
        let transform = ports_of::<TransformInput<Binary32>>().into_iter();
        for port in boxes.chain(triangles).chain(transform) {
            let name = port.name;
            if found.iter().any(|(known, _)| *known == name) || datapath.port_width(&format!("{name}_i")).is_none() {
                continue;
            }
            let wire = match name.strip_prefix("ray_") {
                Some("extent") => self.extent,
                // The rules of the unit do not read the direction.
                Some(field) if field.starts_with("dir_") => m.constant(32, 0),
                Some(field) => self.rays.port(&format!("job_{field}")),
                None if name.starts_with("aabb_") => {
                    let corner: usize = corners.next().unwrap_or_default();
                    let word = box_word(corner);
                    self.decoder.map_or_else(
                        || self.blocks.port(&format!("word_{word}")),
                        |decoder| decoder.port(&format!("bound_{word}")),
                    )
                }
                None if name.starts_with("point_") => {
                    let axis = name.trim_start_matches("point_");
                    let [origin, dir] = ["origin", "dir"].map(|of| self.rays.port(&format!("job_{of}_{axis}")));
                    self.issue.port("is_last").mux(dir, origin)
                }
                None if name.starts_with("matrix_") => {
                    let place: usize = matrix.next().unwrap_or_default();
                    let word = self.blocks.port(&format!("word_{place}"));
                    // A direction is not moved.
                    let is_moved = !self.issue.port("is_last");
                    if name.ends_with("_t") { word & is_moved.replicate(32) } else { word }
                }
                None => {
                    let vertex: usize = vertices.next().unwrap_or_default();
                    self.decoder.unwrap_or(self.issue).port(&format!("triangle_{vertex}"))
                }
            };
            found.push((name, wire));
        }
        found
    }
}

/// The place in memory of a bound of the boxes of a block. In the operation's input, the bounds of a slab follow each
/// other; in memory the minima come first.
fn box_word(place: usize) -> usize {
    let (child, bound) = (place / BOX_WORDS, place % BOX_WORDS);
    let (axis, is_max) = (bound / 2, bound % 2);
    BOX_WORDS * child + 3 * is_max + axis
}

const _: () = assert!(4 * BOX_WORDS <= job_words(NodeKind::Wide4));
