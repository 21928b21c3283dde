//! A unit's parts with registers after each.
//!
//! Hardware: registers with one enable. It is 0 while a result waits, so that all wait; bubbles are not filled.

use raypath_hdl::text::{PAYLOAD, Template};
use raypath_hdl::{Builder, Error, Module, Wire, verilog};
use std::sync::Arc;

/// Connects the parts of a unit by registers, with a handshake and a tag beside the data: the ports of
/// [`DivSqrt::pipelined`](crate::DivSqrt::pipelined). Units whose tags differ in their width have one text.
pub(crate) fn pipeline(name: &str, doc: &str, parts: &[Arc<Module>], tag_width: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new(&if tag_width > 0 { format!("{name}_t{tag_width}") } else { name.to_string() });
    builder.doc(doc);
    if (1..PAYLOAD).contains(&tag_width) {
        let any = Builder::new(&format!("{name}_tagged"));
        any.parameterise_width();
        let any = connected(any, parts, PAYLOAD)?;
        let ports = any.inputs().iter().chain(any.outputs());
        builder.template(Template {
            module: any.name().to_string(),
            doc: doc.to_string(),
            text: verilog::print_module(&any, &[])?,
            parameters: vec![("Width", tag_width)],
            ports: ports.map(|port| (port.name.clone(), vec![port.name.clone()])).collect(),
        });
    }
    connected(builder, parts, tag_width)
}

/// The text of the quotient's pipeline with any tag, by the name of its module, in which a loop has the digits of the parts
/// between the first and the last; none if there are none between.
pub(crate) fn looped(name: &str, parts: &[Arc<Module>]) -> Result<Option<(String, String)>, Error> {
    let [first, between @ .., last] = parts else { return Ok(None) };
    if between.is_empty() {
        return Ok(None);
    }
    let any = Builder::new(&format!("{name}_tagged"));
    any.parameterise_width();
    let any = connected(any, parts, PAYLOAD)?;
    let printed = verilog::print_module(&any, &[])?;
    let ports = printed.split_once("\n);\n").map_or("", |(ports, _)| ports);
    let width = |module: &Module, port: &str| module.port_width(port).unwrap_or_default();
    let known = parts.iter().rev().skip(1).map(|part| format!("8'd{}", width(part, "digits_o")));
    let of_first = |port: &str| (width(first, port) - 1).to_string();
    let values = [
        ("PARTS", parts.len().to_string()),
        ("REST", width(first, "remainder_o").to_string()),
        ("KNOWN", known.collect::<Vec<_>>().join(", ")),
        ("LAST_RESULT", (width(last, "result_o") - 1).to_string()),
        ("LAST_EXPONENT", of_first("exponent_o")),
        ("LAST_DIVISOR", of_first("divisor_o")),
        ("FIRST", first.name().to_string()),
        ("LAST", last.name().to_string()),
    ];
    let body = include_str!("raypath_div_pipelined.sv").to_string();
    let body = values.iter().fold(body, |body, (name, value)| body.replace(&format!("@{name}@"), value));
    Ok(Some((any.name().to_string(), format!("{ports}\n);\n{body}endmodule : {}\n", any.name()))))
}

fn connected(m: Builder, parts: &[Arc<Module>], tag_width: u32) -> Result<Arc<Module>, Error> {
    let mut valid = m.input("valid_i", 1);
    let ready = m.input("ready_i", 1);
    let operands = parts.first().map_or_else(Vec::new, |first| first.inputs().to_vec());
    let width = |part: &Module, port: &str| part.port_width(port).unwrap_or_default();
    let mut values: Vec<(String, Wire<'_>)> =
        operands.iter().map(|port| (port.name.clone(), m.input(&port.name, width(&parts[0], &port.name)))).collect();
    let mut tag = (tag_width > 0).then(|| m.input("tag_i", tag_width));

    let advance = m.forward("advance", 1);
    for (number, part) in (1..).zip(parts) {
        m.section(format!("Part {number}"));
        let register = |stem: &str, wire: Wire<'_>| {
            let register = m.register(&format!("{stem}_{number}_q"), wire.width());
            register.next_when(advance.wire(), wire);
            register.wire()
        };
        let stage_valid = m.register(&format!("valid_{number}_q"), 1).reset_to(0);
        stage_valid.next_when(advance.wire(), valid);
        valid = stage_valid.wire();
        tag = tag.map(|tag| register("tag", tag));
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{number}"), part, &connected);
        let stems = part.outputs().iter().map(|port| port.name.strip_suffix("_o").unwrap_or(&port.name));
        values = stems.zip(outputs).map(|(stem, wire)| (format!("{stem}_i"), register(stem, wire))).collect();
    }
    m.section("A result that waits stops all parts");
    advance.drive(!valid | ready);
    m.output("ready_o", advance.wire());
    m.output("valid_o", valid);
    values.iter().for_each(|(name, wire)| m.output(&format!("{}_o", name.trim_end_matches("_i")), *wire));
    tag.into_iter().for_each(|tag| m.output("tag_o", tag));
    m.finish()
}
