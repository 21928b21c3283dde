//! Memories: when reads and writes take effect, ranges, random contents, text, and their replacements in proofs.

use raypath_hdl::{
    Builder, Error, Module, Simulator, depends_combinationally, expand_memories, expose_memories, expose_registers,
    verilog,
};
use std::sync::Arc;

/// A memory of two columns, with everything at ports.
fn store(depth: u32) -> Arc<Module> {
    store_of(depth, 1)
}

/// The same with this latency.
fn store_of(depth: u32, latency: u32) -> Arc<Module> {
    let m = Builder::new("store");
    let width = u32::BITS - (depth - 1).leading_zeros();
    let (write, write_address) = (m.input("write_i", 1), m.input("write_address_i", width));
    let (low, high) = (m.input("low_i", 8), m.input("high_i", 64));
    let (read, read_address) = (m.input("read_i", 1), m.input("read_address_i", width));
    let store = m.memory("u_store", depth, &[("high", 64), ("low", 8)]).latency(latency);
    store.write(write, write_address, &[high, low + m.constant(8, 1)]);
    let word = store.read(read, read_address);
    m.output("high_o", word[0]);
    m.output("low_o", word[1]);
    m.finish().expect("a memory")
}

/// The inputs in the order of declaration, without `high_i`, which is the complement of `low_i`.
type Inputs = [u64; 5];

struct Bench {
    simulator: Simulator,
}

impl Bench {
    fn new(depth: u32) -> Self {
        Self { simulator: Simulator::new(&store(depth)).expect("a simulator") }
    }

    /// The columns in a cycle with these inputs: write, address, low, read, address.
    fn cycle(&mut self, [write, write_address, low, read, read_address]: Inputs) -> [u64; 2] {
        self.simulator.set_all([write, write_address, low, !low, read, read_address]);
        self.simulator.cycle();
        self.simulator.outputs().try_into().expect("two columns")
    }
}

fn word(low: u64) -> [u64; 2] {
    [!low, low + 1]
}

#[test]
fn a_read_shows_the_word_of_before_the_edge_from_the_next_cycle_on() {
    let mut bench = Bench::new(4);
    bench.cycle([1, 2, 10, 0, 0]);
    bench.cycle([1, 3, 20, 0, 0]);
    assert_eq!(bench.cycle([0, 0, 0, 1, 2]), [0, 0], "nothing has been read");
    assert_eq!(bench.cycle([0, 0, 0, 1, 3]), word(10));
    assert_eq!(bench.cycle([1, 3, 30, 1, 3]), word(20));
    assert_eq!(bench.cycle([0, 0, 0, 1, 3]), word(20), "a read of the word that is written shows the old one");
    assert_eq!(bench.cycle([0, 0, 0, 0, 2]), word(30));
    assert_eq!(bench.cycle([0, 3, 40, 0, 2]), word(30), "without the enable the columns stay");
    assert_eq!(bench.cycle([0, 0, 0, 1, 3]), word(30));
    assert_eq!(bench.cycle([0, 0, 0, 0, 0]), word(30), "without the enable nothing is written");
}

#[test]
fn an_output_register_shows_the_same_a_cycle_later() {
    let modules = [store(5), store_of(5, 2), expand_memories(&store_of(5, 2)).expect("registers")];
    let mut benches = modules.map(|module| Bench { simulator: Simulator::new(&module).expect("a simulator") });
    let mut random = 1_u64;
    let (mut before, mut changes) = ([0; 2], 0);
    for cycle in 0..500 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let bits = |low: u32, mask: u64| random >> low & mask;
        let inputs = [bits(63, 1), bits(60, 7) % 5, bits(50, 255), bits(40, 1), bits(36, 7) % 5];
        let [shown, later, expanded] = benches.each_mut().map(|bench| bench.cycle(inputs));
        assert_eq!((later, expanded), (before, before), "cycle {cycle}");
        changes += u32::from(shown != before);
        before = shown;
    }
    assert!(changes > 100, "{changes} reads");
    let mut single = Bench { simulator: Simulator::new(&store_of(16, 2)).expect("a simulator") };
    single.simulator.restart_randomly(3);
    let shown = [0; 2].map(|_| single.cycle([0; 5]));
    assert!(shown[0] != shown[1] && shown[1] != [0; 2], "registers begin with random values: {shown:?}");
    single.simulator.restart();
    assert_eq!([0; 2].map(|_| single.cycle([0; 5])), [[0; 2]; 2]);
}

