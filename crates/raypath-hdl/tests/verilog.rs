//! The printed text.

use raypath_hdl::text::{Enumeration, Package, PortGroup, plain};
use raypath_hdl::{Builder, Label, Module, verilog};
use std::sync::Arc;

fn label(name: &str, value: u64) -> Label {
    Label { name: name.to_string(), value }
}

fn adder() -> Arc<Module> {
    let m = Builder::new("adder");
    m.doc("A sum and its carry.");
    let (a, b) = (m.input("a_i", 8), m.input("b_i", 8));
    let sum = (a.extend(9) + b.extend(9)).named("sum");
    m.output("sum_o", sum.lower(8));
    m.output("carry_o", sum.top());
    m.finish().unwrap()
}

fn unit() -> Arc<Module> {
    let m = Builder::new("unit");
    m.doc("Adds what the opcode selects, and counts sums that overflow.");
    m.doc("Everything that the printer knows is in here.");
    let valid = m.input("valid_i", 1).comment("the operands are meant");
    let opcode = m.input("opcode_i", 2);
    let left = m.input("left_i", 8).comment("unsigned");
    let right = m.input("right_i", 8);
    let ready = m.forward("ready", 1);

    m.section("Operands");
    let alone = [(label("OpAdd", 0), left), (label("OpDouble", 1), left), (label("OpNext", 2), left)];
    let first = m.case(opcode, &alone, m.constant(8, 0)).named("first").comment("what is added to");
    let others = [(label("OpAdd", 0), right), (label("OpDouble", 1), left), (label("OpNext", 2), m.constant(8, 1))];
    let second = m.case(opcode, &others, m.constant(8, 0)).named("second");

    m.section("Sum");
    let sum = m.instance("u_adder", &adder(), &[("a_i", first), ("b_i", second)]);
    let twice = m.instance("u_twice", &adder(), &[("a_i", sum[0]), ("b_i", !sum[0])]);

    m.section("State");
    let held = m.register("held_q", 8);
    let twin = m.register("twin_q", 8);
    let overflows = m.register("overflows_q", 16).reset_to(0);
    let full = m.register("full_q", 1).reset_to(1);
    let take = valid & ready.wire();
    held.next_when(take, sum[0]);
    twin.next_when(take, twice[0] ^ held.wire());
    overflows.next_when(take, overflows.wire() + sum[1].extend(16));
    full.next((full.wire() & !valid) | take);
    ready.drive(!full.wire() | (opcode.equals(m.constant(2, 3)) & overflows.wire().upper(4).any()));

    m.section("Product");
    let product = (held.wire() * twin.wire()).named("product");
    let long = (product & overflows.wire()) + (product | overflows.wire()) - held.wire().top().replicate(16);
    let shifted = (long ^ product.shift_left(opcode)).named("shifted");
    m.unused("unused_product", &[shifted.upper(8)]);

    m.output("ready_o", ready.wire());
    m.output("low_o", shifted.lower(8));
    m.output("choice_o", m.case(opcode, &[(label("OpNext", 2), held.wire())], twin.wire()));
    m.output("bias_o", m.constant(32, 0x3f80_0000));
    m.output("less_o", (held.wire() + left).less(twin.wire() - right));
    m.finish().unwrap()
}

fn text(module: &Module) -> String {
    verilog::print_module(module, &["raypath, a sample".to_string()]).unwrap()
}

/// Asserts that the text of a module contains `fragment`, with its lines and indentation.
fn assert_prints(module: &Module, fragment: &str) {
    let text = text(module);
    assert!(text.contains(fragment), "no\n{fragment}\nin\n{text}");
}

#[test]
fn a_module_as_a_whole() {
    let expected = "\
// raypath, a sample
//
// A sum and its carry.

module adder (
  input  logic [7:0] a_i,
  input  logic [7:0] b_i,
  output logic [7:0] sum_o,
  output logic       carry_o
);

  logic [8:0] sum;

  assign sum = {1'b0, a_i} + {1'b0, b_i};

  assign sum_o   = sum[7:0];
  assign carry_o = sum[8];

endmodule : adder
";
    assert_eq!(text(&adder()), expected);
}

#[test]
fn ports_and_remarks_are_aligned() {
    assert_prints(
        &unit(),
        "\
module unit (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic        valid_i,   // the operands are meant
  input  logic [1:0]  opcode_i,
",
    );
}

