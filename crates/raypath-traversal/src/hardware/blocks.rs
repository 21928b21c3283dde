//! The blocks that the memory returns.

use super::connect::{Inputs, parity};
use super::issue::triangle_words;
use super::parameters::UnitParameters;
use super::queue::bits;
use super::registers::registers;
use crate::blocks::NodeKind;
use crate::step::StepParameters;
use raypath_hdl::text::PortGroup;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The words of a block that its jobs need, in order: those of triangles or, at the same places, boxes, and those of a
/// matrix.
pub fn job_words(step: StepParameters) -> Vec<usize> {
    let words: BTreeSet<usize> = triangle_words(step.node).chain(matrix_words(step)).collect();
    words.into_iter().collect()
}

/// Those of a matrix, which a block has with instances.
pub fn matrix_words(StepParameters { node, features, .. }: StepParameters) -> impl Iterator<Item = usize> {
    (0..if features.instances { MATRIX_WORDS } else { 0 }).map(move |number| node.matrix_word(number))
}

/// The numbers of a matrix.
pub const MATRIX_WORDS: usize = 12;

/// The module `raypath_unit_blocks`, which keeps a block for each context. It takes a beat in every cycle.
///
/// A beat, `data_i` with `context_i` and `error_i`, arrives where `valid_i` is 1. With the last beat of a block,
/// `arrived_o` is 1, and `failed_o` says whether one of its beats had an error. Three readers have ports of their own:
/// `<reader>_read_i` and `<reader>_context_i`; the words are there in the next cycle, those of `child` after the
/// latency of the memories of a step, and stay until the next read. The readers are `job` (`word_…_o`, and with a
/// decoder `exists_…_o`, which children exist), `child` (`child_…_o`) and `index` (`index_…_o`).
pub fn blocks(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts, memory_width, ram_latency, parity: has_parity, step, .. } = parameters;
    let nodes = step.node;
    let builder = Builder::new("raypath_unit_blocks");
    let m = &builder;
    let beats = nodes.block_bytes() * 8 / memory_width;
    m.doc(format!("The blocks of {contexts} contexts, which arrive in {beats} beats of {memory_width} bits."));
    let valid = m.input("valid_i", 1);
    let context = m.input("context_i", bits(contexts));
    let error = m.input("error_i", 1);
    let words = data_words(m, "data", "_i", memory_width);
    let readers = ["job", "child", "index"].map(|reader| {
        (m.input(&format!("{reader}_read_i"), 1), m.input(&format!("{reader}_context_i"), bits(contexts)))
    });

    m.section("The beats of each block so far, and whether one had an error");
    let (beat, failed) = if beats == 1 {
        (None, error)
    } else {
        let (beat, failed) = progress(m, "raypath_unit_progress", contexts, beats, [valid, context, error])?;
        (Some(beat), failed)
    };
    let is_beat = |number: u32| beat.map_or(valid, |beat| valid & beat.is(number.into()));
    let arrived = is_beat(beats - 1).named("arrived");

    m.section("The words");
    let per_beat = words.len();
    let data = |word: usize| words[word % per_beat];
    // The columns of a memory, by the words from which they come.
    let store = |name: &str, latency, of: Vec<(usize, String, Wire<'_>)>, (read, reader)| {
        let mut stored = Vec::new();
        for number in 0..beats {
            let of = of.iter().enumerate();
            // The last word is the most significant, as in a beat.
            let here: Vec<_> = of.rev().filter(|(_, (word, ..))| word / per_beat == number as usize).collect();
            if here.is_empty() {
                continue;
            }
            let columns: Vec<(&str, u32)> =
                here.iter().map(|(_, (_, title, wire))| (title.as_str(), wire.width())).collect();
            let memory = m.memory(&format!("u_{name}_{number}"), contexts, &columns).latency(latency);
            memory.write(is_beat(number), context, &here.iter().map(|(_, (.., wire))| *wire).collect::<Vec<_>>());
            stored.extend(here.iter().map(|(place, _)| *place).zip(memory.read(read, reader)));
        }
        stored.sort_by_key(|(place, _)| *place);
        stored.into_iter().map(|(_, wire)| wire).collect::<Vec<_>>()
    };
    let column = |word: usize| (word, format!("word_{word}"), data(word));
    let whole = |from: usize, count: usize| (from..from + count).map(column).collect::<Vec<_>>();
    let (child_word, index_word) = (nodes.child_word(), nodes.index_word());
    let exist = |child: usize| {
        let (word, exists) = match nodes {
            NodeKind::Wide8 => {
                let (word, byte) = (child_word + 2 + child / 4, 8 * (child as u32 % 4));
                (word, data(word).bits(byte + 7, byte).any())
            }
            _ => (child_word + child, data(child_word + child).lower(nodes.offset_bits()).any()),
        };
        (word, format!("exists_{child}"), exists)
    };
    let [job, child, index] = readers;
    let of_jobs = job_words(step);
    let children_of_job = if step.has_decoder() { 0..nodes.children() } else { 0..0 };
    let columns = of_jobs.iter().map(|&word| column(word)).chain(children_of_job.map(exist));
    let jobs = store("jobs", 1, columns.collect(), job);
    let mut of_children = whole(child_word, 4);
    if has_parity {
        // A bit for each word, because a memory may have one of them.
        let bit = |k: usize| (child_word + k, format!("parity_{k}"), parity(&[data(child_word + k)]));
        of_children.extend((0..4).map(bit));
    }
    let mut children = store("children", ram_latency, of_children, child);
    let child_error = has_parity.then(|| parity(&children));
    children.truncate(4);
    let indices = store("indices", 1, whole(index_word, nodes.triangles_per_block() as usize), index);
    if step.features.has("geometry") {
        let word = nodes.geometry_word();
        let geometry = store("geometry", 1, whole(word, 1), index);
        geometry.into_iter().for_each(|wire| m.output("geometry_o", wire));
    }
    if beats == 1 {
        let per_block = nodes.triangles_per_block() as usize;
        let geometry = step.features.has("geometry").then_some(nodes.geometry_word());
        let is_read = |word: &usize| {
            of_jobs.contains(word)
                || (child_word..child_word + 4).contains(word)
                || (index_word..index_word + per_block).contains(word)
                || geometry == Some(*word)
        };
        let unread: Vec<Wire<'_>> = (0..words.len()).filter(|word| !is_read(word)).map(data).collect();
        m.unused("unused_data", &unread);
    }

    m.output("arrived_o", arrived);
    m.output("failed_o", failed);
    let (words, exist) = jobs.split_at(of_jobs.len());
    of_jobs.iter().zip(words).for_each(|(number, word)| m.output(&format!("word_{number}_o"), *word));
    for (name, words) in [("exists", exist), ("child", &children), ("index", &indices)] {
        words.iter().enumerate().for_each(|(k, word)| m.output(&format!("{name}_{k}_o"), *word));
    }
    child_error.into_iter().for_each(|error| m.output("child_error_o", error));
    builder.finish()
}

