//! The shell: a datapath behind two narrow streams.
//!
//! Hardware: a shift register that collects the words of a job, and one that sends the words of an outcome, each with a
//! counter. A job is offered to the datapath when its last word has arrived, and the next one is collected when the
//! datapath has taken it. An outcome is loaded when the previous one has left. So the datapath can be as full as it
//! gets, but takes a job only in as many cycles as a frame has words.
//!
//! Tests: `tests/loopback.rs` (our simulator and Verilator, jobs against the model).

use crate::frame::{Field, Frame, StreamWidth};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// A datapath with few pins: the module `raypath_shell`.
///
/// A word enters at a clock edge where `valid_i` and `ready_o` are 1, and leaves where `valid_o` and `ready_i` are 1.
#[derive(Debug, Clone)]
pub struct Shell {
    /// The module.
    pub top: Arc<Module>,
    /// What it receives for a job.
    pub job: Frame,
    /// What it sends for an outcome.
    pub outcome: Frame,
}

/// The name of the datapath's instance.
pub(crate) const INSTANCE: &str = "u_raypath";

impl Shell {
    /// The shell of a module with the ports of a datapath.
    ///
    /// # Errors
    /// A module without the ports of the handshake.
    pub fn new(datapath: &Arc<Module>, width: StreamWidth) -> Result<Self, Error> {
        let job = Frame::new(datapath, datapath.inputs(), ["input_valid_i", "output_ready_i"], width);
        let outcome = Frame::new(datapath, datapath.outputs(), ["output_valid_o", "input_ready_o"], width);
        let m = Builder::new("raypath_shell");
        m.doc(format!("The module {} behind two streams of {width} bits.", datapath.name()));
        m.doc(format!("A job is a frame of {} words, an outcome one of {}.", job.words(), outcome.words()));
        let data = m.input("data_i", width.bits());
        let valid = m.input("valid_i", 1);
        let sink_ready = m.input("ready_i", 1);

        m.section("Collect the words of a job");
        let count = counter(&m, "count_q", job.words() - 1);
        let full = m.register("full_q", 1).reset_to(0);
        let takes = (valid & !full.wire()).named("takes");
        let last = count.wire().is(u64::from(job.words()) - 1).named("last");
        let one_more = count.wire() + m.constant(count.wire().width(), 1);
        count.next_when(takes, last.mux(m.constant(one_more.width(), 0), one_more));
        let words: Vec<_> = (0..job.words()).map(|word| m.register(&format!("job_{word}_q"), width.bits())).collect();
        for (word, register) in words.iter().enumerate() {
            register.next_when(takes, words.get(word + 1).map_or(data, |above| above.wire()));
        }
        m.output("ready_o", !full.wire());

        m.section("Send the words of an outcome");
        let left = counter(&m, "left_q", outcome.words());
        let idle = (!left.wire().any()).named("idle");

        m.section("The datapath");
        let words: Vec<Wire<'_>> = words.iter().map(|register| register.wire()).collect();
        let mut inputs = vec![("input_valid_i", full.wire()), ("output_ready_i", idle)];
        inputs.extend(values(&m, &job, &words));
        let outputs = m.instance(INSTANCE, datapath, &inputs);
        let ports = datapath.outputs().iter().zip(outputs);
        let outputs: Vec<(&str, Wire<'_>)> = ports.map(|(port, wire)| (port.name.as_str(), wire)).collect();
        let output = |name: &str| outputs.iter().find(|(port, _)| *port == name).map(|(_, wire)| *wire);
        let absent = m.constant(1, 0);
        let input_ready = output("input_ready_o").unwrap_or(absent);
        full.next((takes & last) | (full.wire() & !input_ready));

        let loads = (idle & output("output_valid_o").unwrap_or(absent)).named("loads");
        let sends = (!idle & sink_ready).named("sends");
        let one_less = left.wire() - m.constant(left.wire().width(), 1);
        let all = m.constant(one_less.width(), outcome.words().into());
        left.next_when(loads | sends, loads.mux(all, one_less));
        let mut loaded = Vec::new();
        for field in &outcome.fields {
            let width = outcome.words_of(field) * width.bits();
            let value = output(&field.port).unwrap_or(absent).extend(width);
            loaded.extend((0..outcome.words_of(field)).map(|word| slice(value, word, &outcome)));
        }
        let mut above: Option<Wire<'_>> = None;
        let registers: Vec<_> =
            (0..loaded.len()).map(|word| m.register(&format!("outcome_{word}_q"), width.bits())).collect();
        for (register, loaded) in registers.iter().zip(loaded).rev() {
            match above {
                Some(above) => register.next_when(loads | sends, loads.mux(loaded, above)),
                None => register.next_when(loads, loaded),
            }
            above = Some(register.wire());
        }
        m.output("valid_o", !idle);
        m.output("data_o", above.unwrap_or(data));
        Ok(Self { top: m.finish()?, job, outcome })
    }
}

/// A module `raypath_shell` around any design, to measure its clock: each input is a register of a shift register, and
/// each output is added to another one by exclusive or. So nothing of the design is left out, no path but to or from a
/// register leads through a port, and there are two pins.
///
/// # Errors
/// A design with the ports of the module itself.
pub fn reduced(design: &Arc<Module>) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_shell");
    m.doc(format!("The module {} between two shift registers, to measure its clock.", design.name()));
    let mut last = m.input("data_i", 1);
    let register = |port: &raypath_hdl::Port, width| m.register(&format!("{}_q", port.name), width);
    let shifted = |wire: Wire<'_>, last| match wire.width() {
        1 => last,
        width => m.concat(&[wire.lower(width - 1), last]),
    };
    let mut inputs = Vec::new();
    for port in design.inputs() {
        let word = register(port, design.port_width(&port.name).unwrap_or(1));
        word.next(shifted(word.wire(), last));
        last = word.wire().top();
        inputs.push((port.name.as_str(), word.wire()));
    }
    for (port, output) in design.outputs().iter().zip(m.instance(INSTANCE, design, &inputs)) {
        let word = register(port, output.width());
        word.next(shifted(word.wire(), last) ^ output);
        last = word.wire().top();
    }
    m.output("data_o", last);
    m.finish()
}

/// A register for 0 to `most`.
fn counter<'m>(m: &'m Builder, name: &str, most: u32) -> raypath_hdl::Register<'m> {
    m.register(name, (u32::BITS - most.leading_zeros()).max(1)).reset_to(0)
}

/// A word of a value.
fn slice<'m>(value: Wire<'m>, word: u32, frame: &Frame) -> Wire<'m> {
    let width = frame.width.bits();
    value.bits((word + 1) * width - 1, word * width)
}

/// The values of the ports in the words of a job. Only the first word has bits without a reader: those of others shift.
fn values<'m, 'f>(m: &'m Builder, frame: &'f Frame, words: &[Wire<'m>]) -> Vec<(&'f str, Wire<'m>)> {
    let mut rest = words;
    let value = |field: &'f Field| {
        let (own, after) = rest.split_at(frame.words_of(field) as usize);
        rest = after;
        let parts: Vec<Wire<'m>> = own.iter().rev().copied().collect();
        (field.port.as_str(), m.concat(&parts).lower(field.bits))
    };
    let values: Vec<(&'f str, Wire<'m>)> = frame.fields.iter().map(value).collect();
    let width = frame.width.bits();
    if let (Some(first), Some(field)) = (words.first(), frame.fields.first().filter(|field| field.bits < width)) {
        m.unused("unused_job", &[first.bits(width - 1, field.bits)]);
    }
    values
}
