//! The top module: the datapath and the parts around it.

use super::blocks::blocks;
use super::candidates::{candidates, is_of_candidate};
use super::channels::{Backwards, CHANNELS, OF_MEMORY, Ports};
use super::connect::{Inputs, Named, Outputs, keep, named, prefixed};
use super::decoder::{decoder, words};
use super::distance::distance;
use super::hits::{hits, is_shown as is_of_hit};
use super::issue::{issue, tells_instances, triangle_words};
use super::jobs::Jobs;
use super::parameters::UnitParameters;
use super::parametric::parametric;
use super::queue::{bits, queue};
use super::rays::rays;
use super::search::search_engine;
use super::shared::{beat_inputs, node_inputs, whose_turn};
use super::walk::walk;
use crate::blocks::{NodeKind, VERTEX_WORDS};
use crate::engine::COUNTS;
use crate::error::UnitError;
use crate::instance::{TRANSFORM_OPCODE, Transform};
use crate::netlist::wires;
use crate::search::{BOXES_OPCODE, KEYS_OPCODE, SearchParameters};
use crate::step::{StepParameters, UnitFeatures};
use raypath_hdl::{Builder, Forward, Module, Wire};
use raypath_model::{Control, Loop, Shape};
use raypath_ops::operations::key_compare::KeyCompare;
use raypath_ops::operations::point_in_box::PointInBox;
use raypath_ops::{Culling, EdgeRule, JobKind};
use raypath_rtl::{Config, DatapathNetlist, Features, Lanes, Operations, PARAMETER_GROUPS, Parameter};
use std::sync::Arc;

/// The unit's netlist and that of its datapath.
#[derive(Debug)]
pub struct UnitNetlist {
    /// The module `raypath_unit`.
    pub top: Arc<Module>,
    /// Its datapath.
    pub datapath: DatapathNetlist,
    /// The configuration of the datapath, with what the unit needs.
    pub config: Config,
    /// The parameters of the unit.
    pub parameters: UnitParameters,
}

impl UnitNetlist {
    /// Builds the unit around a datapath of this configuration. Distance operations are left out, and the features that
    /// the unit needs are added: a tag, facing, hits of both faces, and conservative boxes. The feature `barycentrics`
    /// is that of the unit.
    ///
    /// # Errors
    /// A parameter out of its range; rules, a format, an encoding or features that the unit does not have.
    pub fn new(config: Config, parameters: UnitParameters) -> Result<Self, UnitError> {
        let mut parameters = parameters;
        parameters.step.features.barycentrics |= config.semantics.features.barycentrics;
        if config.semantics.features.edges == EdgeRule::Once {
            parameters.step.features.edges = EdgeRule::Once;
        }
        parameters.check()?;
        check(config)?;
        // Besides the context: the place in the block, and whether it is the last.
        let tag = bits(parameters.contexts) + parameters.step.of_job().map(|(_, width)| width).iter().sum::<u32>();
        let UnitFeatures { barycentrics, edges, .. } = parameters.step.features;
        let features = Features {
            tag,
            facing: true,
            barycentrics,
            edges,
            culling: Culling::None,
            conservative: true,
            ..Features::OFF
        };
        let lanes = if parameters.search.0.is_some() { Lanes::Sixteen } else { Lanes::None };
        let config = config.lanes(lanes).features(features);
        let datapath = datapath(config, parameters)?;
        let top = top(datapath.top(), parameters)?;
        Ok(Self { top, datapath, config, parameters })
    }

    /// The module `raypath_unit` as it is emitted: with parameters in the texts of its modules, whose defaults are
    /// those of this unit.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn emitted(&self) -> Result<Arc<Module>, UnitError> {
        parametric(&self.top, self.datapath.top(), self.parameters, top)
    }

    /// The shape of the datapath's pipeline.
    pub fn shape(&self) -> Shape {
        let control = match self.config.microarchitecture.control {
            raypath_rtl::Control::Skid => Control::Skid,
            raypath_rtl::Control::Credit => Control::Credit,
        };
        // Of the accumulators of beats.
        let loops = self.datapath.loops().into_iter().map(|found| Loop {
            opcode: found.opcode,
            first: found.first as usize,
            last: found.last as usize,
        });
        let (latency, interval) = (self.datapath.latency() as usize, self.datapath.interval() as usize);
        Shape { latency, control, interval, loops: loops.collect() }
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

/// The parameters of the datapath that a unit has at their defaults alone: the rules, the rounding of sums (the models
/// of the unit round every sum) and the numbers at its ports, and all features but barycentric coordinates, because it
/// adds those that it needs.
pub fn fixed_parameters() -> impl Iterator<Item = &'static Parameter> {
    let [semantics, microarchitecture, features] = PARAMETER_GROUPS;
    let of_ports = semantics.parameters.iter().chain(microarchitecture.parameters);
    of_ports
        .filter(|parameter| ["rules", "box-bits", "rounding", "format", "io"].contains(&parameter.name))
        .chain(features.parameters.iter().filter(|parameter| !["barycentrics", "edges"].contains(&parameter.name)))
}