#[test]
fn cases_of_one_selector_share_a_block_and_labels_are_declared_once() {
    assert_prints(
        &unit(),
        "\
  localparam logic [1:0] OpAdd    = 2'd0;
  localparam logic [1:0] OpDouble = 2'd1;
  localparam logic [1:0] OpNext   = 2'd2;

",
    );
    assert_prints(
        &unit(),
        "\
  always_comb begin
    case (opcode_i)
      OpAdd: begin
        first  = left_i;
        second = right_i;
      end
",
    );
    assert_prints(
        &unit(),
        "\
    case (opcode_i)
      OpNext:  choice_o = held_q;
      default: choice_o = twin_q;
    endcase
",
    );
}

#[test]
fn cases_that_depend_on_each_other_have_blocks_of_their_own() {
    let m = Builder::new("chain");
    let (select, a) = (m.input("select_i", 1), m.input("a_i", 4));
    let one = m.case(select, &[(label("OpOne", 1), a)], !a).named("one");
    let two = m.case(select, &[(label("OpOne", 1), one + a)], a).named("two");
    m.output("two_o", two);
    let text = text(&m.finish().unwrap());
    assert_eq!(text.matches("always_comb").count(), 2, "{text}");
}

#[test]
fn registers_of_one_kind_share_a_block_at_their_sections_end() {
    assert_prints(
        &unit(),
        "\
  assign held_en = valid_i & ready;

  always_ff @(posedge clk_i) begin
    if (held_en) begin
      held_q <= adder_sum;
      twin_q <= twice_sum ^ held_q;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) overflows_q <= '0;
    else if (held_en) overflows_q <= overflows_q + {15'd0, adder_carry};
  end
",
    );
}

#[test]
fn an_unread_output_is_named_unused() {
    assert_prints(&unit(), "  logic       unused_twice_carry;\n");
    assert_prints(&unit(), ", .carry_o (unused_twice_carry)\n");
    assert_prints(&unit(), "  assign unused_product = ^shifted[15:8];\n");
}

#[test]
fn expressions_stay_short_and_mean_the_same() {
    assert_prints(&unit(), "  assign product        = 16'(held_q) * 16'(twin_q);\n");
    assert_prints(
        &unit(),
        "= (((product & overflows_q) + (product | overflows_q)) - {16{held_q[7]}}) ^\n      (product << opcode_i);\n",
    );
    assert_prints(&unit(), "= 32'h3f80_0000;\n");
}

/// `data_i[15:8][3:2]` is no SystemVerilog, and Yosys and Verilator read different bits of it.
#[test]
fn a_range_of_a_part_of_a_port_is_one_range() {
    let m = Builder::new("parts");
    let (high, low) = (m.input("data_1_i", 8), m.input("data_0_i", 8));
    let members = [("data_1_i", "[15:8]"), ("data_0_i", "[7:0]")].map(|(port, part)| (port.into(), part.into()));
    let structure = "logic [15:0]".to_string();
    m.group_inputs(PortGroup { name: "data_i".to_string(), structure, members: members.into() });
    m.output("parts_o", m.concat(&[high.bits(3, 2), low.bit(5), high]));
    assert_prints(&m.finish().unwrap(), "assign parts_o = {data_i[11:10], data_i[5:5], data_i[15:8]};");
}

#[test]
fn signals_read_before_their_section_are_declared_before() {
    let text = text(&unit());
    let place = |fragment: &str| text.find(fragment).unwrap();
    assert!(place("logic [15:0] overflows_q;") < place("assign ready ="), "{text}");
    assert_eq!(text.matches("logic [15:0] overflows_q;").count(), 1);
}

#[test]
fn made_names_avoid_given_ones() {
    let m = Builder::new("crowded");
    let a = m.input("a_i", 4);
    let sum = (a + a).named("x_d");
    let register = m.register("x_q", 4);
    let both = sum & (register.wire() ^ a);
    register.next(both);
    m.output("y_o", both);
    assert_prints(&m.finish().unwrap(), "  assign x_d_2 = x_d & (x_q ^ a_i);\n");
}

#[test]
fn comments_cannot_leave_their_lines() {
    let m = Builder::new("remarks");
    m.doc("first\nsecond");
    m.section("over\ntwo lines");
    let a = m.input("a_i", 1).comment("a\nb");
    m.output("a_o", (!a).named("inverted"));
    let text = text(&m.finish().unwrap());
    for fragment in ["// first\n// second\n", "// ---- over two lines ---", "// a b\n"] {
        assert!(text.contains(fragment), "no {fragment} in\n{text}");
    }
}

#[test]
fn modules_come_once_and_before_their_readers() {
    let names: Vec<String> = verilog::modules(&unit()).unwrap().iter().map(|m| m.name().to_string()).collect();
    assert_eq!(names, ["adder", "unit"]);
    assert_eq!(text(&unit()), text(&unit()));
}

