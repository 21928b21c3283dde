//! The wrapper with an AXI4 read master has the unit's behaviour, and the linters have nothing to say about it.

use raypath_hdl::{Driver, Module, SignalId};
use raypath_rtl::Config;
use raypath_tools::{Sources, lint_verilator};
use raypath_traversal::{StepParameters, UnitFeatures, UnitNetlist, UnitParameters};

/// The port of the wrapper for one of the unit.
fn of_wrapper(port: &str) -> String {
    let Some(memory) = port.strip_prefix("mem_") else { return port.to_string() };
    let axi = match memory {
        "req_valid_o" => "arvalid",
        "req_ready_i" => "arready",
        "req_addr_o" => "araddr",
        "req_tag_o" => "arid",
        "rsp_valid_i" => "rvalid",
        "rsp_ready_o" => "rready",
        "rsp_tag_i" => "rid",
        "rsp_error_i" => "rresp",
        data => return format!("m_axi_r{}", data.trim_start_matches("rsp_").trim_end_matches("_i")),
    };
    format!("m_axi_{axi}")
}

fn netlists(
    contexts: u32,
    memory_width: u32,
    address_width: u32,
    features: UnitFeatures,
) -> (UnitNetlist, std::sync::Arc<Module>) {
    let step = StepParameters { features, ..StepParameters::default() };
    let parameters =
        UnitParameters { contexts, memory_width, id_width: 9, address_width, step, ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let axi = unit.axi().expect("a wrapper");
    (unit, axi)
}

/// With addresses of so many bits that a ray brings some of them, with every feature, and with all that parameters add.
#[test]
fn the_linters_are_silent() {
    let (unit, axi) = netlists(65, 128, 40, UnitFeatures::ALL);
    assert_eq!(axi.port_width("m_axi_araddr"), Some(40));
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&axi, folder.path()).expect("sources");
    sources.lint().expect("no report of the linters");
    let wrapper = sources.files.last().expect("the wrapper").clone();
    let text = std::fs::read_to_string(&wrapper).expect("a text");
    let defaults = ["Contexts       = 65", "Units          = 1", "CacheSets      = 0", "Timeout        = 0"];
    let values = ["Contexts       = 12", "Units          = 3", "CacheSets      = 8", "Timeout        = 9"];
    let other = defaults.iter().zip(values).fold(text.clone(), |text, (from, to)| text.replacen(from, to, 1));
    assert_eq!(defaults.map(|default| other.contains(default)), [false; 4]);
    std::fs::write(&wrapper, other).expect("a text");
    sources.lint().expect("no report of the linters with other parameters");
    std::fs::write(&wrapper, text).expect("a text");
    sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
    let arguments = ["--assert", "-Wno-DECLFILENAME"];
    lint_verilator(&sources.files, axi.name(), &arguments).expect("nor of Verilator with the assertions");
}

/// The text of a unit is that of any other with parameters, but for their defaults.
#[test]
fn the_text_is_that_of_other_parameters() {
    let text = |contexts, id_width, address_width| {
        let parameters = UnitParameters { contexts, id_width, address_width, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let files = unit.files(raypath_rtl::package::PERIOD_NS).expect("files").into_iter();
        let modules =
            files.filter(|(path, _)| path.starts_with("rtl") && !path.ends_with("raypath_unit_wrapper_pkg.sv"));
        let is_common = |line: &&str| !line.starts_with("//") && !line.starts_with("  parameter ");
        let lines = modules.map(|(path, text)| (path, text.lines().filter(is_common).collect::<Vec<_>>().join("\n")));
        lines.collect::<std::collections::BTreeMap<_, _>>()
    };
    let (one, other) = (text(64, 16, 40), text(40, 9, 60));
    let checks = |text: &str| text.replace("Contexts > 64", "Contexts > 40").replace("8 to 64", "8 to 40");
    for (path, text) in one {
        for (line, other) in checks(&text).lines().zip(checks(&other[&path]).lines()) {
            assert_eq!(line, other, "{}", path.display());
        }
        assert_eq!(text.lines().count(), other[&path].lines().count(), "{}", path.display());
    }
}

/// With its default parameters the wrapper is a cluster of one unit, and both are wires alone, so that they do what the
/// unit does with any inputs: each port is that of the module inside, but for the error of a response, which is any
/// response that is not OKAY, and for signals that are constant.
#[test]
fn the_wrapper_connects_the_ports_of_the_unit_and_nothing_else() {
    for (memory_width, length, size) in [(128, 7, 4), (256, 3, 5), (512, 1, 6), (1024, 0, 7)] {
        let (unit, axi) = netlists(8, memory_width, 64, UnitFeatures::OFF);
        let cluster = unit.cluster().expect("a cluster");
        is_around(&axi, &cluster, of_wrapper, &|port| {
            let constants = [("len", length), ("size", size), ("burst", 1), ("cache", 3), ("prot", 2)];
            let constant = constants.into_iter().find(|(name, _)| port == format!("m_axi_ar{name}"));
            let zeros = ["m_axi_arlock", "m_axi_arqos", "m_axi_aruser", "timed_out_o"];
            constant.map(|(_, value)| value).or(zeros.contains(&port).then_some(0))
        });
        is_around(&cluster, &unit.top, str::to_string, &|port| port.starts_with("count_cache_").then_some(0));
    }
}

fn is_around(
    outer: &Module,
    inner: &Module,
    outer_name: impl Fn(&str) -> String,
    constant: &dyn Fn(&str) -> Option<u64>,
) {
    let [instance] = outer.instances() else { panic!("one instance") };
    assert_eq!((outer.registers().len(), outer.memories().len(), instance.module.name()), (0, 0, inner.name()));
    let input = |signal: SignalId| outer.inputs().iter().find(|port| port.signal == signal).map(|port| &port.name);
    for (port, &signal) in inner.inputs().iter().zip(&instance.inputs) {
        let wire = match outer.signal(signal).driver {
            Driver::Any(response) if port.name == "mem_rsp_error_i" => response,
            _ => signal,
        };
        assert_eq!(input(wire), Some(&outer_name(&port.name)), "{}", port.name);
    }
    let mut connected = 0;
    for port in outer.outputs() {
        match (constant(&port.name), &outer.signal(port.signal).driver) {
            (Some(value), driver) => assert_eq!(*driver, Driver::Constant(value), "{}", port.name),
            (None, Driver::Instance { output, .. }) => {
                assert_eq!(outer_name(&inner.outputs()[*output].name), port.name);
                connected += 1;
            }
            _ => panic!("{}", port.name),
        }
    }
    assert_eq!(connected, inner.outputs().len());
}
