//! The wrapper with an AXI4 read master has the unit's behaviour, and the linters have nothing to say about it.

use raypath_hdl::{Driver, Module, SignalId};
use raypath_rtl::Config;
use raypath_tools::{Sources, lint_verilator};
use raypath_traversal::{UnitNetlist, UnitParameters};

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

fn netlists(contexts: u32, memory_width: u32, address_width: u32) -> (UnitNetlist, std::sync::Arc<Module>) {
    let parameters = UnitParameters { contexts, memory_width, id_width: 9, address_width, ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let axi = unit.axi().expect("a wrapper");
    (unit, axi)
}

/// With addresses of so many bits that a ray brings some of them.
#[test]
fn the_linters_are_silent() {
    let (unit, axi) = netlists(65, 128, 40);
    assert_eq!(axi.port_width("m_axi_araddr"), Some(40));
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&axi, folder.path()).expect("sources");
    sources.lint().expect("no report of the linters");
    sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
    let arguments = ["--assert", "-Wno-DECLFILENAME"];
    lint_verilator(&sources.files, axi.name(), &arguments).expect("nor of Verilator with the assertions");
}

/// The wrapper is wires alone, so that it does what the unit does with any inputs: each of its ports is that of the unit,
/// but for the error of a response, which is any response that is not OKAY, and for signals that are constant.
#[test]
fn the_wrapper_connects_the_ports_of_the_unit_and_nothing_else() {
    for (memory_width, length, size) in [(128, 7, 4), (256, 3, 5), (512, 1, 6), (1024, 0, 7)] {
        let (unit, axi) = netlists(8, memory_width, 64);
        let [instance] = axi.instances() else { panic!("one instance") };
        assert_eq!((axi.registers().len(), axi.memories().len(), instance.module.name()), (0, 0, unit.top.name()));
        let input = |signal: SignalId| axi.inputs().iter().find(|port| port.signal == signal).map(|port| &port.name);
        for (port, &signal) in unit.top.inputs().iter().zip(&instance.inputs) {
            let wire = match axi.signal(signal).driver {
                Driver::Any(response) if port.name == "mem_rsp_error_i" => response,
                _ => signal,
            };
            assert_eq!(input(wire), Some(&of_wrapper(&port.name)), "{}", port.name);
        }
        let mut connected = 0;
        for port in axi.outputs() {
            let signal = axi.signal(port.signal);
            let constants =
                [("len", length), ("size", size), ("burst", 1), ("lock", 0), ("cache", 3), ("prot", 0), ("qos", 0)];
            match constants.into_iter().find(|(name, _)| port.name == format!("m_axi_ar{name}")) {
                Some((_, value)) => assert_eq!(signal.driver, Driver::Constant(value), "{}", port.name),
                None => {
                    let Driver::Instance { output, .. } = signal.driver else { panic!("{}", port.name) };
                    assert_eq!(of_wrapper(&unit.top.outputs()[output].name), port.name);
                    connected += 1;
                }
            }
        }
        assert_eq!(connected, unit.top.outputs().len());
    }
}