#[test]
fn settling_and_a_reset_leave_words_and_columns() {
    let mut bench = Bench::new(4);
    bench.cycle([1, 1, 10, 0, 0]);
    bench.cycle([0, 0, 0, 1, 1]);
    bench.cycle([0, 0, 0, 0, 0]);
    bench.simulator.set_reset(true);
    bench.simulator.evaluate([1]);
    bench.simulator.set_all([0]);
    assert_eq!(bench.cycle([0, 0, 0, 1, 0]), word(10), "settling wrote nothing");
    assert_eq!(bench.cycle([1, 1, 20, 1, 1]), [0, 0]);
    assert_eq!(bench.cycle([0, 0, 0, 1, 1]), word(10), "an edge during the reset counts");
    assert_eq!(bench.cycle([0, 0, 0, 0, 0]), word(20));
}

#[test]
fn addresses_beyond_the_last_word_read_zero_and_write_nothing() {
    let mut bench = Bench::new(5);
    for address in 0..8 {
        bench.cycle([1, address, 10 * address, 0, 0]);
    }
    bench.cycle([0, 0, 0, 1, 0]);
    let shown: Vec<_> = (1..9).map(|address| bench.cycle([0, 0, 0, 1, address % 8])).collect();
    let expected: Vec<_> = (0..8).map(|address| if address < 5 { word(10 * address) } else { [0, 0] }).collect();
    assert_eq!(shown, expected);
}

#[test]
fn words_and_ports_can_be_observed() {
    let wanted = |name: &str| name.starts_with("u_store.");
    let mut bench = Bench { simulator: Simulator::observing(&store(4), wanted).expect("a simulator") };
    let peek = |bench: &Bench, name: &str| bench.simulator.peek(bench.simulator.observe(name).expect("a signal"));
    bench.cycle([1, 2, 10, 0, 0]);
    assert_eq!(peek(&bench, "u_store.low_2"), 0, "before the edge");
    assert_eq!(peek(&bench, "u_store.write_low"), 11);
    assert_eq!(peek(&bench, "u_store.write_address"), 2);
    bench.cycle([0, 0, 0, 0, 0]);
    assert_eq!([peek(&bench, "u_store.high_2"), peek(&bench, "u_store.low_2")], word(10));
    assert_eq!(peek(&bench, "u_store.write_enable"), 0);
    let deep = Simulator::observing(&store(128), wanted).expect("a simulator");
    let names: Vec<&str> = deep.signals().map(|(name, _)| name).collect();
    assert_eq!(names.len(), 6, "many words are not shown: {names:?}");
}

#[test]
fn initial_contents_are_zero_or_random() {
    let module = store(16);
    let mut single = Bench { simulator: Simulator::new(&module).expect("a simulator") };
    let mut contents = |seed: u64| -> Vec<u64> {
        single.simulator.restart_randomly(seed);
        (0..17).map(|cycle| single.cycle([0, 0, 0, 1, cycle % 16])[1]).collect()
    };
    let shown = [7, 7, 8].map(&mut contents);
    assert_eq!(shown[0], shown[1], "the same seed");
    assert_ne!(shown[0], shown[2], "another seed");
    assert!(shown[0].iter().any(|&value| value != shown[0][0]), "{shown:?}");
    single.simulator.restart();
    assert_eq!(single.cycle([0, 0, 0, 1, 3]), [0, 0]);
    assert_eq!(single.cycle([0, 0, 0, 1, 4]), [0, 0]);
}

