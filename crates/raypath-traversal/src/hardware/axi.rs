//! The unit with an AXI4 read master as its memory port.

use super::blocks::data_words;
use super::channels::CHANNELS;
use super::connect::Inputs;
use super::parameters::UnitParameters;
use super::queue::bits;
use super::top::UnitNetlist;
use crate::system::rtl;
use raypath_hdl::{Builder, Error, Module, text, verilog};
use std::sync::Arc;

/// What every burst has by default, by the end of the signal's name: width and value. The burst increments; the access
/// is normal, to memory that is not cacheable but bufferable, of data, not secure, unprivileged, without quality of
/// service.
const FIXED: [(&str, u32, u64); 5] =
    [("burst", 2, 0b01), ("lock", 1, 0), ("cache", 4, 0b0011), ("prot", 3, 0b010), ("qos", 4, 0)];

/// The signals of the unit's memory channels, which this module replaces.
const MEMORY: &str = "mem_";

impl UnitNetlist {
    /// The module `raypath_unit_axi`: the unit, with the signals `m_axi_ar…` and `m_axi_r…` of an AXI4 read master in
    /// place of `mem_req_…` and `mem_rsp_…`. They have the names of the AXI specification without a suffix, by which
    /// tools find the interface. The attributes of reads are parameters of the text, and so is a cache
    /// ([`Cache`](crate::system::Cache)). The netlist has the defaults: no cache, and no register of its own.
    ///
    /// A burst reads a block, and its id is the tag of the request; with a cache, a line, and the number of a miss.
    /// Bursts of different ids may return in any order, and their beats may be interleaved. A response that is not OKAY
    /// is an error of the memory.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn axi(&self) -> Result<Arc<Module>, Error> {
        let builder = Builder::new("raypath_unit_axi");
        let m = &builder;
        let (unit, width) = (&self.top, self.parameters.memory_width);
        let (beats, beat_bytes) = (self.parameters.step.node.block_bytes() * 8 / width, width / 8);
        let tag = unit.port_width("mem_req_tag_o").unwrap_or(1);
        m.doc("raypath_unit with an AXI4 read master as its memory port.");
        m.doc(format!("A block is a burst of {beats} beats of {beat_bytes} bytes; its id is the context, {tag} bits."));
        m.doc("With a cache, a line is a burst.");

        let of_axi =
            [("m_axi_ar", "The AXI4 channel of read addresses."), ("m_axi_r", "The AXI4 channel of read data.")];
        CHANNELS.iter().chain(&of_axi).for_each(|(prefix, comment)| m.channel(prefix, comment));
        let mut inputs = Inputs::default();
        for port in unit.inputs().iter().filter(|port| !port.name.starts_with(MEMORY)) {
            inputs = inputs.port(port.stem(), m.input(&port.name, unit.signal(port.signal).width));
        }
        let invalidates = m.input("invalidate_i", 1).comment("the cache forgets all lines");
        m.unused("unused_invalidate", &[invalidates]);
        let arready = m.input("m_axi_arready", 1);
        let rid = m.input("m_axi_rid", tag);
        let data = data_words(m, "m_axi_rdata", "", width);
        let rresp = m.input("m_axi_rresp", 2);
        let rlast = m.input("m_axi_rlast", 1);
        let rvalid = m.input("m_axi_rvalid", 1);
        // The unit counts the beats of each block.
        m.unused("unused_rlast", &[rlast]);

        let words = data.into_iter().enumerate().map(|(word, wire)| (format!("mem_rsp_data_{word}"), wire));
        let outputs = inputs
            .port("mem_req_ready", arready)
            .port("mem_rsp_valid", rvalid)
            .port("mem_rsp_tag", rid)
            .port("mem_rsp_error", rresp.any())
            .ports(words)
            .place(m, "u_unit", unit);

        for port in unit.outputs().iter().filter(|port| !port.name.starts_with(MEMORY)) {
            m.output(&port.name, outputs.port(port.stem()));
        }
        m.output("m_axi_arid", outputs.port("mem_req_tag"));
        m.output("m_axi_araddr", outputs.port("mem_req_addr"));
        m.output("m_axi_arlen", m.constant(8, u64::from(beats) - 1));
        m.output("m_axi_arsize", m.constant(3, beat_bytes.trailing_zeros().into()));
        for (name, width, value) in FIXED {
            m.output(&format!("m_axi_ar{name}"), m.constant(width, value));
        }
        m.output("m_axi_arvalid", outputs.port("mem_req_valid"));
        m.output("m_axi_rready", outputs.port("mem_rsp_ready"));
        let netlist = builder.finish()?;
        let text = self.axi_text(&verilog::print_module(&netlist, &[])?);
        let below = [
            ["raypath_cache", rtl::CACHE_DOC, rtl::CACHE],
            ["raypath_axi_reader", READER_DOC, include_str!("raypath_axi_reader.sv")],
        ];
        Ok(text::verbatim(&netlist, text, below.map(|texts| texts.map(str::to_string)).into()))
    }

    /// The text of the wrapper: the ports of its netlist, parameters, and the unit with what reads its blocks.
    fn axi_text(&self, netlist: &str) -> String {
        let UnitParameters { contexts, memory_width, address_width, step, .. } = self.parameters;
        let block_bytes = step.node.block_bytes();
        let ports = netlist.split_once("(\n").and_then(|(_, rest)| rest.split_once("\n);\n")).unwrap_or_default().0;
        let of_unit = self.top.text_ports().into_iter().filter(|port| !port.name.starts_with(MEMORY));
        let same = ["clk_i", "rst_ni"].map(str::to_string).into_iter().chain(of_unit.map(|port| port.name));
        let connections = rows(same.map(|name| format!(".{name}")));
        let values = [
            ("PORTS", ports.to_string()),
            ("CONNECTIONS", connections),
            ("CONTEXTS", contexts.to_string()),
            ("WIDTH", memory_width.to_string()),
            ("ADDRESS", address_width.to_string()),
            ("BLOCK", block_bytes.to_string()),
            ("LAST_ADDRESS", (address_width - 1).to_string()),
            ("LAST_DATA", (memory_width - 1).to_string()),
            ("LAST_TAG", (bits(contexts) - 1).to_string()),
        ];
        let template = include_str!("raypath_unit_axi.sv").to_string();
        values.into_iter().fold(template, |text, (name, value)| text.replace(&format!("@{name}@"), &value))
    }
}

/// The comment at the head of the module that reads blocks.
const READER_DOC: &str = "The blocks of a unit by AXI4: each request is a burst. With CacheSets above 0, lines are kept in \
                          a cache. By default, reads are of normal memory that is bufferable and not cacheable, \
                          unprivileged, of data, and not secure.";

/// Items separated by commas, in lines of a text.
fn rows(items: impl Iterator<Item = String>) -> String {
    let mut rows = vec![String::new()];
    for item in items {
        let last = rows.last().map_or(0, String::len);
        if last > 0 && last + item.len() > 92 {
            rows.push(String::new());
        }
        let row = rows.len() - 1;
        rows[row] += &format!("{item}, ");
    }
    rows.iter().map(|row| format!("    {}\n", row.trim_end())).collect()
}