/// The datapath of this configuration; with instances, it has the operation that transforms rays too.
fn datapath(config: Config, parameters: UnitParameters) -> Result<DatapathNetlist, UnitError> {
    let mut operations = Operations::of(config)?;
    if parameters.step.features.instances {
        operations = operations.with(&Transform, TRANSFORM_OPCODE)?;
    }
    if parameters.search.0.is_some_and(|search| search.has_trees()) {
        operations = operations.with(&KeyCompare, KEYS_OPCODE)?.with(&PointInBox, BOXES_OPCODE)?;
    }
    Ok(DatapathNetlist::build(operations, config.microarchitecture)?)
}

fn top(datapath: &Arc<Module>, parameters: UnitParameters) -> Result<Arc<Module>, UnitError> {
    let builder = Builder::new("raypath_unit");
    let m = &builder;
    m.doc("A ray goes in, the closest or any hit comes out.");
    m.doc(format!("{parameters}."));
    drawing(parameters.step).for_each(|line| m.doc(line));
    CHANNELS.iter().chain(&OF_MEMORY).for_each(|(prefix, comment)| m.channel(prefix, comment));
    let ports = Ports::new(m, parameters);
    let top = Top { m, parameters, width: bits(parameters.contexts), back: Backwards::new(m, parameters) };

    m.section("Rays");
    let rays = top.rays(&ports)?;

    m.section("Blocks and their jobs");
    let blocks = top.blocks(&ports)?;
    let fetched = top.fetched();
    let issued = top.issued(&fetched);
    let issue = top.issue(&ports, &blocks, &issued)?;
    let decoder = top.decoder(&issue, &blocks, &issued)?;
    let jobs = Jobs { rays, blocks, issue, decoder, fetched };

    let searches = top.searches(&ports)?;
    m.section("The datapath");
    let outcome = top.datapath(datapath, &jobs, searches.as_ref());

    m.section("Distances of triangles");
    let closest = top.distance(&jobs, &outcome)?;

    m.section("Steps");
    let walk = top.walk(&jobs, &outcome, &closest, &ports)?;
    if let Some(is_transform) = outcome.is_transform {
        top.drive_instances(&jobs, &outcome, is_transform, &walk);
    }

    m.section("Requests to the memory, and hits");
    let (request, hits) = (top.requests(&ports, &walk)?, top.hits(&ports, &walk)?);
    let candidates = top.candidates(&ports, &walk)?;
    top.outputs(&ports, &jobs.rays, &request, &hits, candidates.as_ref(), searches.as_ref());
    let Outcome { enters: [boxes, triangles, transforms], waits, .. } = outcome;
    let [steps, fetches, rays, restarts] = ["steps", "fetches", "ends", "restarts"].map(|name| walk.port(name));
    let asks = if parameters.step.features.has_candidates() { walk.port("asks") } else { m.constant(1, 0) };
    let events = [boxes, triangles, transforms, steps, fetches, rays, restarts, waits, asks];
    COUNTS.iter().zip(events).for_each(|(name, event)| m.output(&format!("count_{name}_o"), event));
    Ok(builder.finish()?)
}

/// The drawing of a ray's way. A line begins with the letter of its part, or with the capital where the part is
/// missing.
fn drawing(StepParameters { node, features, .. }: StepParameters) -> impl Iterator<Item = &'static str> {
    let is_there = move |line: &&str| match line.as_bytes().first() {
        Some(b'd') => node != NodeKind::Wide4,
        Some(part @ (b'i' | b'I')) => features.instances == (*part == b'i'),
        Some(part @ (b'c' | b'C')) => features.has_candidates() == (*part == b'c'),
        _ => true,
    };
    include_str!("way.txt").lines().filter(is_there).map(|line| &line[1..])
}