#[test]
fn no_path_leads_through_a_memory_within_a_cycle() {
    let module = store(4);
    for input in ["write_i", "write_address_i", "low_i", "read_i", "read_address_i"] {
        assert_eq!(depends_combinationally(&module, "low_o", input), Ok(false), "{input}");
    }
    assert!(module.is_clocked() && !module.has_reset());
    assert_eq!((module.register_bits(), module.memory_bits()), (0, 4 * 72));
}

#[test]
fn the_text_has_an_instance_of_the_one_module() {
    let sources = verilog::sources(&store(5), &["a banner".to_string()]).expect("a text");
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, [verilog::RAM, "store"]);
    assert!(sources[0].text.starts_with("// SPDX-License-Identifier: MIT OR Apache-2.0\n// a banner\n//\n// A memory"));
    let expected = "
  logic [63:0] store_high;
  logic [7:0]  store_low;

  raypath_ram_1r1w #(.Depth (5), .Width (72)) u_store (
    .clk_i, .write_enable_i (write_i), .write_address_i, .write_data_i ({high_i, low_i + 8'd1}),
    .read_enable_i (read_i), .read_address_i, .read_data_o ({store_high, store_low})
  );
";
    assert!(sources[1].text.contains(expected), "{}", sources[1].text);
    let text = verilog::sources(&store_of(5, 2), &[]).expect("a text")[1].text.clone();
    assert_eq!(text.matches("raypath_ram_1r1w #(.Depth (5), .Width (72), .ReadLatency (2)) u_store (").count(), 1);
}

#[test]
fn a_module_cannot_have_the_name_of_the_memory() {
    let m = Builder::new(verilog::RAM);
    let bit = m.input("bit_i", 1);
    let memory = m.memory("u_memory", 2, &[("bit", 1)]);
    memory.write(bit, bit, &[bit]);
    m.output("bit_o", memory.read(bit, bit)[0]);
    let error = verilog::sources(&m.finish().expect("a module"), &[]).expect_err("two of a name");
    assert_eq!(
        error.to_string(),
        "module raypath_ram_1r1w: name 'raypath_ram_1r1w' is the name of two different modules"
    );
}

#[test]
fn memories_that_do_not_fit_are_refused() {
    type Describe = fn(&Builder);
    let cases: [(Describe, &str); 10] = [
        (|m| _ = m.memory("u_m", 4, &[("a", 1)]).latency(3), "module bad, signal u_m: read latency 3, expected 1 or 2"),
        (|m| _ = m.memory("u_m", 1, &[("a", 1)]), "module bad, signal u_m: depth 1, expected 2 to 65536"),
        (|m| _ = m.memory("u_m", 65537, &[("a", 1)]), "module bad, signal u_m: depth 65537, expected 2 to 65536"),
        (|m| _ = m.memory("u_m", 4, &[]), "module bad, signal u_m: no columns, expected at least one"),
        (|m| _ = m.memory("u_m", 4, &[("a", 65)]), "module bad, signal Memory 0: width 65, expected 1 to 64"),
        (|m| _ = m.memory("u_m", 4, &[("a", 1)]), "module bad: 'u_m.write' is never driven"),
        (
            |m| {
                let memory = m.memory("u_m", 5, &[("a", 1)]);
                memory.write(m.input("e_i", 1), m.input("a_i", 2), &[]);
            },
            "module bad, signal u_m.write address: connected to 2 bits, expected 3",
        ),
        (
            |m| {
                let memory = m.memory("u_m", 4, &[("a", 1)]);
                memory.write(m.input("e_i", 1), m.input("a_i", 2), &[]);
            },
            "module bad, signal u_m.write: 0 columns written, expected 1",
        ),
        (
            |m| {
                let memory = m.memory("u_m", 4, &[("a", 3)]);
                let address = m.input("a_i", 2);
                memory.write(m.input("e_i", 1), address, &[address]);
            },
            "module bad, signal u_m.write.a: connected to 2 bits, expected 3",
        ),
        (
            |m| {
                let memory = m.memory("u_m", 4, &[("a", 3)]);
                let (enable, address) = (m.input("e_i", 1), m.input("a_i", 2));
                memory.read(enable, address);
                memory.read(enable, address);
            },
            "module bad: 'u_m.read' is driven twice",
        ),
    ];
    for (describe, expected) in cases {
        let m = Builder::new("bad");
        describe(&m);
        assert_eq!(m.finish().expect_err("refused").to_string(), expected);
    }
}

