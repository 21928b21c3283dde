//! A queue in a memory.

use raypath_hdl::text::Template;
use raypath_hdl::{Builder, Error, Module, Register, Wire};
use std::sync::Arc;

/// The queue `name` of `depth` words in a memory and one at the output, with these columns.
///
/// Inputs: `push_i` with `<column>_i`, and `pop_i`, which takes the word at the output. Outputs: `valid_o` and
/// `<column>_o`. A word is at the output of an empty queue two cycles after it entered. There is no port that says that
/// the queue is full: its owner has at most `depth` words.
pub fn queue(name: &str, depth: u32, columns: &[(&str, u32)]) -> Result<Arc<Module>, Error> {
    let builder = Builder::new(name);
    let m = &builder;
    m.doc(format!("A queue of up to {depth} words."));
    let push = m.input("push_i", 1);
    let data: Vec<Wire<'_>> = columns.iter().map(|(column, width)| m.input(&format!("{column}_i"), *width)).collect();
    let pop = m.input("pop_i", 1);
    let [head, tail] = ["head_q", "tail_q"].map(|name| m.register(name, bits(depth)).reset_to(0));
    let valid = m.register("valid_q", 1).reset_to(0);

    // A word waits here only while another is at the output, or for one cycle. So the memory is never full, and it is
    // empty where both ends are the same.
    let waits = !head.wire().equals(tail.wire());
    let read = (waits & (!valid.wire() | pop)).named("read");
    valid.next(read | (valid.wire() & !pop));
    tail.next_when(push, after(tail.wire(), depth));
    head.next_when(read, after(head.wire(), depth));
    let memory = m.memory("u_words", depth, columns);
    memory.write(push, tail.wire(), &data);
    let words = memory.read(read, head.wire());

    m.output("valid_o", valid.wire());
    columns.iter().zip(words).for_each(|((column, _), word)| m.output(&format!("{column}_o"), word));
    let text = include_str!("raypath_queue.sv");
    let doc = "A queue of words in a memory and one at the output, until `pop_i` takes it. A word is at the output of an \
               empty queue two cycles after it entered. There is no port that says that the queue is full: its owner has \
               at most Depth words.";
    m.template(template("raypath_queue", doc, text, depth, columns, &["push_i", "pop_i"], &["valid_o"]));
    builder.finish()
}

/// The text of modules with words of these columns, at `data_i` and `data_o`, and with other ports.
pub fn template(
    module: &str,
    doc: &str,
    text: &str,
    depth: u32,
    columns: &[(&str, u32)],
    inputs: &[&str],
    outputs: &[&str],
) -> Template {
    let words = |suffix: &str| columns.iter().map(|(column, _)| format!("{column}_{suffix}")).collect::<Vec<_>>();
    let alone = |port: &&str| (port.to_string(), vec![port.to_string()]);
    let data_i = ("data_i".to_string(), words("i"));
    let ports = inputs.iter().map(alone).chain([data_i]).chain(outputs.iter().map(alone));
    let width = columns.iter().map(|(_, width)| width).sum();
    Template {
        module: module.to_string(),
        doc: doc.to_string(),
        text: text.to_string(),
        parameters: vec![("Depth", depth), ("Width", width)],
        ports: ports.chain([("data_o".to_string(), words("o"))]).collect(),
    }
}

/// Counts the words of a queue that is pushed and popped.
pub fn count_words<'m>(count: Register<'m>, push: Wire<'m>, pop: Wire<'m>) {
    let m = push.builder();
    let step = m.concat(&[(!push & pop).replicate(count.wire().width() - 1), push ^ pop]);
    count.next(count.wire() + step);
}

/// The number after one of 0 to `count` - 1, in a circle.
pub fn after(number: Wire<'_>, count: u32) -> Wire<'_> {
    let m = number.builder();
    let next = number + m.constant(number.width(), 1);
    if count.is_power_of_two() {
        return next;
    }
    number.is(u64::from(count) - 1).mux(m.constant(number.width(), 0), next)
}

/// The bits of a word with the values 0 to `count` - 1.
pub fn bits(count: u32) -> u32 {
    count.next_power_of_two().trailing_zeros().max(1)
}
