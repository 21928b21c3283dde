//! Ready is registered: the source does not observe the sink in the same cycle, nor the sink the source.

use raypath::hdl::{Builder, Module, depends_combinationally};
use raypath::rtl::{Config, Control, DatapathNetlist, Interval, Lanes, UnitLatency};
use std::sync::Arc;

fn depends(module: &Arc<Module>, output: &str, input: &str) -> bool {
    depends_combinationally(module, output, input).unwrap()
}

#[test]
fn the_handshakes_do_not_see_each_other() {
    for config in configurations() {
        let datapath = DatapathNetlist::new(config).unwrap();
        for input in ["output_ready_i", "input_valid_i", "opcode_i"] {
            for output in ["input_ready_o", "output_valid_o", "opcode_o"] {
                // If no job can wait inside, the ready of a beat depends on its operation.
                let expected = (output, input) == ("input_ready_o", "opcode_i")
                    && config.microarchitecture.control == Control::Credit
                    && loops(config);
                assert_eq!(depends(datapath.top(), output, input), expected, "{output} from {input}, {config}");
            }
        }
    }
}

fn configurations() -> Vec<Config> {
    let mut all = Vec::new();
    for lanes in [Lanes::None, Lanes::Two] {
        for &control in Control::ALL {
            let config = Config::DEFAULT.lanes(lanes).control(control);
            all.extend(UnitLatency::REPRESENTATIVES.map(|unit_latency| config.unit_latency(unit_latency)));
            all.extend(Interval::ALL.iter().map(|&interval| config.interval(interval)));
        }
    }
    all
}

fn loops(config: Config) -> bool {
    config.semantics.lanes != Lanes::None && config.microarchitecture.unit_latency != UnitLatency::ONE
}

/// Inputs and outputs are registered: no output port depends on the sink's ready, and ready depends on no input port.
#[test]
fn no_port_passes_through() {
    let datapath = DatapathNetlist::new(Config::default()).unwrap();
    let top = datapath.top();
    for output in top.outputs() {
        assert!(!depends(top, &output.name, "output_ready_i"), "{}", output.name);
        assert!(!depends(top, &output.name, "input_valid_i"), "{}", output.name);
    }
    for input in top.inputs().iter().filter(|port| !["clk_i", "rst_ni"].contains(&port.name.as_str())) {
        assert!(!depends(top, "input_ready_o", &input.name), "{}", input.name);
    }
    for (output, input) in
        [("tmin_0_o", "aabb_0_x_min_i"), ("t_num_o", "triangle_a_x_i"), ("euclidean_accumulator_o", "euclidean_a_0_i")]
    {
        assert!(!depends(top, output, input), "{output} from {input}");
    }
}

/// Negative control: a stage with one register, whose ready is the sink's ready or an empty register, has such a
/// path.
#[test]
fn a_stage_without_a_skid_register_has_such_a_path() {
    let m = Builder::new("one_register");
    let (valid, ready) = (m.input("input_valid_i", 1), m.input("output_ready_i", 1));
    let valid_q = m.register("valid_q", 1).reset_to(0);
    let free = !valid_q.wire() | ready;
    valid_q.next_when(free, valid);
    m.output("input_ready_o", free);
    m.output("output_valid_o", valid_q.wire());
    let module = m.finish().unwrap();
    assert!(depends(&module, "input_ready_o", "output_ready_i"));
    assert!(!depends(&module, "output_valid_o", "input_valid_i"));
}