#[test]
fn only_small_memories_are_expanded() {
    let small = expand_memories(&store(64)).expect("registers");
    assert_eq!((small.register_bits(), small.memory_bits()), (64 * 72 + 72, 0));
    assert_eq!(
        expand_memories(&store(65)).expect_err("too deep"),
        Error::Width {
            module: "store".to_string(),
            signal: "u_store".to_string(),
            problem: "depth 65, expected at most 64 for registers".to_string(),
        }
    );
    let m = Builder::new("no_memory");
    m.output("x_o", m.input("x_i", 1));
    let plain = m.finish().expect("a module");
    assert!(Arc::ptr_eq(&expand_memories(&plain).expect("the same"), &plain));
}

/// Without the memory, its ports are what it would take at the edge.
#[test]
fn an_exposed_memory_is_ports() {
    let module = expose_registers(&store(4));
    assert_eq!(module.memory_bits(), 0);
    let mut s = Simulator::new(&module).expect("a simulator");
    for (name, value) in [
        ("write_i", 1),
        ("write_address_i", 3),
        ("low_i", 8),
        ("high_i", 5),
        ("read_i", 0),
        ("read_address_i", 2),
        ("store_low", 77),
    ] {
        let port = s.input(name).expect(name);
        s.set(port, value);
    }
    s.settle();
    for (name, value) in [
        ("low_o", 77),
        ("store_depth", 4),
        ("store_latency", 1),
        ("store_write_enable", 1),
        ("store_write_address", 3),
        ("store_write_low", 9),
        ("store_write_high", 5),
        ("store_read_enable", 0),
        ("store_read_address", 0),
    ] {
        assert_eq!(s.get(s.output(name).expect(name)), value, "{name}");
    }
}

/// In an instance beside a register, which stays.
#[test]
fn memories_alone_can_be_exposed() {
    let m = Builder::new("outer");
    let (bit, address, low) = (m.input("bit_i", 1), m.input("address_i", 2), m.register("low_q", 8));
    low.next(low.wire() + m.constant(8, 1));
    let ports =
        [("write_i", bit), ("write_address_i", address), ("low_i", low.wire()), ("high_i", low.wire().extend(64))];
    let ports = [ports.as_slice(), &[("read_i", bit), ("read_address_i", address)]].concat();
    m.output("low_o", m.instance("u_inner", &store(4), &ports)[1]);
    let outer = m.finish().expect("a module");
    let exposed = expose_memories(&outer);
    assert_eq!((exposed.memory_bits(), exposed.register_bits()), (0, 8));
    let names = |ports: &[raypath_hdl::Port]| ports.iter().map(|port| port.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(exposed.inputs()), ["bit_i", "address_i", "inner_store_high", "inner_store_low"]);
    let shown = ["write_enable", "write_address", "read_enable", "read_address", "write_high", "write_low"];
    assert_eq!(names(exposed.outputs())[1..], shown.map(|name| format!("inner_store_{name}")));
    let plain = expand_memories(&outer).expect("registers");
    assert!(Arc::ptr_eq(&expose_memories(&plain), &plain));
}
