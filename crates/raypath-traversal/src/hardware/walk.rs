//! The steps of rays: one in each cycle, in three stages.
//!
//! In the first stage an answer is chosen, and the state of its ray is read. In the second the step is prepared, and
//! the stack is read. In the third the step is finished, and everything is written. A ray has at most one answer at a
//! time, so steps of the same ray do not overlap. The registers between the stages take a value in every cycle: what
//! they have without a step is not used. Where a read of a memory takes two cycles, there are two registers in place of
//! one.

use super::candidates::is_of_candidate;
use super::connect::{Access, Inputs, Named, Outputs, delay, delay_by, hold, keep_of_step, named, parity, prefixed};
use super::hits::is_shown;
use super::package::refer_to_package;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use super::scheduler::{scheduler, sources};
use super::step::{finish_module, prepare_module, window_module};
use crate::blocks::NodeKind;
use crate::netlist::{Netlist, inputs_with, wires_with};
use crate::state::{Group, RayState, RayWords, answer, request, status};
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::{Binary32, ports_of};
use std::sync::Arc;

/// The module `raypath_unit_walk`.
///
/// The outcome of a box job, `boxes_…_i`, enters where `boxes_valid_i` is 1, with `boxes_context_i`, and waits in a
/// memory. The other sources of answers have `<source>_valid_i` and `<source>_context_i`, and `<source>_taken_o` where
/// their answer is taken: `block` with `closest_…_i`, `fault`, and `start` with `start_is_refused_i` and, with
/// instances, `start_is_instance_i`. Where `read_o` is 1, the child words and the ray of `read_context_o` are read,
/// which are there after the latency of the memories of a step: `child_…_i`, `begin_…_i`.
///
/// A step ends with `fetches_o` or `ends_o`, or neither if the ray continues, and `context_o`; with `ends_o` in any
/// case if `flush_i` is 1. To fetch: `block_o`, the address without its offset, `count_o` and, with instances,
/// `is_instance_o` and `is_inside_o`. At the end: `status_o` and what a hit shows of the state, `next_…_o`.
pub fn walk(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts: count, step, ram_latency: latency, parity: has_parity, .. } = parameters;
    let base_bits = parameters.base_bits();
    let builder = Builder::new("raypath_unit_walk");
    let m = &builder;
    m.doc("The steps of rays: one in each cycle, in three stages.");
    m.doc(
        "A ray has one answer at a time, so that no stage needs what a later one has not written yet: there is no \
           bypass. The stages never wait: the queues behind them have a word for each context.",
    );
    refer_to_package(m, step.features);
    let width = bits(count);
    let (flush, node_limit) = (m.input("flush_i", 1), m.input("node_limit_i", 32));
    let given = |name: &str| {
        let valid = m.input(&format!("{name}_valid_i"), 1);
        (valid, m.input(&format!("{name}_context_i"), width))
    };
    let [tested, block, fault, start] = ["boxes", "block", "fault", "start"].map(given);
    let inputs = |names: &[(&str, u32)]| -> Named<'_> {
        names.iter().map(|(name, width)| (name.to_string(), m.input(&format!("{name}_i"), *width))).collect()
    };
    let is_refused = m.input("start_is_refused_i", 1);
    let is_instance = step.features.instances.then(|| m.input("start_is_instance_i", 1));
    let has_eight = step.node == NodeKind::Wide8;
    let boxes = inputs(if has_eight { &HALF } else { &BOXES });
    let closest: Vec<_> = CLOSEST.into_iter().filter(|(name, _)| step.has(name)).collect();
    let closest = inputs(&closest);
    let children = inputs(&[("child_0", 32), ("child_1", 32), ("child_2", 32), ("child_3", 32)]);
    let begin: RayWords<Netlist<'_>> = inputs_with(m, "begin", step);
    let base = (base_bits > 0).then(|| m.input("begin_base_i", base_bits));
    let errors = has_parity.then(|| ["child_error_i", "begin_error_i"].map(|name| m.input(name, 1)));
    let verdict = step.features.has_candidates().then(|| {
        let (valid, context) = given("verdict");
        (valid, context, inputs(&[("verdict_accepts", 1), ("verdict_ends", 1), ("verdict_t", 32)]))
    });

    m.section("The answer that is taken, and the state of its ray");
    let again_taken = m.forward("again_taken", 1);
    let again_asked = m.forward("again_asked", 1);
    let context = m.forward("asked_context", width);
    let again = Inputs::default()
        .port("push", again_asked.wire())
        .port("context", context.wire())
        .port("pop", again_taken.wire())
        .place(m, "u_continues", &queue("raypath_unit_continues", count, &[("context", width)])?);
    let boxes_taken = m.forward("boxes_taken", 1);
    let (boxes, outcome, tested) = if has_eight { merged(m, boxes, tested)? } else { (boxes, tested, tested) };
    let waiting = Inputs::default()
        .port("push", tested.0)
        .port("context", tested.1)
        .port("pop", boxes_taken.wire())
        .place(m, "u_tested", &queue("raypath_unit_tested", count, &[("context", width)])?);
    let verdict_taken = verdict.as_ref().map(|_| m.forward("verdict_taken", 1));
    let verdicts = match (&verdict, &verdict_taken) {
        (Some((valid, context, _)), Some(taken)) => {
            let columns = [("context", width)];
            Some(Inputs::default().port("push", *valid).port("context", *context).port("pop", taken.wire()).place(
                m,
                "u_decided",
                &queue("raypath_unit_decided", count, &columns)?,
            ))
        }
        _ => None,
    };
    // In the order of the scheduler's sources.
    let offered: Vec<(Wire<'_>, Wire<'_>)> = [queued(&waiting), block, fault, start, queued(&again)]
        .into_iter()
        .chain(verdicts.iter().map(queued))
        .collect();
    let requests: Vec<Wire<'_>> = offered.iter().rev().map(|(valid, _)| *valid).collect();
    let scheduler =
        Inputs::default().port("request", m.concat(&requests)).place(m, "u_scheduler", &scheduler(step.features)?);
    let grant = scheduler.port("grant");
    let names = sources(step.features);
    let taken = |source: &str| grant.bit(names.iter().position(|known| *known == source).unwrap_or(0) as u32);
    again_taken.drive(taken("continue"));
    boxes_taken.drive(taken("boxes"));
    verdict_taken.iter().for_each(|forward| forward.drive(taken("verdict")));
    let read = grant.any().named("read");
    let read_context = granted(grant, offered.iter().map(|(_, context)| *context)).named("read_context");
    let constant = |kind: u32| answer::CODES.word::<_, 4>(Netlist(m), kind).value.0;
    let either = |refused: u32, ready: u32| is_refused.mux(constant(refused), constant(ready));
    let start_kind = either(answer::REFUSED, answer::START);
    let entering = either(answer::CANNOT_ENTER, answer::ENTER);
    let start_kind = is_instance.map_or(start_kind, |is| is.mux(entering, start_kind).hint("start_kind"));
    let kinds = [answer::BOXES, answer::BLOCK, answer::ERROR].map(constant).into_iter();
    let kinds =
        kinds.chain([start_kind, constant(answer::CONTINUE)]).chain(verdicts.iter().map(|_| constant(answer::VERDICT)));
    let of_source = (0..).zip(kinds).map(|(bit, kind)| grant.bit(bit).mux(kind, m.constant(4, 0)));
    let kind = of_source.reduce(|a, b| (a | b).hint("granted_kind")).unwrap_or(grant);
    let prepares = delay_by(latency, "prepares_q", read, Some(0));
    let prepared_context = delay_by(latency, "prepared_context_q", read_context, None);
    let kind = delay_by(latency, "kind_q", kind, None);
    let at_read = (read, read_context);
    let (boxes, boxes_error) = keep_of_step(parameters, "u_outcomes", count, outcome, boxes, at_read);
    let mut closest = delay_all(latency, closest);
    let decided = verdict
        .map(|(valid, context, words)| keep_of_step(parameters, "u_verdicts", count, (valid, context), words, at_read));

    m.section("The step is prepared, and the stack is read");
    let finishes = delay_by(latency, "finishes_q", prepares, Some(0));
    let finished_context = delay_by(latency, "finished_context_q", prepared_context, None);
    context.drive(finished_context);
    let base = base.map(|base| delay_by(latency, "base_q", base, None));
    let fields = ports_of::<RayState<Binary32>>();
    let fields = fields.iter().filter(|port| step.has(&port.name) && !is_of_ray(&port.name));
    let columns = fields.map(|port| (port.name.as_str(), port.width.unwrap_or(32)));
    let parity_column = has_parity.then_some(("parity", 1));
    let columns: Vec<(&str, u32)> = columns.chain(parity_column).collect();
    let states = m.memory("u_states", count, &columns).latency(latency);
    let kept: Vec<Wire<'_>> = states.read(read, read_context);
    let state_error = has_parity.then(|| parity(&kept));
    let kept: Vec<(&str, Wire<'_>)> = columns.iter().map(|(name, _)| *name).zip(kept).collect();
    let c = Netlist(m);
    let first = RayState::begin(c, begin);
    let is = |known: u32| kind.equals(constant(known));
    let begins = (is(answer::START) | is(answer::REFUSED)).named("begins");
    begins.comment("the memory has the state of an earlier ray, or was never written");
    let state = wires_with("", &first, step).map(|(name, first)| {
        let value = match kept.iter().find(|(known, _)| *known == name) {
            None => first,
            Some((_, kept)) if AT_FIRST.contains(&name.as_str()) => begins.mux(first, *kept),
            Some((_, kept)) => *kept,
        };
        (name, value)
    });
    let state: Named<'_> = state.collect();
    let tested = closest.clone();
    let mut verdict_words: Named<'_> = Vec::new();
    let mut is_tested = None;
    let mut error = errors.zip(boxes_error).zip(state_error).map(|(([child, begin], boxes), state)| {
        let reads_child = is(answer::BOXES) | is(answer::ENTER) | is(answer::CANNOT_ENTER);
        begin | (child & reads_child) | (boxes & is(answer::BOXES)) | (state & !begins)
    });
    if let Some((decided, decided_error)) = decided {
        let is_block = (prepares & is(answer::BLOCK)).named("is_tested");
        // A verdict comes with its candidate, which was the closest hit of the block; a box has the distance of the
        // user.
        let written = (is_block, prepared_context);
        let (kept, kept_error) = keep_of_step(parameters, "u_candidates", count, written, closest.clone(), at_read);
        let is_verdict = is(answer::VERDICT).named("is_verdict");
        let of_verdict = decided_error.zip(kept_error).map(|(decided, kept)| is_verdict & (decided | kept));
        error = error.zip(of_verdict).map(|(error, of_verdict)| error | of_verdict);
        let is_box = state.iter().find(|(name, _)| name == "leaf_is_box").map_or(is_verdict, |(_, wire)| *wire);
        let chosen = closest.iter().zip(kept).map(|((name, now), (_, kept))| {
            let kept = if name == "closest_t" { is_box.mux(decided[2].1, kept) } else { kept };
            (name.clone(), is_verdict.mux(kept, *now))
        });
        closest = chosen.collect();
        is_tested = Some(is_block);
        verdict_words = decided[..2].to_vec();
    }
    let state = prefixed("state", state);
    let kind = error.map_or(kind, |error| error.named("reads_error").mux(constant(answer::ERROR), kind));
    let answer_words = [("kind".to_string(), kind)].into_iter();
    let answer_words = answer_words
        .chain(boxes.into_iter().map(|(name, wire)| (name.trim_start_matches("boxes_").to_string(), wire)))
        .chain(children)
        .chain(closest)
        .chain(verdict_words);
    let half = Inputs::default()
        .ports(state)
        .ports(prefixed("answer", answer_words.collect()))
        .port("node_limit", node_limit)
        .place(m, "u_prepare", &prepare_module(step)?);
    let slot_bits = step.stack.trailing_zeros();
    let slot = |context: Wire<'_>, level: Wire<'_>| m.concat(&[context, level.lower(slot_bits)]);
    let deepest = half.port("half_deepest");
    let half = delay_all(latency, prefixed("half", half.under("half")));
    let in_half = |field: &str| half.iter().find(|(name, _)| name == field).map(|(_, wire)| *wire);
    let [pops, is_empty, is_on_stack, was_restarting] =
        ["pops", "is_empty", "is_on_stack", "state_restarting"].map(|name| in_half(&format!("half_{name}")));

    m.section("The step is finished, and everything is written");
    let top_columns = ports_of::<Group<Binary32>>();
    let columns = top_columns.iter().map(|port| (port.name.as_str(), port.width.unwrap_or(32)));
    let columns: Vec<(&str, u32)> = columns.chain(parity_column).collect();
    let stack = m.memory("u_stack", count * step.stack, &columns).latency(latency);
    let top = stack.read(prepares, slot(prepared_context, deepest));
    let reads_stack = pops.zip(is_empty).zip(is_on_stack).map(|((pops, is_empty), is_on)| pops & !is_empty & is_on);
    let stack_error = reads_stack.filter(|_| has_parity).map(|reads| (reads & parity(&top)).named("stack_error"));
    let top = top_columns.iter().map(|port| format!("top_{}", port.name)).zip(top);
    let done = Inputs::default().ports(half).ports(top).place(m, "u_finish", &finish_module(step)?);
    let next = done.under("next");
    let restarts = next.iter().find(|(name, _)| name == "restarting").map(|(_, wire)| *wire);
    let restarts = restarts.zip(was_restarting).map_or(finishes, |(is, was)| finishes & is & !was);
    let with_parity = |mut words: Vec<_>| {
        words.extend(has_parity.then(|| parity(&words)));
        words
    };
    let changed = next.iter().filter(|(name, _)| !is_of_ray(name));
    states.write(finishes, finished_context, &with_parity(changed.map(|(_, wire)| *wire).collect()));
    let group = with_parity(done.under("request_group").into_iter().map(|(_, wire)| wire).collect());
    stack.write(finishes & done.port("request_writes"), slot(finished_context, done.port("request_level")), &group);
    let or_done =
        |kind| stack_error.map_or(kind, |error| error.mux(request::CODES.word::<_, 2>(c, request::DONE).value.0, kind));
    let kind = or_done(done.port("request_kind"));
    let goes_on = (finishes & !flush).named("goes_on");
    let is_asked = |asked: u32| kind.equals(request::CODES.word::<_, 2>(c, asked).value.0);
    let asks = |asked: u32| goes_on & is_asked(asked);
    again_asked.drive(asks(request::CONTINUE));

    for source in ["block", "fault", "start"] {
        m.output(&format!("{source}_taken_o"), taken(source));
    }
    m.output("read_o", read);
    m.output("read_context_o", read_context);
    m.output("fetches_o", asks(request::FETCH));
    m.output("ends_o", finishes & (flush | is_asked(request::DONE)));
    m.output("context_o", finished_context);
    m.output("steps_o", finishes);
    m.output("restarts_o", restarts);
    if let Some(is_tested) = is_tested {
        m.output("asks_o", asks(request::CANDIDATE));
        m.output("repeats_o", done.port("request_repeats"));
        m.output("is_tested_o", is_tested);
        m.output("tested_context_o", prepared_context);
        tested.iter().filter(|(name, _)| name != "closest_is_hit" && name != "closest_has_more").for_each(
            |(name, wire)| {
                m.output(&format!("tested_{}_o", name.trim_start_matches("closest_")), *wire);
            },
        );
    }
    let (address, level) = (done.port("request_address"), done.port("request_level"));
    m.unused("unused_offset", &[address.lower(step.node.offset_bits())]);
    m.unused("unused_level", &[level.upper(level.width() - slot_bits)]);
    let block = address.upper(address.width() - step.node.offset_bits());
    m.output("block_o", base.map_or(block, |base| m.concat(&[base, block])));
    for name in ["count", "window", "status", "is_instance", "culls_clockwise", "culls_counter_clockwise"]
        .into_iter()
        .filter(|name| step.has(name))
    {
        let wire = done.port(&format!("request_{name}"));
        let failed = stack_error.filter(|_| name == "status");
        let memory = status::CODES.word::<_, 3>(c, status::MEMORY).value.0;
        m.output(&format!("{name}_o"), failed.map_or(wire, |error| error.mux(memory, wire)));
    }
    let is_inside = next.iter().filter(|(name, _)| name == "inside");
    is_inside.for_each(|(_, wire)| m.output("is_inside_o", *wire));
    let of_candidates = |name: &str| step.features.has_candidates() && is_of_candidate("next", name, step.features);
    let shown = next.into_iter().filter(|(name, _)| is_shown(name) || of_candidates(name));
    shown.for_each(|(name, wire)| m.output(&format!("next_{name}_o"), wire));
    builder.finish()
}

