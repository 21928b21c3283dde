//! The texts of the modules around units, with what follows from the unit.

use super::axi::CACHE_COUNTS;
use super::parameters::UnitParameters;
use super::parametric;
use super::top::UnitNetlist;
use crate::engine::COUNTS;
use raypath_hdl::{Error, Module, text::TextPort, verilog};

/// The widths of ports that follow from parameters, by the beginning of the port's name.
const WIDTHS: [(&str, &str); 14] = [
    ("count_", "Units"),
    ("ray_id", "IdWidth"),
    ("hit_id", "IdWidth"),
    ("cand_id", "IdWidth"),
    ("ray_base", "AddressWidth-32"),
    ("cand_tag_", "CandTagWidth"),
    ("answer_tag_", "CandTagWidth"),
    ("mem_req_addr", "AddressWidth"),
    ("mem_req_tag_", "TagWidth"),
    ("mem_rsp_tag_", "TagWidth"),
    ("m_axi_araddr", "AddressWidth"),
    ("m_axi_arid", "TagWidth"),
    ("m_axi_rid", "TagWidth"),
    ("m_axi_aruser", "ArUserWidth"),
];

/// The words of a record of a ray and of a hit, 16 of 32 bits, by the names of the fields. An id has two.
const RAY_WORDS: [(&str, u32); 13] = [
    ("id", 0),
    ("flags", 2),
    ("cull_mask", 3),
    ("root", 4),
    ("base", 5),
    ("tmin", 6),
    ("tmax", 7),
    ("origin_x", 8),
    ("origin_y", 9),
    ("origin_z", 10),
    ("dir_x", 12),
    ("dir_y", 13),
    ("dir_z", 14),
];
const HIT_WORDS: [&str; 13] = [
    "primitive",
    "t",
    "t_num",
    "t_denom",
    "geometry",
    "nodes",
    "triangles",
    "instance",
    "custom_index",
    "shader_offset",
    "u",
    "v",
    "",
];

/// What stands in the place of a name between the signs `@`.
enum Value {
    /// A word in a line.
    Word(String),
    /// Lines.
    Lines(Vec<String>),
    /// Items, separated by commas, in lines.
    Items(Vec<String>),
}

impl UnitNetlist {
    /// The text of a module around units. `file` is its text with names between the signs `@` for what follows from the
    /// unit and from the ports of `netlist`, the module itself. Lines that begin with `@c` are for units with
    /// candidates, those with `@u` for addresses of fewer than 64 bits.
    pub(super) fn filled(&self, file: &str, netlist: Option<&Module>) -> Result<String, Error> {
        let is_there =
            [("@c", self.parameters.step.features.has_candidates()), ("@u", self.parameters.address_width < 64)];
        let lines = file.lines().filter_map(|line| {
            let of = is_there.iter().find_map(|(mark, is_there)| Some((line.strip_prefix(mark)?, *is_there)));
            of.map_or(Some(line), |(line, is_there)| is_there.then_some(line))
        });
        let values = self.values(netlist)?;
        let filled =
            lines.map(|line| values.iter().fold(line.to_string(), |line, (name, value)| value.put(line, name)));
        Ok(parametric::laid_out(&filled.map(|line| format!("{line}\n")).collect::<String>()))
    }

