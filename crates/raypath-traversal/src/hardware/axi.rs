//! What is around units: a cluster of them, and an AXI4 read master as its memory port.

use super::blocks::data_words;
use super::channels::{CHANNELS, COUNTED, OF_MEMORY};
use super::connect::{Inputs, Outputs};
use super::top::UnitNetlist;
use crate::error::UnitError;
use crate::system::rtl;
use raypath_hdl::{Builder, Module, text};
use std::sync::Arc;

/// What every burst has by default, by the end of the signal's name: width and value. The burst increments; the access
/// is normal, to memory that is not cacheable but bufferable, of data, not secure, unprivileged, without quality of
/// service.
const FIXED: [(&str, u32, u64); 6] =
    [("burst", 2, 0b01), ("lock", 1, 0), ("cache", 4, 0b0011), ("prot", 3, 0b010), ("qos", 4, 0), ("user", 1, 0)];

/// The signals of the unit's memory channels, which the AXI master replaces.
const MEMORY: &str = "mem_";

/// What the caches count.
pub const CACHE_COUNTS: [&str; 3] = ["cache_hits", "cache_merges", "cache_misses"];

impl UnitNetlist {
    /// The module `raypath_cluster`: units behind one port for rays, one for hits, one for candidates and one memory
    /// port, each with a cache ([`simulate`](crate::system::simulate) has its model). Their number and the caches are
    /// parameters of the text. The netlist has the defaults: one unit without a cache, and no register of its own.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn cluster(&self) -> Result<Arc<Module>, UnitError> {
        self.cluster_of(&self.emitted()?)
    }

    fn cluster_of(&self, unit: &Arc<Module>) -> Result<Arc<Module>, UnitError> {
        let builder = Builder::new("raypath_cluster");
        let m = &builder;
        m.doc("Units behind one port for each channel. A ray enters the next unit that has a place.");
        m.doc("Requests, hits and candidates leave round robin. A tag has the number of the unit in its upper bits.");
        CHANNELS.iter().chain(&OF_MEMORY).for_each(|(prefix, comment)| m.channel(prefix, comment));
        let data = self.beat(m, ["mem_rsp_data", "_i"]);
        let is_other = |name: &str| !name.starts_with("mem_rsp_data");
        let outputs = through(m, unit, "u_unit", is_other, data);
        let invalidates = m.input("invalidate_i", 1).comment("caches forget all lines");
        m.unused("unused_invalidate", &[invalidates]);
        for port in unit.outputs() {
            m.output(&port.name, outputs.port(port.stem()));
        }
        CACHE_COUNTS.iter().for_each(|name| m.output(&format!("count_{name}_o"), m.constant(1, 0)));
        let netlist = builder.finish()?;
        let text = self.filled(rtl::text("raypath_cluster"), Some(&netlist))?;
        Ok(text::verbatim(&netlist, text, rtl::below(&["raypath_arbiter", "raypath_cache"])))
    }

    /// The module `raypath_unit_axi`: a cluster, with the signals `m_axi_ar…` and `m_axi_r…` of an AXI4 read master in
    /// place of `mem_req_…` and `mem_rsp_…`. They have the names of the AXI specification without a suffix, by which
    /// tools find the interface. Besides those of the cluster, the attributes of reads and a timeout are parameters of
    /// the text.
    ///
    /// A burst reads a block, and its id is the tag of the request; with caches, a line, and the number of a miss.
    /// Bursts of different ids may return in any order, and their beats may be interleaved. A response that is not OKAY
    /// is an error of the memory.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn axi(&self) -> Result<Arc<Module>, UnitError> {
        self.axi_of(&self.emitted()?)
    }

    /// The same, around the unit as it is emitted.
    pub(super) fn axi_of(&self, unit: &Arc<Module>) -> Result<Arc<Module>, UnitError> {
        let builder = Builder::new("raypath_unit_axi");
        let m = &builder;
        let (cluster, width) = (self.cluster_of(unit)?, self.parameters.memory_width);
        let (beats, beat_bytes) = (self.parameters.step.node.block_bytes() * 8 / width, width / 8);
        let tag = cluster.port_width("mem_req_tag_o").unwrap_or(1);
        m.doc("A traversal unit, or a cluster of them, with an AXI4 read master as its memory port.");
        m.doc(format!("A block is a burst of {beats} beats of {beat_bytes} bytes; its id is the context, {tag} bits."));
        m.doc("With caches, a line is a burst. By default, reads are of normal memory that is bufferable and not");
        m.doc("cacheable, unprivileged, of data, and not secure.");

        let of_axi =
            [("m_axi_ar", "The AXI4 channel of read addresses."), ("m_axi_r", "The AXI4 channel of read data.")];
        CHANNELS.iter().chain(&[COUNTED]).chain(&of_axi).for_each(|(prefix, comment)| m.channel(prefix, comment));
        let arready = m.input("m_axi_arready", 1);
        let rid = m.input("m_axi_rid", tag);
        let data = self.beat(m, ["m_axi_rdata", ""]);
        let rresp = m.input("m_axi_rresp", 2);
        let rlast = m.input("m_axi_rlast", 1);
        let rvalid = m.input("m_axi_rvalid", 1);
        // The unit counts the beats of each block.
        m.unused("unused_rlast", &[rlast]);

        let memory = data
            .port("mem_req_ready", arready)
            .port("mem_rsp_valid", rvalid)
            .port("mem_rsp_tag", rid)
            .port("mem_rsp_error", rresp.any());
        let is_shared = |name: &str| !name.starts_with(MEMORY);
        let outputs = through(m, &cluster, "u_cluster", is_shared, memory);
        for port in cluster.outputs().iter().filter(|port| is_shared(&port.name)) {
            m.output(&port.name, outputs.port(port.stem()));
        }
        // Of the timeout, which the text has.
        m.output("timed_out_o", m.constant(1, 0));
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
        let text = self.filled(rtl::text("raypath_unit_axi"), Some(&netlist))?;
        Ok(text::verbatim(&netlist, text, rtl::below(&["raypath_guard"])))
    }

    /// The words of a beat, from a port whose name begins and ends like this.
    fn beat<'m>(&self, m: &'m Builder, [name, end]: [&str; 2]) -> Inputs<'m> {
        let words = data_words(m, name, end, self.parameters.memory_width).into_iter().enumerate();
        Inputs::default().ports(words.map(|(word, wire)| (format!("mem_rsp_data_{word}"), wire)))
    }

    /// The modules that `raypath_device` has besides those of [`axi`](Self::axi), itself the last: the name, the
    /// comment and the text of each. It is a cluster with registers, rings of rays and hits in memory, and an
    /// interrupt.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn device(&self) -> Result<Vec<[String; 3]>, UnitError> {
        let mut modules = rtl::below(&["raypath_device_registers", "raypath_rings", "raypath_device"]);
        for [.., text] in &mut modules {
            *text = self.filled(text, None)?;
        }
        Ok(modules)
    }
}

/// A module with the same ports as this one, where `is_same`, and its other inputs from `more`.
fn through<'m>(
    m: &'m Builder,
    inner: &Arc<Module>,
    name: &str,
    is_same: impl Fn(&str) -> bool,
    more: Inputs<'m>,
) -> Outputs<'m> {
    let same = inner.inputs().iter().filter(|port| is_same(&port.name));
    let inputs =
        same.fold(more, |inputs, port| inputs.port(port.stem(), m.input(&port.name, inner.signal(port.signal).width)));
    inputs.place(m, name, inner)
}