/// The children of a window, from the outcomes of both jobs of a node; where they are written, in the cycle after the
/// last outcome; and where the node is tested.
fn merged<'m>(
    m: &'m Builder,
    mut half: Named<'m>,
    (valid, context): Access<'m>,
) -> Result<(Named<'m>, Access<'m>, Access<'m>), Error> {
    let window = half.pop().map_or(context, |(_, wire)| wire);
    let is_last = half.pop().map_or(valid, |(_, wire)| wire);
    let completes = (valid & is_last).named("boxes_complete");
    let held = |name: &str, enable: Wire<'m>| -> Named<'m> {
        let hold = |(field, wire): &(String, Wire<'m>)| {
            let field = format!("{name}_{}", field.trim_start_matches("boxes_"));
            (field.clone(), hold(&format!("{field}_q"), enable, *wire))
        };
        half.iter().map(hold).collect()
    };
    let window = hold("window_q", completes, window);
    let outcome = Inputs::default()
        .ports(held("lower", valid & !is_last))
        .ports(held("upper", completes))
        .port("window", window)
        .place(m, "u_window", &window_module()?);
    let mut boxes = prefixed("boxes", outcome.under("window"));
    boxes.push(named("boxes_window", window));
    let written = m.register("written_q", 1).reset_to(0);
    written.next(completes);
    Ok((boxes, (written.wire(), delay("written_context_q", context)), (completes, context)))
}