    fn values(&self, netlist: Option<&Module>) -> Result<Vec<(String, Value)>, Error> {
        let UnitParameters { contexts, memory_width, id_width, address_width, step, .. } = self.parameters;
        let of_step = step.features;
        let mut values: Vec<(String, Value)> = Vec::new();
        let numbers = [
            ("CONTEXTS", contexts),
            ("WIDTH", memory_width),
            ("ID", id_width),
            ("ADDRESS", address_width),
            ("BLOCK", step.node.block_bytes()),
            ("NODE", step.node as u32),
            ("FLAGS", of_step.has_flags().into()),
            ("CANDIDATES", of_step.has_candidates().into()),
            ("INSTANCES", of_step.instances.into()),
            ("NESTED", of_step.nested.into()),
        ];
        values.extend(numbers.map(|(name, number)| (name.to_string(), Value::Word(number.to_string()))));
        let names: Vec<&str> = parametric::names(self.parameters).collect();
        for (name, parameter) in [("ID_KIND", "IdWidth"), ("ADDRESS_KIND", "AddressWidth")] {
            let kind = if names.contains(&parameter) { "parameter " } else { "localparam" };
            values.push((name.into(), Value::Word(kind.into())));
        }
        let passed = names.iter().map(|name| format!(".{name} ({name})")).collect();
        values.push(("PASSED".into(), Value::Items(passed)));
        if let Some(netlist) = netlist {
            let printed = verilog::print_module(netlist, &[])?;
            let ports = printed.split_once("(\n").and_then(|(_, rest)| rest.split_once("\n);\n"));
            let ports = ports.unwrap_or_default().0.lines().map(with_width);
            values.push(("PORTS".into(), Value::Lines(ports.collect())));
            let names = netlist.text_ports().into_iter().map(|port| port.name);
            let of_cluster = names.filter(|name| !name.starts_with("m_axi") && name != "timed_out_o");
            let shared = ["clk_i", "rst_ni"].map(str::to_string).into_iter().chain(of_cluster);
            values.push(("CONNECTIONS".into(), Value::Items(shared.map(|name| format!(".{name}")).collect())));
        }
        let items = |name: &str, items: Vec<String>| (name.to_string(), Value::Items(items));
        let same = |port: TextPort| format!(".{}", port.name);
        let (ray, answer) = (self.fields("ray", true), self.fields("answer", true));
        let ray_words = ray.iter().filter_map(|port| {
            let (_, word) = RAY_WORDS.iter().find(|(field, _)| port.stem() == format!("ray_{field}"))?;
            let width = width(port.stem()).map_or(port.width.to_string(), str::to_string);
            Some(format!(".{} (ray[{}+:{width}])", port.name, 32 * word))
        });
        values.push(items("RAY_WORDS", ray_words.collect()));
        values.push(items("RAY", ray.into_iter().map(same).collect()));
        values.push(items("ANSWER", answer.into_iter().filter(|port| port.stem() != "answer_tag").map(same).collect()));
        let counts: Vec<&str> = COUNTS.into_iter().chain(CACHE_COUNTS).collect();
        let each = |text: &dyn Fn(&str) -> String, counts: &[&str]| counts.iter().map(|name| text(name)).collect();
        values.push(items("COUNTS", each(&|name| format!(".count_{name}_o (count_{name}_o[u])"), &COUNTS)));
        values.push(items("COUNT_INPUTS", each(&|name| format!(".count_{name}_i (count_{name})"), &counts)));
        values.push(items("COUNT_OUTPUTS", each(&|name| format!(".count_{name}_o (count_{name})"), &counts)));
        let wires = each(&|name| format!("logic [Units-1:0] count_{name};"), &counts);
        values.push(("COUNT_WIRES".into(), Value::Lines(wires)));
        let hit = self.fields("hit", false);
        values.push(items("HIT_WORDS", hit_words(&hit)));
        for (channel, fields) in [("HIT", hit), ("CAND", self.fields("cand", false))] {
            let other = fields.iter().filter(|port| port.stem() != "cand_tag");
            let unused = other.clone().filter(|port| port.stem() != "cand_is_box");
            // The unit's number is a part of the tag.
            let port = |port: &TextPort| port.name.replace("cand_tag_o", "candidate_context");
            let connected = |port: &TextPort| format!(".{} ({})", port.name, port.stem());
            let id = fields.iter().find(|port| port.stem().ends_with("_id")).map_or(0, |port| port.width);
            let other_bits = other.clone().map(|port| port.width).sum::<u32>() - id;
            let bits = match channel {
                "HIT" => format!("IdWidth + {other_bits}"),
                _ => format!("IdWidth + ContextWidth + {other_bits}"),
            };
            values.extend([
                (channel.to_string(), Value::Items(fields.iter().map(connected).collect())),
                (format!("{channel}_BITS"), Value::Word(bits)),
                (format!("{channel}_WIRES"), Value::Lines(other.map(wire).collect())),
                (format!("{channel}_FIELDS"), Value::Items(fields.iter().map(|port| port.stem().into()).collect())),
                (format!("{channel}_UNUSED"), Value::Items(unused.map(|port| port.stem().into()).collect())),
                (format!("{channel}_PORTS"), Value::Items(fields.iter().map(port).collect())),
            ]);
        }
        Ok(values)
    }

