//! The rays: their contexts, their set-up, and what is kept of them.

use super::connect::{Inputs, Named, delay, keep, keep_of_step, named, prefixed};
use super::contexts::contexts;
use super::entries::entries;
use super::package::refer_to_package;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use super::set_up::set_up;
use crate::netlist::{Netlist, Value, inputs, wires, wires_with};
use crate::query::{RayFlags, ray_flags};
use crate::set_up::Entry;
use crate::state::RayWords;
use crate::step::StepParameters;
use raypath_hdl::{Builder, Error, Module};
use raypath_ops::{Vec3, Word};
use std::sync::Arc;

/// The module `raypath_unit_rays`.
///
/// A ray enters where `valid_i` and `ready_o` are 1: `entry_…_i`, `id_i`, `flags_i`, `cull_mask_i`, `root_i` and, with
/// addresses of more than 32 bits, `base_i`. When its constants are known, `start_valid_o` is 1 with `start_context_o`
/// and `start_is_refused_o`, until `start_taken_i` is 1. `release_i` frees the context `hit_context_i`, whose `id_o` is
/// read at the same time. `is_idle_o` is 1 if no context has a ray.
///
/// Readers give an enable and a context, and have their words in the next cycle, a step after the latency of its
/// memories: `job_read_i` for `job_…_o`,
/// `limits_read_i` for `limits_…_o`, `step_read_i` for `begin_…_o`, and with candidates `candidate_read_i` for
/// `candidate_…_o`.
///
/// With instances, the outcomes of transforms, `transformed_…_i`, enter the set-up as `raypath_unit_entries` says, and
/// `start_is_instance_o` says that a ray does not begin but enters an instance. `job_…_o` has the constants in its
/// space if `job_inside_i` is 1; `job_dir_…_o` is the direction outside, with nested instances or candidates that in its
/// space too.
pub fn rays(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts: count, id_width, divider_latency, step, .. } = parameters;
    let StepParameters { features, front, .. } = step;
    let builder = Builder::new("raypath_unit_rays");
    let m = &builder;
    m.doc("The contexts of rays, the set-up of rays, and what is kept of them.");
    refer_to_package(m, features);
    let width = bits(count);
    let valid = m.input("valid_i", 1);
    let entry: Entry<Netlist<'_>> = inputs(m, "entry");
    let id = m.input("id_i", id_width);
    let flags_word = m.input("flags_i", 10);
    let has_mask = features.has("cull_mask");
    let cull_mask = if has_mask { m.input("cull_mask_i", 8) } else { m.constant(8, 0) };
    let root = m.input("root_i", 32);
    let base_bits = parameters.base_bits();
    let base = (base_bits > 0).then(|| named("base", m.input("base_i", base_bits)));
    let start_taken = m.input("start_taken_i", 1);
    let reader = |name: &str| {
        let [enable, context] =
            [("read", 1), ("context", width)].map(|(port, w)| m.input(&format!("{name}_{port}_i"), w));
        (enable, context)
    };
    let release = (m.input("release_i", 1), m.input("hit_context_i", width));
    let [job, limits_reader, step] = ["job", "limits", "step"].map(reader);

    m.section("A ray enters a free context");
    let c = Netlist(m);
    let flags_word: Word<Netlist<'_>, 10> = Word::new(c, Value(flags_word));
    let flags = RayFlags::of(flags_word);
    let unused = ray_flags::CODES.bit(flags_word, ray_flags::SKIP_CLOSEST_HIT_SHADER);
    m.unused("unused_flag", &[unused.value.0]);
    let enters = m.forward("enters", 1);
    let free = Inputs::default()
        .port("take", enters.wire())
        .port("release", release.0)
        .port("released", release.1)
        .place(m, "u_contexts", &contexts(count)?);
    let context = free.port("context");
    let entering = Inputs::default()
        .port("valid", valid & free.port("valid"))
        .ports(wires("entry", &entry))
        .port("is_meaningless", flags.are_meaningless().value.0.named("is_meaningless"))
        .port("context", context);
    // The transform of a nested instance begins with the direction in the instance around it, and candidates show it.
    let has_directions = features.nested || features.has_candidates();
    let constants = if features.instances {
        let [is_transformed, is_last] = ["valid", "is_last"].map(|name| m.input(&format!("transformed_{name}_i"), 1));
        let transformed: Vec3<Netlist<'_>> = inputs(m, "transformed");
        entering
            .port("free", free.port("valid"))
            .port("transformed_valid", is_transformed)
            .port("transformed_is_last", is_last)
            .port("transformed_context", m.input("transformed_context_i", width))
            .ports(wires("transformed", &transformed))
            .place(m, "u_entries", &entries(count, divider_latency, has_directions)?)
    } else {
        entering.place(m, "u_set_up", &set_up(count, divider_latency)?)
    };
    let ready = (constants.port("ready") & free.port("valid")).named("ready");
    enters.drive(valid & ready);

    m.section("What is kept of it, by reader");
    let words = RayWords {
        root: Word::new(c, Value(root)),
        t_min: entry.t_min,
        t_max: entry.t_max,
        any_hit: ray_flags::CODES.bit(flags_word, ray_flags::TERMINATE_ON_FIRST_HIT),
        flags,
        cull_mask: Word::new(c, Value(cull_mask)),
    };
    // A step asks for an address, of which the base is a part.
    let begin: Named<'_> = wires_with("", &words, parameters.step).chain(base).collect();
    let mut limits = vec![named("limits_t_min", entry.t_min.value.0)];
    if !features.has_flags() {
        // With flags, it depends on the instance and the leaf which faces are not hit.
        limits.extend(wires("limits_culls", &flags.culls_of_opaque(c, front)));
    }
    let at_entry = (enters.wire(), context);
    let candidate = features.has_candidates().then(|| reader("candidate"));
    let candidate_id =
        candidate.map(|reader| keep("u_candidate_ids", count, at_entry, vec![named("candidate_id", id)], reader));
    let id = keep("u_ids", count, at_entry, vec![named("id", id)], release);
    let origin = keep("u_origins", count, at_entry, wires("origin", &entry.origin), job);
    let limits = keep("u_limits", count, at_entry, limits, limits_reader);
    let (begin, begin_error) = keep_of_step(parameters, "u_begins", count, at_entry, begin, step);
    let is_known = constants.port("valid");
    let known = constants.port("context");
    let derived: Named<'_> = CONSTANTS.iter().map(|name| named(name, constants.port(name))).collect();
    let of_job: Named<'_> = if features.instances {
        let is_instance = constants.port("is_instance");
        let outside = keep("u_constants", count, (is_known & !is_instance, known), derived.clone(), job);
        let inside = keep("u_object_constants", count, (is_known & is_instance, known), derived, job);
        let at_instance = (constants.port("enters_instance"), constants.port("origin_context"));
        let object_origin = keep("u_object_origins", count, at_instance, constants.under("object"), job);
        let is_inside = m.input("job_inside_i", 1);
        let mut pairs: Vec<_> =
            origin.into_iter().chain(outside).zip(object_origin.into_iter().chain(inside)).collect();
        let direction = keep("u_directions", count, at_entry, wires("dir", &entry.dir), job);
        if has_directions {
            let object = keep("u_object_directions", count, at_instance, constants.under("direction"), job);
            pairs.extend(direction.into_iter().zip(object));
        } else {
            pairs.extend(direction.iter().cloned().zip(direction.iter().cloned()));
        }
        let pairs = pairs.into_iter();
        let chosen = pairs.map(|((name, outside), (_, inside))| (name, is_inside.mux(inside, outside)));
        chosen.collect()
    } else {
        origin.into_iter().chain(keep("u_constants", count, (is_known, known), derived, job)).collect()
    };
    // A candidate was tested by the last job of its ray, whose words are kept, because the port of jobs is not free to
    // read them again. They stay: before its verdict, a ray has no further job.
    let candidate_ray = candidate.map(|reader| {
        let (write, words) = if features.instances {
            let is_read = m.register("job_is_read_q", 1).reset_to(0);
            is_read.next(job.0);
            let is_of_ray = |name: &str| name.starts_with("origin_") || name.starts_with("dir_");
            let words = of_job.iter().filter(|(name, _)| is_of_ray(name)).cloned().collect();
            ((is_read.wire(), delay("job_context_q", job.1)), words)
        } else {
            (at_entry, [wires("origin", &entry.origin), wires("dir", &entry.dir)].concat())
        };
        prefixed("candidate", keep("u_candidate_rays", count, write, words, reader))
    });

    m.section("Rays that begin");
    let columns = [("context", width), ("is_refused", 1), ("is_instance", 1)];
    let columns = if features.instances { &columns[..] } else { &columns[..2] };
    let start = Inputs::default()
        .port("push", is_known)
        .ports(columns.iter().map(|(name, _)| named(name, constants.port(name))))
        .port("pop", start_taken)
        .place(m, "u_starts", &queue("raypath_unit_starts", count, columns)?);

    m.output("ready_o", ready);
    m.output("is_idle_o", free.port("is_idle"));
    for name in ["valid"].into_iter().chain(columns.iter().map(|(name, _)| *name)) {
        m.output(&format!("start_{name}_o"), start.port(name));
    }
    if features.instances {
        m.output("transformed_ready_o", constants.port("transformed_ready"));
    }
    let output = |name: &str, wire| m.output(&format!("{name}_o"), wire);
    id.iter()
        .chain(&limits)
        .chain(candidate_id.iter().chain(&candidate_ray).flatten())
        .for_each(|(name, wire)| output(name, *wire));
    of_job.into_iter().for_each(|(name, wire)| output(&format!("job_{name}"), wire));
    begin.iter().for_each(|(name, wire)| output(&format!("begin_{name}"), *wire));
    begin_error.into_iter().for_each(|error| m.output("begin_error_o", error));
    builder.finish()
}

/// The constants of a ray, which are fields of the datapath's ray.
pub const CONSTANTS: [&str; 9] = ["inv_x", "inv_y", "inv_z", "shear_x", "shear_y", "shear_z", "kx", "ky", "kz"];