#[test]
fn two_modules_of_one_name_are_refused() {
    let inner = |constant: u64| {
        let m = Builder::new("inner");
        m.output("x_o", m.constant(4, constant));
        m.finish().unwrap()
    };
    let both = |one: &Arc<Module>, other: &Arc<Module>| {
        let m = Builder::new("outer");
        m.output("x_o", m.instance("u_one", one, &[])[0] ^ m.instance("u_other", other, &[])[0]);
        verilog::modules(&m.finish().unwrap())
    };
    assert_eq!(both(&inner(1), &inner(1)).unwrap().len(), 2);
    let error = both(&inner(1), &inner(2)).unwrap_err();
    assert_eq!(error.to_string(), "module inner: name 'inner' is the name of two different modules");
}

#[test]
fn labels_are_declared_by_value() {
    let m = Builder::new("labels");
    let (select, a) = (m.input("select_i", 2), m.input("a_i", 1));
    let arms = [(label("OpThree", 3), a), (label("OpOne", 1), !a), (label("OpTwo", 2), a)];
    m.output("a_o", m.case(select, &arms, !a));
    assert_prints(
        &m.finish().unwrap(),
        "\
  localparam logic [1:0] OpOne   = 2'd1;
  localparam logic [1:0] OpTwo   = 2'd2;
  localparam logic [1:0] OpThree = 2'd3;
",
    );
}

#[test]
fn empty_lines_of_a_head_comment_stay() {
    let m = Builder::new("remarks");
    m.doc("First.");
    m.doc("");
    m.doc("Third.\n\nFifth.");
    assert_prints(&m.finish().unwrap(), "// First.\n//\n// Third.\n//\n// Fifth.\n\n");
}

#[test]
fn a_remark_on_the_driver_of_a_forward_wire_is_beside_the_wire() {
    let m = Builder::new("backwards");
    let a = m.input("a_i", 4);
    let later = m.forward("later", 4);
    m.output("a_o", later.wire() ^ a);
    later.drive((a + a).comment("twice"));
    assert_prints(&m.finish().unwrap(), "  logic [3:0] later;  // twice\n");
}

/// Names, including those that the printer makes, do not have two underscores in a row.
#[test]
fn made_names_do_not_double_underscores() {
    let m = Builder::new("dashes");
    let a = m.input("a_i", 4);
    let register = m.register("a_", 4);
    register.next((register.wire() + a) ^ (a - register.wire()) ^ (register.wire() & a) ^ (a | register.wire()));
    let inner = {
        let m = Builder::new("inner");
        m.output("sum_o", m.input("_x_i", 4));
        m.finish().unwrap()
    };
    let long = (a + register.wire()).equals(a).mux(a & register.wire(), a | register.wire());
    m.output("_y_o", m.instance("u_b", &inner, &[("_x_i", long)])[0]);
    let text = text(&m.finish().unwrap());
    assert!(!text.contains("__"), "{text}");
}

/// Only where value and width are those of the label; without the package there are numbers.
#[test]
fn constants_and_places_of_bits_have_names_of_the_package() {
    let m = Builder::new("named");
    let labels = vec![label("KindNode", 5), label("FlagOpaque", 2)];
    let kinds = Enumeration { name: "kind_e".to_string(), doc: Some("Kinds.".to_string()), width: 3, labels };
    let (doc, structures) = (Vec::new(), Vec::new());
    m.package(&Arc::new(Package { name: "kinds_pkg".to_string(), doc, enumerations: vec![kinds], structures }));
    let a = m.input("a_i", 4);
    let [node, other, wide] = [(3, 5), (3, 4), (4, 5)].map(|(width, value)| m.constant(width, value).hint("KindNode"));
    let [second, third] = [2, 3].map(|place| a.bit(place).hint("FlagOpaque"));
    m.output("kinds_o", a.lower(3).equals(node) | a.lower(3).equals(other) | a.equals(wide));
    m.output("bits_o", second & third);
    let module = m.finish().unwrap();
    assert_prints(&module, "= (a_i[2:0] == kinds_pkg::KindNode) | (a_i[2:0] == 3'd4) | (a_i == 4'd5);");
    assert_prints(&module, "= a_i[kinds_pkg::FlagOpaque] & a_i[3];");
    assert!(verilog::text(&module).unwrap().contains("  // Kinds.\n  typedef enum logic [2:0] {\n"));
    assert_prints(&plain(&module), "= (a_i[2:0] == 3'd5) | (a_i[2:0] == 3'd4) | (a_i == 4'd5);");
    assert_prints(&plain(&module), "= a_i[2] & a_i[3];");
}