fn queued<'m>(queue: &Outputs<'m>) -> (Wire<'m>, Wire<'m>) {
    (queue.port("valid"), queue.port("context"))
}

/// The value of the source that is granted.
fn granted<'m>(grant: Wire<'m>, values: impl Iterator<Item = Wire<'m>>) -> Wire<'m> {
    let gated = (0..).zip(values).map(|(bit, wire)| wire & grant.bit(bit).replicate(wire.width()));
    gated.reduce(|a, b| (a | b).hint("granted_context")).unwrap_or(grant)
}

fn delay_all(latency: u32, words: Named<'_>) -> Named<'_> {
    let delayed = |(name, wire): (String, _)| (name.clone(), delay_by(latency, &format!("{name}_q"), wire, None));
    words.into_iter().map(delayed).collect()
}

/// Whether this field of a ray's state stays as the ray has it, and is kept with the ray.
fn is_of_ray(field: &str) -> bool {
    ["any_hit", "root", "cull_mask", "t_min"].contains(&field) || field.starts_with("flags_")
}

/// The other fields that a ray has at its beginning. The rest of its state is written before it is read.
const AT_FIRST: [&str; 8] =
    ["extent", "has_hit", "nodes", "triangles", "pending_low", "pending_high", "base", "restarting"];

/// The outcome of a job of a node with eight children.
const HALF: [(&str, u32); 11] = [
    ("boxes_hit", 4),
    ("boxes_tmin_0", 32),
    ("boxes_tmin_1", 32),
    ("boxes_tmin_2", 32),
    ("boxes_tmin_3", 32),
    ("boxes_box_index_0", 2),
    ("boxes_box_index_1", 2),
    ("boxes_box_index_2", 2),
    ("boxes_box_index_3", 2),
    ("boxes_is_last", 1),
    ("boxes_window", 2),
];

/// The outcome of a box job.
const BOXES: [(&str, u32); 8] = [
    ("boxes_hit", 4),
    ("boxes_tmin_0", 32),
    ("boxes_tmin_1", 32),
    ("boxes_tmin_2", 32),
    ("boxes_box_index_0", 2),
    ("boxes_box_index_1", 2),
    ("boxes_box_index_2", 2),
    ("boxes_box_index_3", 2),
];

/// The closest hit of a block.
const CLOSEST: [(&str, u32); 10] = [
    ("closest_is_hit", 1),
    ("closest_has_more", 1),
    ("closest_t", 32),
    ("closest_t_num", 32),
    ("closest_t_denom", 32),
    ("closest_u_num", 32),
    ("closest_v_num", 32),
    ("closest_is_clockwise", 1),
    ("closest_primitive", 32),
    ("closest_geometry", 32),
];