    /// The ports of a channel of the unit in one direction, besides the handshake.
    fn fields(&self, channel: &str, is_input: bool) -> Vec<TextPort> {
        let is_field = |port: &TextPort| match port.stem().strip_prefix(channel) {
            Some(field) => port.is_input == is_input && !["_valid", "_ready"].contains(&field),
            None => false,
        };
        self.top.text_ports().into_iter().filter(is_field).collect()
    }
}

impl Value {
    /// The line with the value in the place of its name.
    fn put(&self, line: String, name: &str) -> String {
        let mark = format!("@{name}@");
        let Some(place) = line.find(&mark) else { return line };
        let indent = " ".repeat(place);
        match self {
            Self::Word(word) => line.replace(&mark, word),
            Self::Lines(lines) => line.replace(&mark, &lines.join(&format!("\n{indent}"))),
            Self::Items(items) => line.replace(&mark, &rows(items, place)),
        }
    }
}

/// The declaration of a wire for a port.
fn wire(port: &TextPort) -> String {
    let range = match (width(port.stem()), port.width) {
        (Some(width), _) => format!(" [{width}-1:0]"),
        (None, 1) => String::new(),
        (None, width) => format!(" [{}:0]", width - 1),
    };
    format!("logic{range} {};", port.stem())
}

/// The words of the record of a hit, the last one first.
fn hit_words(fields: &[TextPort]) -> Vec<String> {
    let width = |name: &str| fields.iter().find(|port| port.stem() == format!("hit_{name}")).map(|port| port.width);
    let padded = |name: &str, bits: u32| match width(name) {
        Some(width) if width == bits => format!("hit_{name}"),
        Some(width) => format!("{}'d0, hit_{name}", bits - width),
        None => format!("{bits}'d0"),
    };
    let words = HIT_WORDS.iter().rev().map(|name| padded(name, 32));
    words.chain(["23'd0, hit_back_face".to_string(), padded("status", 8), "hit_number".to_string()]).collect()
}

/// The width of a port or its wire, if it follows from parameters.
fn width(name: &str) -> Option<&'static str> {
    WIDTHS.iter().find(|(beginning, _)| name.starts_with(beginning)).map(|(_, width)| *width)
}

/// The line of a port, with the width of parameters if it follows from them.
fn with_width(line: &str) -> String {
    let port = parametric::declaration(line);
    let Some((width, (_, kind, rest))) = port.and_then(|port| Some((width(port.2)?, port))) else { return line.into() };
    let range = match width {
        "AddressWidth-32" => "[AddressWidth-33:0]".to_string(),
        width => format!("[{width}-1:0]"),
    };
    let direction = kind.split("logic").next().unwrap_or_default();
    format!("  {direction}logic {range} {rest}")
}

/// Items separated by commas, in lines; the first one begins in this column.
fn rows(items: &[String], indent: usize) -> String {
    let (mut text, mut column) = (String::new(), indent);
    for (number, item) in items.iter().enumerate() {
        let is_full = column + item.len() + 3 > 98;
        text += match (number, is_full) {
            (0, _) => "",
            (_, true) => ",\n",
            (_, false) => ", ",
        };
        if number > 0 && is_full {
            text += &" ".repeat(indent);
            column = indent;
        }
        column += item.len() + 2;
        text += item;
    }
    text
}
