//! The wrapper with an AXI4 read master has the unit's behaviour, and the linters have nothing to say about it.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Module, Simulator};
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

fn netlists(contexts: u32, memory_width: u32) -> (UnitNetlist, std::sync::Arc<Module>) {
    let parameters = UnitParameters { contexts, memory_width, id_width: 9, ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let axi = unit.axi().expect("a wrapper");
    (unit, axi)
}

#[test]
fn the_linters_are_silent() {
    for (contexts, memory_width) in [(8, 1024), (65, 128)] {
        let (unit, axi) = netlists(contexts, memory_width);
        let folder = tempfile::tempdir().expect("a folder");
        let mut sources = Sources::write(&axi, folder.path()).expect("sources");
        sources.lint().expect("no report of the linters");
        sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
        let arguments = ["--assert", "-Wno-DECLFILENAME"];
        lint_verilator(&sources.files, axi.name(), &arguments).expect("nor of Verilator with the assertions");
    }
}

/// Random values at all inputs, also of channels that are not valid. Every other ray is a tame one, so that rays
/// traverse.
#[test]
fn the_wrapper_equals_the_unit_in_every_cycle() {
    for (memory_width, length, size) in [(128, 7, 4), (256, 3, 5), (512, 1, 6), (1024, 0, 7)] {
        let (unit, axi) = netlists(8, memory_width);
        let (mut plain, mut wrapped) =
            (Simulator::new(&unit.top).expect("a simulation"), Simulator::new(&axi).expect("a simulation"));
        let mut random = ChaCha8Rng::seed_from_u64(memory_width.into());
        let (mut requests, mut hits) = (0, 0);
        for _ in 0..3_000 {
            for port in unit.top.inputs() {
                let width = unit.top.signal(port.signal).width;
                let value = match port.name.as_str() {
                    name if name.starts_with("ray_origin") || name.starts_with("ray_dir") => {
                        random.random_range(-2.0_f32..2.0).to_bits().into()
                    }
                    "ray_tmin_i" => 0,
                    "ray_tmax_i" => f32::INFINITY.to_bits().into(),
                    "ray_root_i" => 32 | u64::from(random.random::<u32>()) << 7 & 0xffff_ff80,
                    _ => random.random::<u64>() & u64::MAX >> (64 - width),
                };
                plain.set(plain.input(&port.name).expect("a port"), value);
                let of_axi = if port.name == "mem_rsp_error_i" { value * random.random_range(1..4) } else { value };
                wrapped.set(wrapped.input(&of_wrapper(&port.name)).expect("a port"), of_axi);
            }
            wrapped.set(wrapped.input("m_axi_rlast").expect("a port"), random.random_range(0..2));
            plain.settle();
            wrapped.settle();
            let of_axi = |name: &str| wrapped.get(wrapped.output(name).expect("a port"));
            for port in unit.top.outputs() {
                let found = of_axi(&of_wrapper(&port.name));
                assert_eq!(found, plain.get(plain.output(&port.name).expect("a port")), "{}", port.name);
            }
            let shape = ["arlen", "arsize", "arburst", "arcache", "arprot"].map(|end| of_axi(&format!("m_axi_{end}")));
            assert_eq!(shape, [length, size, 1, 3, 0]);
            requests += of_axi("m_axi_arvalid");
            hits += of_axi("hit_valid_o");
            plain.cycle();
            wrapped.cycle();
        }
        assert!(requests > 50 && hits > 50, "{requests} cycles with requests, {hits} with hits");
    }
}
