//! Simulation with unknown values: they pass through logic, but not where the value is the same for each of them.

use raypath_hdl::{Builder, verilog};
use raypath_tools::{FourState, KnownWord, ToolError};

#[test]
fn unknown_values_are_seen_and_only_where_they_matter() {
    let m = Builder::new("sample");
    let (select, a, b) = (m.input("select_i", 1), m.input("a_i", 8), m.input("b_i", 8));
    let loads = m.input("load_i", 1);
    m.output("either_o", select.mux(a, b));
    m.output("both_o", m.case(select, &[(label("OpA", 1), a & b)], b));
    let (held, counted) = (m.register("held_q", 40), m.register("counted_q", 3).reset_to(5));
    held.next_when(loads, m.concat(&[a, b, a, b, a]));
    counted.next(counted.wire() + m.constant(3, 1));
    m.output("held_o", held.wire());
    m.output("counted_o", counted.wire());
    let memory = m.memory("u_words", 4, &[("word", 8)]);
    let address = m.input("address_i", 2);
    memory.write(loads, address, &[a]);
    m.output("read_o", memory.read(m.constant(1, 1), address)[0]);
    let module = m.finish().expect("a module");
    let folder = tempfile::tempdir().expect("a folder");
    let text: String = verilog::sources(&module, &[]).expect("a text").into_iter().map(|source| source.text).collect();
    let simulation = FourState::build(&text, &module, folder.path()).expect("a simulation");

    // Inputs: reset, select, a, b, load, address.
    let known = |words: [u64; 6]| words.map(Some).to_vec();
    let without = |place: usize, words: [u64; 6]| {
        let mut frame = known(words);
        frame[place] = None;
        frame
    };
    let frames = [
        known([1, 1, 3, 4, 0, 0]),
        without(1, [0, 0, 3, 4, 0, 0]),
        // The same on both sides of an unknown select.
        without(1, [1, 0, 7, 7, 1, 2]),
        // An unknown load keeps what is the same, and an unknown address may write any word.
        without(4, [1, 0, 7, 7, 0, 2]),
        without(5, [1, 0, 9, 7, 1, 0]),
        known([1, 0, 9, 7, 0, 2]),
        known([1, 0, 9, 7, 0, 2]),
    ];
    let mut seen: Vec<Vec<KnownWord>> = Vec::new();
    let run = simulation.run(frames, |_, words| {
        seen.push(words.to_vec());
        true
    });
    run.expect("a run");
    let held = Some(0x07_0707_0707);
    let expected = [
        [Some(3), Some(0), None, None, None],
        [None, None, None, Some(5), None],
        [Some(7), Some(7), None, Some(5), None],
        [Some(7), Some(7), held, Some(6), None],
        [Some(7), Some(7), held, Some(7), Some(7)],
        [Some(7), Some(7), Some(0x09_0709_0709), Some(0), None],
        [Some(7), Some(7), Some(0x09_0709_0709), Some(1), None],
    ];
    assert_eq!(seen, expected.map(Vec::from));

    let short = simulation.run([vec![None]], |_, _| true);
    assert!(matches!(short, Err(ToolError::Frame { cycle: 0, found: 1, expected: 6 })), "{short:?}");
}

fn label(name: &str, value: u64) -> raypath_hdl::Label {
    raypath_hdl::Label { name: name.to_string(), value }
}