/// The outcome of a job, and which kind it has.
struct Outcome<'m> {
    ports: Outputs<'m>,
    is_boxes: Wire<'m>,
    is_transform: Option<Wire<'m>>,
    /// Whether it is that of a beat.
    is_beat: Option<Wire<'m>>,
    tag: Wire<'m>,
    context: Wire<'m>,
    /// Drives whether the outcome is taken.
    ready: Forward<'m>,
    /// Whether a job of each kind enters, by the order of the counts, and whether one waits.
    enters: [Wire<'m>; 3],
    waits: Wire<'m>,
}

/// The searches of the unit.
struct SearchParts<'m> {
    engine: Outputs<'m>,
    parameters: SearchParameters,
    /// The datapath takes a beat.
    ready: Forward<'m>,
    /// What comes back from the datapath, by name.
    outcome: Vec<(&'static str, Forward<'m>)>,
}

/// The top module while it is built.
struct Top<'m> {
    m: &'m Builder,
    parameters: UnitParameters,
    /// The bits of a context.
    width: u32,
    back: Backwards<'m>,
}

impl<'m> Top<'m> {
    fn rays(&self, ports: &Ports<'m>) -> Result<Outputs<'m>, UnitError> {
        let (back, (job_read, job_context)) = (&self.back, self.back.job());
        let [read, context] = ["candidate_read", "candidate_context"].map(|name| {
            back.candidate.iter().find(|(known, _)| known == name).map(|(_, forward)| named(name, forward.wire()))
        });
        let inputs = Inputs::default()
            .ports(read)
            .ports(context)
            .port("valid", ports.ray_valid)
            .ports(wires("entry", &ports.entry))
            .ports(ports.ray.clone())
            .port("start_taken", back.taken[0].wire())
            .port("release", back.releases.0.wire())
            .port("hit_context", back.releases.1.wire())
            .port("job_read", job_read)
            .port("job_context", job_context)
            .port("limits_read", back.limits.0.wire())
            .port("limits_context", back.limits.1.wire())
            .port("step_read", back.step.0.wire())
            .port("step_context", back.step.1.wire())
            .ports(back.to_rays.iter().map(|(name, forward)| named(name, forward.wire())));
        Ok(inputs.place(self.m, "u_rays", &rays(self.parameters)?))
    }

    fn blocks(&self, ports: &Ports<'m>) -> Result<Outputs<'m>, UnitError> {
        let data = ports.beat.iter().enumerate().map(|(word, wire)| named(&format!("data_{word}"), *wire));
        let back = &self.back;
        let inputs = Inputs::default()
            .port("valid", ports.beat_valid)
            .port("context", ports.beat_context)
            .port("error", ports.beat_error)
            .ports(data)
            .port("job_read", back.take.0.wire())
            .port("job_context", back.take.1.wire())
            .port("child_read", back.step.0.wire())
            .port("child_context", back.step.1.wire())
            .port("index_read", back.limits.0.wire())
            .port("index_context", back.limits.1.wire());
        Ok(inputs.place(self.m, "u_blocks", &blocks(self.parameters)?))
    }

    /// What is kept of a fetch for the jobs of its block: the number of triangles, the ray's extent and, with
    /// instances, whether the block is one and the ray is in one.
    fn fetched(&self) -> Named<'m> {
        let back = &self.back;
        back.fetch.0.wire().comment("what is kept of a fetch is there before its request, and so before its block");
        let mut fetched = vec![named("count", back.fetch_count.wire()), named("extent", back.fetch_extent.wire())];
        let more = back.to_fetched.iter();
        fetched.extend(more.map(|(name, forward)| named(name.trim_start_matches("fetch_"), forward.wire())));
        let by_fetch = (back.fetch.0.wire(), back.fetch.1.wire());
        keep("u_fetched", self.parameters.contexts, by_fetch, fetched, back.job())
    }

    /// What is kept of a fetch for the issue of its jobs, which with a decoder comes before they are in the datapath.
    fn issued(&self, fetched: &Named<'m>) -> Named<'m> {
        let (back, step) = (&self.back, self.parameters.step);
        if !step.has_decoder() {
            return vec![fetched[0].clone()];
        }
        let mut words = vec![named("count", back.fetch_count.wire())];
        words.extend(back.to_fetched.first().map(|(_, forward)| named("is_instance", forward.wire())));
        words.extend(back.fetch_window.map(|window| named("window", window.wire())));
        let (take, context) = back.take;
        let by_fetch = (back.fetch.0.wire(), back.fetch.1.wire());
        keep("u_issued", self.parameters.contexts, by_fetch, words, (take.wire(), context.wire()))
    }

    fn issue(&self, ports: &Ports<'m>, blocks: &Outputs<'m>, issued: &Named<'m>) -> Result<Outputs<'m>, UnitError> {
        let (back, step) = (&self.back, self.parameters.step);
        let inputs = if tells_instances(step) { &issued[..2] } else { &issued[..1] };
        let words = triangle_words(step.node).map(|number| format!("word_{number}"));
        let ready = back.decoder.map_or(back.job_ready, |[.., ready]| ready);
        let issue = Inputs::default()
            .port("arrived", blocks.port("arrived"))
            .port("arrived_failed", blocks.port("failed"))
            .port("arrived_context", ports.beat_context)
            .ports(inputs.iter().cloned())
            .ports(words.map(|word| named(&word, blocks.port(&word))))
            .port("ready", ready.wire())
            .port("fault_taken", back.taken[2].wire())
            .place(self.m, "u_issue", &issue(self.parameters)?);
        back.take.0.drive(issue.port("take"));
        back.take.1.drive(issue.port("take_context"));
        Ok(issue)
    }

    fn decoder(
        &self,
        issue: &Outputs<'m>,
        blocks: &Outputs<'m>,
        issued: &Named<'m>,
    ) -> Result<Option<Outputs<'m>>, UnitError> {
        let Some([decodes, context, ready]) = self.back.decoder else { return Ok(None) };
        let step = self.parameters.step;
        let of_eight: Named<'m> = match step.node {
            NodeKind::Wide8 => {
                let is_node = [named("is_node", issue.port("is_node"))].into_iter();
                is_node
                    .chain(issued[1..].iter().cloned())
                    .chain(prefixed("triangle", issue.under("triangle")))
                    .collect()
            }
            NodeKind::Wide4 | NodeKind::Quantised => Vec::new(),
        };
        let word = |number: usize| {
            let word = format!("word_{number}");
            let is_of_triangle = step.node == NodeKind::Quantised && number < VERTEX_WORDS;
            let wire = if is_of_triangle { issue.port(&format!("triangle_{number}")) } else { blocks.port(&word) };
            (word, wire)
        };
        let decoder = Inputs::default()
            .port("valid", issue.port("offer"))
            .port("context", issue.port("context"))
            .ports(step.of_job().map(|(name, _)| named(name, issue.port(name))))
            .ports(words(step).into_iter().map(word))
            .ports(prefixed("exists", blocks.under("exists")))
            .ports(of_eight)
            .port("ready", self.back.job_ready.wire())
            .place(self.m, "u_decoder", &decoder(self.parameters)?);
        decodes.drive(decoder.port("read"));
        context.drive(decoder.port("read_context"));
        ready.drive(decoder.port("ready"));
        Ok(Some(decoder))
    }

    fn searches(&self, ports: &Ports<'m>) -> Result<Option<SearchParts<'m>>, UnitError> {
        let Some(parameters) = self.parameters.search.0 else { return Ok(None) };
        self.m.section("Searches");
        let engine = search_engine(parameters, self.parameters.search_ports())?;
        let ready = self.m.forward("beat_ready", 1);
        let of_node = [("tested", 1), ("inside", 4), ("child", 6)].into_iter().filter(|_| parameters.has_trees());
        let outcome: Vec<_> = [("valid", 1), ("squares", 32), ("dot", 32), ("norm", 32)]
            .into_iter()
            .chain(of_node)
            .map(|(name, width)| (name, self.m.forward(&format!("outcome_{name}"), width)))
            .collect();
        let engine = Inputs::default()
            .ports(ports.search.iter().cloned())
            .port("beat_ready", ready.wire())
            .ports(outcome.iter().map(|(name, forward)| named(&format!("outcome_{name}"), forward.wire())))
            .place(self.m, "u_search", &engine);
        Ok(Some(SearchParts { engine, parameters, ready, outcome }))
    }

    fn datapath(&self, datapath: &Arc<Module>, jobs: &Jobs<'m>, searches: Option<&SearchParts<'m>>) -> Outcome<'m> {
        let m = self.m;
        datapath.text().package.iter().for_each(|package| m.package(package));
        let opcode = |code: u64, name| m.constant(datapath.port_width("opcode_i").unwrap_or(1), code).hint(name);
        let boxes = opcode(JobKind::Quadbox.opcode(), "OpQuadbox");
        let triangle = opcode(JobKind::Triangle.opcode(), "OpTriangle");
        let transform = || opcode(TRANSFORM_OPCODE, "OpTransform");
        let is_instance = jobs.fetched.get(2).map(|(_, is_instance)| *is_instance);
        let other = is_instance.map_or(triangle, |is_instance| is_instance.mux(transform(), triangle));
        let (offer, is_node) = match &jobs.decoder {
            None => (jobs.issue.port("offer"), jobs.issue.port("is_node")),
            Some(decoder) => (decoder.port("valid"), jobs.fetched[0].1.is(0).named("is_node")),
        };
        let tag = m.concat(&["context", "place", "is_last"].map(|name| jobs.of_block().port(name))).named("job_tag");
        let mut job_opcode = is_node.mux(boxes, other).hint("ray_opcode");
        let ready = m.forward("outcome_ready", 1);
        let takes = m.forward("takes_job", 1);
        let mut beat = Vec::new();
        let mut inputs = jobs.inputs(m, datapath);
        let (mut input_valid, mut takes_ray) = (offer, takes.wire());
        let [euclidean, angular] = [(JobKind::Euclidean, "OpEuclidean"), (JobKind::Angular, "OpAngular")];
        let of_nodes = || [opcode(KEYS_OPCODE, "OpKeys"), opcode(BOXES_OPCODE, "OpBoxes")];
        let of_beats = || [euclidean, angular].map(|(kind, name)| opcode(kind.opcode(), name));
        if let Some(SearchParts { engine, parameters, ready, .. }) = searches {
            let is_beat = whose_turn(m, parameters.turns, [offer, engine.port("beat_valid")], takes.wire());
            let [euclidean, angular] = of_beats();
            input_valid = offer | engine.port("beat_valid");
            let mut of_beat = engine.port("beat_is_angular").mux(angular, euclidean);
            if parameters.has_trees() {
                let [keys, boxes] = of_nodes();
                of_beat = engine.port("beat_is_node").mux(engine.port("beat_is_keys").mux(keys, boxes), of_beat);
                node_inputs(engine, is_beat, &mut inputs);
            }
            job_opcode = is_beat.mux(of_beat, job_opcode);
            ready.drive(takes.wire() & is_beat);
            takes_ray = (takes.wire() & !is_beat).named("takes_ray");
            beat = beat_inputs(engine);
        }
        let ports = Inputs::default()
            .port("input_valid", input_valid)
            .port("output_ready", ready.wire())
            .port("opcode", job_opcode.named("job_opcode"))
            .port("tag", tag)
            .ports(inputs)
            .ports(beat)
            .place(m, "u_datapath", datapath);
        takes.drive(ports.port("input_ready"));
        self.back.job_ready.drive(takes_ray);
        let is_beat = searches.map(|SearchParts { outcome, parameters, .. }| {
            let is = of_beats().map(|code| ports.port("opcode").equals(code));
            let is_beat = (is[0] | is[1]).named("is_beat");
            let sums = ["euclidean_accumulator", "angular_dot_product", "angular_norm"].map(|name| ports.port(name));
            let is_last = ports.port("euclidean_reset_accum") | ports.port("angular_reset_accum");
            let mut back = vec![ports.port("output_valid") & is_beat & is_last];
            back.extend(sums);
            let mut is_of_search = is_beat;
            if parameters.has_trees() {
                let is = of_nodes().map(|code| ports.port("opcode").equals(code));
                let is_node = (is[0] | is[1]).named("is_node_of_tree");
                is_of_search = is_beat | is_node;
                back.extend([ports.port("output_valid") & is_node, ports.port("is_inside"), ports.port("child_index")]);
            }
            outcome.iter().zip(back).for_each(|((_, forward), wire)| forward.drive(wire));
            is_of_search
        });
        let is_boxes = ports.port("opcode").equals(boxes).named("is_boxes");
        let tag = ports.port("tag");
        let context = tag.upper(self.width).named("outcome_context");
        let is_transform = is_instance.map(|_| ports.port("opcode").equals(transform()).named("is_transform"));
        let taken = takes_ray;
        let enters = (offer & taken).named("job_enters");
        let is_other = (enters & !is_node).named("other_enters");
        let [triangles, transforms] = match is_instance {
            None => [is_other, m.constant(1, 0)],
            Some(is_instance) => [is_other & !is_instance, is_other & is_instance],
        };
        let enters = [enters & is_node, triangles, transforms];
        Outcome { ports, is_boxes, is_transform, is_beat, tag, context, ready, enters, waits: offer & !taken }
    }

    fn distance(&self, jobs: &Jobs<'m>, outcome: &Outcome<'m>) -> Result<Outputs<'m>, UnitError> {
        let StepParameters { features, .. } = self.parameters.step;
        let Outcome { ports, is_boxes, is_transform, is_beat, tag, context, ready, .. } = outcome;
        let weights = [("u_num", "barycentric_v"), ("v_num", "barycentric_w")];
        let weights = weights.into_iter().filter(|(name, _)| features.has(name));
        let weights: Named<'m> = weights.map(|(name, port)| named(name, ports.port(port))).collect();
        let place = tag.bits(self.parameters.step.place_bits(), 1);
        let is_other = is_transform.map_or(*is_boxes, |is_transform| *is_boxes | is_transform);
        let is_other = is_beat.map_or(is_other, |is_beat| is_other | is_beat);
        let is_triangle = !is_other;
        let closest = Inputs::default()
            .port("valid", ports.port("output_valid") & is_triangle)
            .port("context", *context)
            .port("place", place)
            .port("is_last", tag.bit(0))
            .port("is_hit", ports.port("triangle_hit"))
            .port("is_front", ports.port("facing"))
            .port("t_num", ports.port("t_num"))
            .port("t_denom", ports.port("t_denom"))
            .ports(weights)
            .ports(prefixed("limits", jobs.rays.under("limits")))
            .ports(prefixed("limits", self.culls()))
            .ports(prefixed("index", jobs.blocks.under("index")))
            .ports(features.has("geometry").then(|| named("geometry", jobs.blocks.port("geometry"))))
            .port("taken", self.back.taken[1].wire())
            .place(self.m, "u_distance", &distance(self.parameters)?);
        self.back.limits.0.drive(closest.port("read"));
        self.back.limits.1.drive(closest.port("read_context"));
        // Outcomes of box jobs wait in a memory.
        let is_taken = closest.port("ready");
        let is_taken = is_transform.map_or(is_taken, |is| is.mux(jobs.rays.port("transformed_ready"), is_taken));
        let is_kept = is_beat.map_or(*is_boxes, |is_beat| *is_boxes | is_beat);
        ready.drive(is_kept | is_taken);
        ready.wire().comment("always of boxes: the memory of their outcomes has a word for each context");
        Ok(closest)
    }

