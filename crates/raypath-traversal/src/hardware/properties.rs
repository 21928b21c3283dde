//! Assertions about the ports of the unit.

use super::queue::bits;
use super::top::UnitNetlist;
use std::fmt::Write;

impl UnitNetlist {
    /// The text of all assertions: those of the datapath and those of the unit's ports.
    pub fn properties(&self) -> String {
        let mut text = self.datapath.properties().to_string();
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{}", include_str!("properties/ports.sv"));
        let channels = [
            // A flush drops what waits.
            ("hit", "hit_valid_o", "hit_ready_i | flush_i", self.outputs("hit_")),
            ("request", "mem_req_valid_o", "mem_req_ready_i", self.outputs("mem_req_")),
            ("result", "result_valid_o", "result_ready_i", self.outputs("result_")),
            ("vec_request", "vec_req_valid_o", "vec_req_ready_i", self.outputs("vec_req_")),
            ("candidate", "cand_valid_o", "cand_ready_i | flush_i", self.outputs("cand_")),
        ];
        for (name, valid, ready, data) in channels.into_iter().filter(|(.., data)| !data.is_empty()) {
            let width: u32 = data.iter().map(|(_, width)| width).sum();
            let names: Vec<&str> = data.iter().map(|(name, _)| name.as_str()).collect();
            let _ = write!(
                text,
                "\nbind raypath_unit raypath_stall_properties #(\n    .Width ({width})\n  ) u_{name}_stall_properties \
                 (\n    .clk_i (clk_i),\n    .rst_ni (rst_ni),\n    .valid_i ({valid}),\n    .ready_i ({ready}),\n    \
                 .data_i ({{\n      {}\n    }})\n  );\n",
                names.join(",\n      ")
            );
        }
        let contexts = self.parameters.contexts;
        let of_candidates = |text| if self.parameters.step.features.has_candidates() { text } else { "'0" };
        let beats = 8 * self.parameters.step.node.block_bytes() / self.parameters.memory_width;
        let _ = write!(
            text,
            "\nbind raypath_unit raypath_unit_ports_properties #(\n    .Contexts ({contexts}),\n    .ContextWidth \
             ({}),\n    .Beats ({beats})\n  ) u_ports_properties (\n    .clk_i (clk_i),\n    .rst_ni (rst_ni),\n    \
             .idle_i (idle_o),\n    .enters_i (ray_valid_i & ray_ready_o),\n    .leaves_i (hit_valid_o & hit_ready_i),\n    .requests_i \
             (mem_req_valid_o & mem_req_ready_i),\n    .request_tag_i (mem_req_tag_o),\n    .arrives_i \
             (mem_rsp_valid_i & mem_rsp_ready_o),\n    .arrival_tag_i (mem_rsp_tag_i),\n    .asks_i ({}),\n    \
             .asked_tag_i ({}),\n    .answers_i ({}),\n    .answer_tag_i ({})\n  );\n",
            bits(contexts),
            of_candidates("cand_valid_o & cand_ready_i"),
            of_candidates("cand_tag_o"),
            of_candidates("answer_valid_i & answer_ready_o"),
            of_candidates("answer_tag_i"),
        );
        text
    }

    /// The outputs of a channel besides its valid bit, with their widths.
    fn outputs(&self, channel: &str) -> Vec<(String, u32)> {
        let outputs = self.top.outputs().iter().filter(|port| port.name.starts_with(channel));
        let words = outputs.filter(|port| !port.name.ends_with("_valid_o"));
        words.map(|port| (self.top.port_text(&port.name), self.top.signal(port.signal).width)).collect()
    }
}