/// A port of `width` bits as words of 32 bits, `<name>_0<suffix>` and so on. The text has one port `<name><suffix>`.
pub fn data_words<'m>(m: &'m Builder, name: &str, suffix: &str, width: u32) -> Vec<Wire<'m>> {
    let ports: Vec<String> = (0..width / 32).map(|word| format!("{name}_{word}{suffix}")).collect();
    let words = ports.iter().map(|port| m.input(port, 32)).collect();
    let select = |word: usize| format!("[{}:{}]", 32 * word + 31, 32 * word);
    let members = ports.into_iter().enumerate().rev().map(|(word, port)| (port, select(word)));
    let structure = format!("logic [{}:0]", width - 1);
    m.group_inputs(PortGroup { name: format!("{name}{suffix}"), structure, members: members.collect() });
    words
}

/// The number of the beat that arrives, and whether its block has an error so far.
pub fn progress<'m>(
    m: &'m Builder,
    module: &str,
    contexts: u32,
    beats: u32,
    [valid, context, error]: [Wire<'m>; 3],
) -> Result<(Wire<'m>, Wire<'m>), Error> {
    let width = bits(beats);
    let (next_beat, next_failed) = (m.forward("next_beat", width), m.forward("next_failed", 1));
    next_beat.wire().comment("by context, because beats of different blocks interleave");
    next_failed.wire().comment("0 after the last beat, for the next block of the context");
    let kept = Inputs::default()
        .port("write_enable", valid)
        .port("address", context)
        .port("beat", next_beat.wire())
        .port("failed", next_failed.wire())
        .place(m, "u_progress", &registers(module, contexts, &[("beat", width), ("failed", 1)])?);
    let beat = kept.port("beat");
    let failed = (kept.port("failed") | error).named("failed");
    next_beat.drive(beat + m.constant(width, 1));
    next_failed.drive(failed & !beat.is(u64::from(beats) - 1));
    Ok((beat, failed))
}
