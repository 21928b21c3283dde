//! The shell: a datapath behind two narrow streams.
//!
//! Hardware: registers that collect the words of a job, each with an enable of its own, and a multiplexer that selects the
//! words of an outcome, which stays at the datapath's output until its last word was sent. A job is offered to the
//! datapath when its last word has arrived, and the next one is collected when the datapath has taken it. So the datapath
//! can be as full as it gets, but takes a job only in as many cycles as a frame has words. Wires to many registers come
//! from registers, because they limit the clock of a large FPGA.
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
        let full = m.register("full_q", 1).reset_to(0);
        let takes = (valid & !full.wire()).named("takes");
        let last = job.words() as usize - 1;
        let turns: Vec<_> =
            (0..=last).map(|word| m.register(&format!("turn_{word}_q"), 1).reset_to((word == 0).into())).collect();
        let enables: Vec<Wire<'_>> = turns
            .iter()
            .enumerate()
            .map(|(word, turn)| {
                turn.next_when(takes, turns[if word == 0 { last } else { word - 1 }].wire());
                let enable = m.register(&format!("enable_{word}_q"), 1).reset_to(0);
                enable.next(takes & turn.wire());
                enable.wire()
            })
            .collect();
        let arrived = m.register("data_q", width.bits());
        arrived.next(data);
        let words: Vec<Wire<'_>> = enables
            .into_iter()
            .enumerate()
            .map(|(word, enable)| {
                let register = m.register(&format!("job_{word}_q"), width.bits());
                register.next_when(enable, arrived.wire());
                register.wire()
            })
            .collect();
        let offers = m.register("offers_q", 1).reset_to(0);
        offers.wire().comment("a cycle after the last word was taken, because it enters its register then");
        m.output("ready_o", !full.wire());

        m.section("The datapath");
        let pops = m.register("pops_q", 1).reset_to(0);
        let mut inputs = vec![("input_valid_i", offers.wire()), ("output_ready_i", pops.wire())];
        inputs.extend(values(&m, &job, &words));
        let outputs = m.instance(INSTANCE, datapath, &inputs);
        let ports = datapath.outputs().iter().zip(outputs);
        let outputs: Vec<(&str, Wire<'_>)> = ports.map(|(port, wire)| (port.name.as_str(), wire)).collect();
        let output = |name: &str| outputs.iter().find(|(port, _)| *port == name).map(|(_, wire)| *wire);
        let absent = m.constant(1, 0);
        let is_taken = (offers.wire() & output("input_ready_o").unwrap_or(absent)).named("is_taken");
        full.next((takes & turns[last].wire()) | (full.wire() & !is_taken));
        offers.next(full.wire() & !is_taken);

        m.section("Send the words of an outcome");
        let mut words = Vec::new();
        for field in &outcome.fields {
            let width = outcome.words_of(field) * width.bits();
            let value = output(&field.port).unwrap_or(absent).extend(width);
            words.extend((0..outcome.words_of(field)).map(|word| slice(value, word, &outcome)));
        }
        let number = counter(&m, "number_q", outcome.words() - 1);
        let sent = m.register("sent_q", 1).reset_to(0);
        let has_outcome = output("output_valid_o").unwrap_or(absent) & !pops.wire();
        let sends = (has_outcome & (!sent.wire() | sink_ready)).named("sends");
        let is_last = number.wire().is(u64::from(outcome.words()) - 1).named("is_last");
        let one_more = number.wire() + m.constant(number.wire().width(), 1);
        number.next_when(sends, is_last.mux(m.constant(one_more.width(), 0), one_more));
        pops.next(sends & is_last);
        sent.next(sends | (sent.wire() & !sink_ready));
        let word = m.register("word_q", width.bits());
        word.next_when(sends, number.wire().select(&words));
        m.output("valid_o", sent.wire());
        m.output("data_o", word.wire());
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

/// The values of the ports in the words of a job.
fn values<'m, 'f>(m: &'m Builder, frame: &'f Frame, words: &[Wire<'m>]) -> Vec<(&'f str, Wire<'m>)> {
    let mut rest = words;
    let value = |field: &'f Field| {
        let (own, after) = rest.split_at(frame.words_of(field) as usize);
        rest = after;
        let parts: Vec<Wire<'m>> = own.iter().rev().copied().collect();
        let whole = m.concat(&parts);
        if field.bits < whole.width() {
            m.unused(&format!("unused_{}", field.port), &[whole.upper(whole.width() - field.bits)]);
        }
        (field.port.as_str(), whole.lower(field.bits))
    };
    let values: Vec<(&'f str, Wire<'m>)> = frame.fields.iter().map(value).collect();
    values
}
