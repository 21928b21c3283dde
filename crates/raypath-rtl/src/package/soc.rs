//! Files for the flow of a system around a design: constraints (SDC, XDC) and a component of IP-XACT.

use super::Files;
use super::text::{licensed, yaml_head};
use raypath_hdl::Module;
use raypath_hdl::text::TextPort;
use raypath_hdl::verilog::CLOCK_GATE;

/// The default clock period in nanoseconds, for constraints and for the choice of gates.
pub const PERIOD_NS: f64 = 12.0;

/// The share of the period, in percent, that the logic outside has before an input and after an output.
const OUTSIDE: u32 = 30;

/// What the constraints add for gated clocks. Vivado does not have the command.
const GATED: &str = "
# Gated clocks: an enable is stable while the clock is high. A library's clock gate adds its own
# set-up and hold times.
set_clock_gating_check -setup 0 -hold 0 [get_clocks clk_i]
";

/// `<module>.sdc`, `<module>.xdc` and `<module>.xml` of the module `top`, whose text and that of all modules below it is
/// in `sources`. `purpose` says what it is.
pub fn files(top: &Module, sources: &[String], purpose: &str, banner: &[String], period_ns: f64) -> Files {
    let (name, ports) = (top.name(), all_ports(top));
    let is_gated = sources.iter().any(|source| source.contains(CLOCK_GATE));
    let common = yaml_head(banner) + "#\n" + &constraints(name, &ports, period_ns);
    let sdc = common.clone() + if is_gated { GATED } else { "" };
    let xml = component(name, &ports, sources, purpose, banner);
    [("sdc", sdc), ("xdc", common), ("xml", xml)].map(|(kind, text)| (format!("{name}.{kind}").into(), text)).into()
}

/// The ports in the text of a top module, clock and reset first.
pub fn all_ports(top: &Module) -> Vec<TextPort> {
    let clocks = ["clk_i", "rst_ni"].map(|name| TextPort { name: name.to_string(), width: 1, is_input: true });
    clocks.into_iter().chain(top.text_ports()).collect()
}

fn constraints(module: &str, ports: &[TextPort], period_ns: f64) -> String {
    let list = |is_input: bool| -> String {
        let ports = ports.iter().filter(|port| port.is_input == is_input && port.name != "clk_i");
        let names: Vec<_> = ports.map(|port| port.name.clone() + if port.width == 1 { "" } else { "[*]" }).collect();
        names.chunks(4).map(|row| format!("  {}\n", row.join(" "))).collect()
    };
    // Whole picoseconds.
    let outside = (period_ns * f64::from(OUTSIDE) * 10.0).round() / 1000.0;
    let values = [("PERIOD", period_ns.to_string()), ("SHARE", OUTSIDE.to_string()), ("OUTSIDE", outside.to_string())];
    let lists = [("MODULE", module.to_string()), ("INPUTS", list(true)), ("OUTPUTS", list(false))];
    filled(include_str!("constraints.sdc"), &[values, lists].concat())
}

/// The component of IP-XACT (IEEE 1685-2014).
fn component(module: &str, ports: &[TextPort], sources: &[String], purpose: &str, banner: &[String]) -> String {
    let port = |TextPort { name, width, is_input }: &TextPort| {
        let vector = element("left", &(width - 1).to_string()) + &element("right", "0");
        let vectors = if *width == 1 { String::new() } else { element("vectors", &element("vector", &vector)) };
        let wire = element("direction", if *is_input { "in" } else { "out" }) + &vectors;
        format!("      {}\n", element("port", &(element("name", name) + &element("wire", &wire))))
    };
    let file = |path: &String| {
        let file = element("name", path) + &element("fileType", "systemVerilogSource");
        format!("      {}\n", element("file", &file))
    };
    let values = [
        // Two dashes end a comment of XML.
        ("BANNER", licensed(banner).join("\n").replace("--", "- -")),
        ("MODULE", module.to_string()),
        ("VERSION", env!("CARGO_PKG_VERSION").to_string()),
        ("AXI", axi(ports)),
        ("PORTS", ports.iter().map(port).collect()),
        ("FILES", sources.iter().map(file).collect()),
        ("PURPOSE", purpose.to_string()),
    ];
    filled(include_str!("component.xml"), &values)
}

/// The interface of the AXI4 master and its address space; without one, only the end of the list of interfaces.
fn axi(ports: &[TextPort]) -> String {
    let width = |name: &str| ports.iter().find(|port| port.name == name).map(|port| port.width.to_string());
    let (Some(address), Some(data)) = (width("m_axi_araddr"), width("m_axi_rdata")) else {
        return "  </ipxact:busInterfaces>\n".to_string();
    };
    let map = |port: &TextPort| {
        let side = |side, name: &str| element(side, &element("name", name));
        let logical = port.name.strip_prefix("m_axi_")?.to_uppercase();
        let map = side("logicalPort", &logical) + &side("physicalPort", &port.name);
        Some(format!("            {}\n", element("portMap", &map)))
    };
    let maps = ports.iter().filter_map(map).collect();
    filled(include_str!("axi.xml"), &[("MAPS", maps), ("ADDRESS", address), ("DATA", data)])
}

fn element(name: &str, content: &str) -> String {
    format!("<ipxact:{name}>{content}</ipxact:{name}>")
}

/// A template with values in the places of their names.
fn filled(template: &str, values: &[(&str, String)]) -> String {
    values.iter().fold(template.to_string(), |text, (name, value)| text.replace(&format!("@{name}@"), value))
}
