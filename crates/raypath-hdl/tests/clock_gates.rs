//! Registers behind clock gates: their text, and that they do what registers with enables do.

use raypath_hdl::{Builder, Module, Simulator, verilog, with_enables};
use std::sync::Arc;

/// Two registers behind one gate, one of them with a reset, and one behind another.
fn gated() -> Arc<Module> {
    let m = Builder::new("gated");
    let (load, data) = (m.input("load_i", 1), m.input("data_i", 8));
    m.section("Registers");
    let keep = (!load & data.top()).named("keep");
    let [first, second, kept] = ["first_q", "second_q", "kept_q"].map(|name| m.register(name, 8));
    let second = second.reset_to(3);
    first.next_gated(load, data);
    second.next_gated(load, first.wire());
    kept.next_gated(keep, second.wire());
    m.output("kept_o", kept.wire());
    m.finish().expect("a module")
}

#[test]
fn the_text_has_a_gate_for_each_enable() {
    let sources = verilog::sources(&gated(), &["a banner".to_string()]).expect("a text");
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, [verilog::CLOCK_GATE, "gated"]);
    assert!(sources[0].text.starts_with("// SPDX-License-Identifier: MIT OR Apache-2.0\n// a banner\n//\n// A clock"));
    let expected = "
  assign keep = ~load_i & data_i[7];

  raypath_clock_gate u_gate_load_i (.clk_i, .enable_i (load_i), .clk_o (clk_load_i));

  always_ff @(posedge clk_load_i) begin
    first_q <= data_i;
  end

  always_ff @(posedge clk_load_i or negedge rst_ni) begin
    if (!rst_ni) second_q <= 8'd3;
    else second_q <= first_q;
  end

  raypath_clock_gate u_gate_keep (.clk_i, .enable_i (keep), .clk_o (clk_keep));

  always_ff @(posedge clk_keep) begin
    kept_q <= second_q;
  end
";
    assert!(sources[1].text.contains(expected), "{}", sources[1].text);
    for clock in ["clk_load_i", "clk_keep"] {
        assert_eq!(sources[1].text.matches(&format!("logic       {clock};")).count(), 1, "{}", sources[1].text);
    }
}

#[test]
fn a_gate_is_an_enable() {
    let (module, text) = (gated(), verilog::text(&with_enables(&gated())).expect("a text"));
    assert!(text.contains("if (load_i) ") && !text.contains(verilog::CLOCK_GATE), "{text}");
    let mut simulator = Simulator::new(&module).expect("a simulator");
    for (loads, value, expected) in [(0, 128, 0), (1, 7, 3), (1, 9, 3), (0, 0, 3), (0, 255, 3), (0, 0, 7)] {
        assert_eq!(simulator.evaluate([loads, value]), [expected]);
        simulator.cycle();
    }
}

#[test]
fn a_gate_needs_a_name_that_is_free() {
    let m = Builder::new("bad");
    let load = m.input("load_i", 1);
    m.register("a_q", 1).next_gated(!load, load);
    let error = m.finish().expect_err("an enable without a name").to_string();
    assert_eq!(error, "module bad: 'Not 2' gates a clock, expected a name");
    let m = Builder::new("bad");
    let load = m.input("load_i", 1);
    m.input("clk_load_i", 1);
    m.register("a_q", 1).next_gated(load, load);
    assert_eq!(m.finish().expect_err("a name twice").to_string(), "module bad: name 'clk_load_i' is taken");
}