    /// With flags: what is kept of a fetch for the hits of its triangles, namely those that are not hit.
    fn culls(&self) -> Named<'m> {
        let back = &self.back;
        let culls: Named<'m> = back.fetch_culls.iter().map(|(name, forward)| named(name, forward.wire())).collect();
        if culls.is_empty() {
            return culls;
        }
        let (by_fetch, read) =
            ((back.fetch.0.wire(), back.fetch.1.wire()), (back.limits.0.wire(), back.limits.1.wire()));
        let mut kept = keep("u_culls", self.parameters.contexts, by_fetch, culls, read);
        if let Some((_, repeats)) = kept.get_mut(2) {
            let is_set = named("after_is_set", *repeats);
            let write = (back.tested[0].1.wire(), back.tested[1].1.wire());
            let words = back.tested[2..].iter().map(|(name, forward)| named(name, forward.wire())).collect();
            let after = keep("u_after", self.parameters.contexts, write, words, read);
            kept[2] = is_set;
            kept.extend(after);
        }
        kept
    }

    /// With candidates: those that wait for a verdict.
    fn candidates(&self, ports: &Ports<'m>, walk: &Outputs<'m>) -> Result<Option<Outputs<'m>>, UnitError> {
        let Some(ready) = ports.candidate_ready else { return Ok(None) };
        let inputs = Inputs::default()
            .port("is_tested", walk.port("is_tested"))
            .port("tested_context", walk.port("tested_context"))
            .ports(prefixed("tested", self.fields_of(walk, "tested")))
            .port("asks", walk.port("asks"))
            .port("context", walk.port("context"))
            .ports(prefixed("next", self.fields_of(walk, "next")))
            .port("ready", ready);
        let candidates = inputs.place(self.m, "u_candidates", &candidates(self.parameters)?);
        for (name, forward) in &self.back.candidate {
            forward.drive(candidates.port(name.trim_start_matches("candidate_")));
        }
        Ok(Some(candidates))
    }

    /// The outputs of the steps under this stem that candidates show.
    fn fields_of(&self, walk: &Outputs<'m>, stem: &str) -> Named<'m> {
        let is_shown = |name: &str| is_of_candidate(stem, name, self.parameters.step.features);
        walk.under(stem).into_iter().filter(|(name, _)| is_shown(name)).collect()
    }

    fn walk(
        &self,
        jobs: &Jobs<'m>,
        outcome: &Outcome<'m>,
        closest: &Outputs<'m>,
        ports_of_unit: &Ports<'m>,
    ) -> Result<Outputs<'m>, UnitError> {
        let Outcome { ports, is_boxes, context, .. } = outcome;
        let Jobs { rays, blocks, issue, .. } = jobs;
        let back = &self.back;
        // The child at place 0 is never kept; of eight children, those of both jobs are merged.
        let is_merged = self.parameters.step.node == NodeKind::Wide8;
        let first = if is_merged { 0 } else { 1 };
        let tmin = (first..4).map(|k| named(&format!("boxes_tmin_{}", k - first), ports.port(&format!("tmin_{k}"))));
        let of_half = is_merged.then(|| {
            let tag = outcome.tag;
            [named("boxes_is_last", tag.bit(0)), named("boxes_window", tag.bits(2, 1))]
        });
        let walk = Inputs::default()
            .port("boxes_valid", ports.port("output_valid") & *is_boxes)
            .port("boxes_context", *context)
            .port("boxes_hit", ports.port("is_intersect"))
            .ports(tmin)
            .ports(prefixed("boxes_box_index", ports.under("box_index")))
            .ports(of_half.into_iter().flatten())
            .port("block_valid", closest.port("valid"))
            .port("block_context", closest.port("context"))
            .ports(prefixed("closest", closest.under("closest")))
            .port("fault_valid", issue.port("fault_valid"))
            .port("fault_context", issue.port("context"))
            .ports(prefixed("start", rays.under("start")))
            .ports(prefixed("child", blocks.under("child")))
            .ports(prefixed("begin", rays.under("begin")))
            .ports(prefixed("verdict", ports_of_unit.verdict.clone()))
            .port("flush", ports_of_unit.flushes.wire())
            .port("node_limit", ports_of_unit.node_limit)
            .place(self.m, "u_walk", &walk(self.parameters)?);
        for (forward, name) in back.taken.iter().zip(["start", "block", "fault"]) {
            forward.drive(walk.port(&format!("{name}_taken")));
        }
        for (forward, name) in [
            (back.step.0, "read"),
            (back.step.1, "read_context"),
            (back.fetch.0, "fetches"),
            (back.fetch.1, "context"),
            (back.fetch_count, "count"),
            (back.fetch_extent, "next_extent"),
        ] {
            forward.drive(walk.port(name));
        }
        back.fetch_culls.iter().for_each(|(name, forward)| forward.drive(walk.port(name)));
        back.fetch_window.iter().for_each(|forward| forward.drive(walk.port("window")));
        for ((_, forward), name) in
            back.tested.iter().zip(["is_tested", "tested_context", "tested_t", "tested_primitive"])
        {
            forward.drive(walk.port(name));
        }
        Ok(walk)
    }

    /// The outcomes of transforms go to the set-up of rays.
    fn drive_instances(&self, jobs: &Jobs<'m>, outcome: &Outcome<'m>, is_transform: Wire<'m>, walk: &Outputs<'m>) {
        let Outcome { ports, tag, context, .. } = outcome;
        let to_set_up = [ports.port("output_valid") & is_transform, tag.bit(0), *context].into_iter();
        let transformed = ports.under("transformed").into_iter().map(|(_, wire)| wire);
        let wires = [jobs.fetched[3].1].into_iter().chain(to_set_up).chain(transformed);
        self.back.to_rays.iter().zip(wires).for_each(|((_, forward), wire)| forward.drive(wire));
        let wires = [walk.port("is_instance"), walk.port("is_inside")];
        self.back.to_fetched.iter().zip(wires).for_each(|((_, forward), wire)| forward.drive(wire));
    }

    fn requests(&self, ports: &Ports<'m>, walk: &Outputs<'m>) -> Result<Outputs<'m>, UnitError> {
        let UnitParameters { contexts, address_width, step, .. } = self.parameters;
        let columns = [("context", self.width), ("block", address_width - step.node.offset_bits())];
        let inputs = Inputs::default()
            .port("push", walk.port("fetches"))
            .port("context", walk.port("context"))
            .port("block", walk.port("block"))
            .port("pop", ports.request_ready);
        Ok(inputs.place(self.m, "u_requests", &queue("raypath_unit_requests", contexts, &columns)?))
    }

    fn hits(&self, ports: &Ports<'m>, walk: &Outputs<'m>) -> Result<Outputs<'m>, UnitError> {
        let hits = Inputs::default()
            .port("ends", walk.port("ends"))
            .port("context", walk.port("context"))
            .port("status", walk.port("status"))
            .ports(prefixed("next", walk.under("next").into_iter().filter(|(name, _)| is_of_hit(name)).collect()))
            .port("ready", ports.hit_ready)
            .place(self.m, "u_hits", &hits(self.parameters)?);
        self.back.releases.0.drive(hits.port("release"));
        self.back.releases.1.drive(hits.port("context"));
        Ok(hits)
    }

    /// The outputs of the unit, by channel.
    fn outputs(
        &self,
        ports: &Ports<'m>,
        rays: &Outputs<'m>,
        request: &Outputs<'m>,
        hits: &Outputs<'m>,
        candidates: Option<&Outputs<'m>>,
        searches: Option<&SearchParts<'m>>,
    ) {
        let (m, StepParameters { features, node, .. }) = (self.m, self.parameters.step);
        let (flushes, has_hit) = (ports.flushes.wire(), hits.port("valid"));
        let idle = (rays.port("is_idle") & !has_hit).named("idle");
        ports.flushes.next(ports.flush | (flushes & !idle));
        m.output("idle_o", idle);
        m.output("busy_o", !idle);
        m.output("ray_ready_o", rays.port("ready") & !flushes);
        m.output("hit_valid_o", has_hit & !flushes);
        m.output("hit_id_o", rays.port("id"));
        let UnitFeatures { barycentrics, instances, .. } = features;
        let optional = [
            ("u", barycentrics),
            ("v", barycentrics),
            ("instance", instances),
            ("geometry", features.has_flags()),
            ("custom_index", instances && features.has_flags()),
            ("shader_offset", instances && features.has_flags()),
        ];
        let optional = optional.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name);
        let always = ["status", "t", "primitive", "t_num", "t_denom", "back_face", "nodes", "triangles"];
        always.into_iter().chain(optional).for_each(|name| m.output(&format!("hit_{name}_o"), hits.port(name)));
        if let Some(candidates) = candidates {
            let shown = ["valid", "tag"].map(|name| candidates.port(name));
            ports.candidate.iter().flatten().zip(shown).for_each(|(forward, wire)| forward.drive(wire));
            m.output("cand_valid_o", shown[0] & !flushes);
            m.output("cand_tag_o", shown[1]);
            let shown = rays.under("candidate").into_iter().chain(candidates.under("cand"));
            shown.into_iter().for_each(|(name, wire)| m.output(&format!("cand_{name}_o"), wire));
            m.output("answer_ready_o", m.constant(1, 1));
        }
        m.output("mem_req_valid_o", request.port("valid"));
        m.output("mem_req_addr_o", m.concat(&[request.port("block"), m.constant(node.offset_bits(), 0)]));
        m.output("mem_req_tag_o", request.port("context"));
        m.output("mem_rsp_ready_o", m.constant(1, 1));
        if let Some(SearchParts { engine, .. }) = searches {
            m.output("searches_idle_o", engine.port("is_idle"));
            m.output("search_ready_o", engine.port("search_ready"));
            for stem in ["result", "vec_req"] {
                engine.under(stem).into_iter().for_each(|(name, wire)| m.output(&format!("{stem}_{name}_o"), wire));
            }
            m.output("vec_rsp_ready_o", m.constant(1, 1));
        }
    }
}
