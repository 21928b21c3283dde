//! The simulation process: modules without a clock or inputs, long streams, frames of a wrong size.

use raypath_hdl::Builder;
use raypath_tools::{Options, Sources, ToolError, Verilated};

fn build(m: Builder) -> (tempfile::TempDir, Verilated) {
    let folder = tempfile::tempdir().expect("a folder");
    let verilated = Verilated::build(&m.finish().expect("a module"), folder.path()).expect("a build");
    (folder, verilated)
}

#[test]
fn long_streams_without_a_clock() {
    let m = Builder::new("adder");
    let (a, b) = (m.input("a_i", 16), m.input("b_i", 16));
    m.output("sum_o", a + b);
    let top = m.finish().expect("a module");
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(&top, folder.path()).expect("sources");
    let options = Options { jobs: 1, ..Options::default() };
    let verilated = Verilated::build_sources(&[sources.all], &top, folder.path(), &options).expect("a build");

    // Far more than the pipes hold; excess bits of inputs are dropped.
    let frames = (0..500_000u64).map(|n| vec![n | 1 << 40, 7 * n]);
    let mut seen = 0;
    verilated
        .run(frames, |cycle, outputs| {
            assert_eq!(outputs, [(8 * cycle as u64) & 0xffff]);
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, 500_000);

    let short = verilated.run([vec![1, 2], vec![3]], |_, _| {});
    assert!(matches!(short, Err(ToolError::Frame { cycle: 1, found: 1, expected: 2 })), "{short:?}");
}

#[test]
fn clocks_without_inputs() {
    let m = Builder::new("ticker");
    let count = m.register("count_q", 64);
    count.next(count.wire() + m.constant(64, 1));
    m.output("count_o", count.wire());
    let (_folder, verilated) = build(m);
    for _ in 0..2 {
        let mut seen = Vec::new();
        verilated.run(vec![vec![]; 3], |_, outputs| seen.extend_from_slice(outputs)).expect("a run");
        assert_eq!(seen, [0, 1, 2], "every run begins anew");
    }
}

/// A register without a reset begins with 0 or, in a random run, with a value that follows from the seed.
#[test]
fn the_initial_state_is_chosen() {
    let m = Builder::new("held");
    let held = m.register("held_q", 64);
    held.next_when(m.input("load_i", 1), m.input("value_i", 64));
    m.output("held_o", held.wire());
    let (_folder, verilated) = build(m);
    let frames = || vec![vec![0, 5], vec![1, 5], vec![0, 6]];
    let mut seen = Vec::new();
    verilated.run(frames(), |_, outputs| seen.extend_from_slice(outputs)).expect("a run");
    assert_eq!(seen, [0, 0, 5]);
    let mut begun = [3, 3, 4, 0, u32::MAX].map(|seed| {
        let mut seen = Vec::new();
        verilated.run_randomly(seed, frames(), |_, outputs| seen.extend_from_slice(outputs)).expect("a run");
        assert_eq!((seen[0], seen[2]), (seen[1], 5));
        seen[0]
    });
    assert_eq!(begun[0], begun[1]);
    begun.sort_unstable();
    let mut different = begun.to_vec();
    different.dedup();
    assert!(different.len() >= 3 && !begun.contains(&0), "{begun:x?}");
}

/// A program of the same texts is not compiled again; one of other texts is.
#[test]
fn kept_programs_are_used_again() {
    let kept = tempfile::tempdir().expect("a folder");
    let options = Options { kept: Some(kept.path().join("programs")), ..Options::default() };
    let answer = |constant: u64| {
        let m = Builder::new("answer");
        m.output("answer_o", m.input("a_i", 8) ^ m.constant(8, constant));
        let folder = tempfile::tempdir().expect("a folder");
        let top = m.finish().expect("a module");
        let verilated = Verilated::build_with(&top, folder.path(), &options).expect("a build");
        let mut seen = Vec::new();
        verilated.run([vec![7]], |_, outputs| seen.extend_from_slice(outputs)).expect("a run");
        (seen, folder.path().join("obj").exists())
    };
    assert_eq!(answer(1), (vec![6], true));
    assert_eq!(answer(1), (vec![6], false));
    assert_eq!(answer(2), (vec![5], true));
    assert_eq!(kept.path().join("programs").read_dir().expect("a folder").count(), 2);
}

#[test]
fn a_panic_leaves_no_process_behind() {
    let m = Builder::new("echo");
    m.output("a_o", m.input("a_i", 16));
    let (_folder, verilated) = build(m);
    let run = || verilated.run((0..).map(|n| vec![n]), |cycle, _| assert!(cycle < 100, "enough"));
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    // The list includes processes that have ended and have not been waited for.
    let children = std::fs::read_to_string("/proc/thread-self/children").expect("a list of processes");
    assert_eq!(children, "");
}

#[test]
fn the_file_of_everything_is_none_of_the_modules() {
    let inner = {
        let m = Builder::new("outer_all");
        m.output("a_o", m.input("a_i", 2));
        m.finish().expect("a module")
    };
    let m = Builder::new("outer");
    let a = m.input("a_i", 2);
    m.output("a_o", m.instance("u_inner", &inner, &[("a_i", a)])[0]);
    let top = m.finish().expect("a module");
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(&top, folder.path()).expect("sources");
    sources.lint().unwrap_or_else(|fault| panic!("{fault}"));
    let modules = |path| std::fs::read_to_string(path).expect("text").matches("endmodule").count();
    assert_eq!(sources.files.iter().map(modules).collect::<Vec<_>>(), [1, 1]);
    assert_eq!(modules(&sources.all), 2);
}

#[test]
fn faults_of_the_text_are_shown() {
    let m = Builder::new("careless");
    let a = m.input("a_i", 2);
    m.output("a_o", a.bit(0));
    let top = m.finish().expect("a module");
    let folder = tempfile::tempdir().expect("a folder");
    let fault = Sources::write(&top, folder.path()).expect("sources").lint().expect_err("an unread bit");
    assert!(fault.to_string().contains("UNUSED"), "{fault}");
}
