//! Waveforms, written and read back by another library.

use raypath_hdl::wave::{WaveError, WaveWriter};
use raypath_hdl::{Builder, Module, Simulator};
use std::fs;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use tempfile::TempDir;
use wellen::simple::Waveform;

/// An accumulator inside an instance, in a top that doubles its input.
fn nested() -> Arc<Module> {
    let m = Builder::new("accumulator");
    let sum = m.register("sum_q", 64).reset_to(0);
    sum.next(sum.wire() + m.input("value_i", 64));
    m.output("sum_o", sum.wire());
    m.output("odd_o", sum.wire().bit(0));
    let accumulator = m.finish().unwrap();
    let m = Builder::new("nested");
    let value = m.input("value_i", 33);
    let wide = (value + value).named("twice").extend(64);
    let outputs = m.instance("u_sum", &accumulator, &[("value_i", wide)]);
    m.output("sum_o", outputs[0]);
    m.output("odd_o", outputs[1]);
    m.finish().unwrap()
}

fn files(directory: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(directory.path()).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// The changes of a variable: time in ns and digits.
fn changes(waves: &mut Waveform, path: &[&str], name: &str) -> Vec<(u64, String)> {
    let hierarchy = waves.hierarchy();
    let variable = hierarchy.lookup_var(path, name).unwrap_or_else(|| panic!("no {name} in {path:?}"));
    let signal = hierarchy[variable].signal_ref();
    waves.load_signals(&[signal]);
    let times = waves.time_table();
    let loaded = waves.get_signal(signal).unwrap();
    loaded.iter_changes().map(|(time, value)| (times[time as usize], value.to_bit_string().unwrap())).collect()
}

/// The value of a signal at each time, from its changes.
fn value_at(changes: &[(u64, String)], time: u64) -> u64 {
    let (_, digits) = changes.iter().rev().find(|(at, _)| *at <= time).expect("a value");
    u64::from_str_radix(digits, 2).unwrap()
}

#[test]
fn what_is_written_is_read_back() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.fst");
    let mut simulator = Simulator::observing(&nested(), |_| true).unwrap();
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    let names: Vec<(String, u32)> = simulator.signals().map(|(name, width)| (name.to_string(), width)).collect();
    let input = simulator.input("value_i").unwrap();

    // Enough cycles that changes are flushed to the file several times.
    const CYCLES: u64 = 60_000;
    let mut shown = vec![Vec::new(); names.len()];
    let mut value = 1u64;
    for cycle in 0..CYCLES {
        value = value.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        simulator.set(input, if cycle % 3 == 0 { value >> 20 } else { 5 });
        simulator.set_reset((100..103).contains(&cycle));
        simulator.cycle();
        waves.sample(&simulator, cycle).unwrap();
        for (values, (_, _, probe)) in shown.iter_mut().zip(simulator.probes()) {
            values.push(simulator.peek(probe));
        }
    }
    assert!(!path.exists(), "not there before it is complete");
    waves.finish().unwrap();
    assert_eq!(files(&directory), ["run.fst"]);

    let mut read = wellen::simple::read(&path).unwrap();
    assert_eq!(names.len(), 10, "{names:?}");
    for ((name, width), shown) in names.iter().zip(&shown) {
        let mut scopes = vec!["nested"];
        scopes.extend(name.split('.'));
        let leaf = scopes.pop().unwrap();
        let changes = changes(&mut read, &scopes, leaf);
        assert!(changes.iter().all(|(_, digits)| digits.len() == *width as usize), "{name} has {width} bits");
        assert!(changes.windows(2).all(|pair| pair[0].1 != pair[1].1), "{name} repeats a value");
        let mut next = 0;
        for (cycle, &value) in shown.iter().enumerate() {
            let time = cycle as u64 * 10;
            while next < changes.len() && changes[next].0 <= time {
                next += 1;
            }
            assert_eq!(value_at(&changes[..next], time), value, "{name} in cycle {cycle}");
        }
    }

    let clock = changes(&mut read, &["nested"], "clk_i");
    assert_eq!(clock.len() as u64, 2 * CYCLES);
    for (half, (time, digits)) in clock.iter().enumerate() {
        assert_eq!((*time, digits.as_str()), (half as u64 * 5, if half % 2 == 0 { "1" } else { "0" }));
    }
    let reset = changes(&mut read, &["nested"], "rst_ni");
    assert_eq!(reset, [(0, "1"), (1000, "0"), (1030, "1")].map(|(time, digits)| (time, digits.to_string())));
    let hierarchy = read.hierarchy();
    let scope = hierarchy.lookup_scope(&["nested", "u_sum"]).unwrap();
    assert_eq!(hierarchy[scope].component(hierarchy), Some("accumulator"));
    assert_eq!(*read.time_table().last().unwrap(), CYCLES * 10);
}

/// The ports of a memory, and its words if they are few, are in a scope of its name.
#[test]
fn memories_are_shown() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("memory.fst");
    let m = Builder::new("store");
    let (write, address, data) = (m.input("write_i", 1), m.input("address_i", 2), m.input("data_i", 40));
    let memory = m.memory("u_memory", 4, &[("upper", 8), ("lower", 32)]);
    memory.write(write, address, &[data.upper(8), data.lower(32)]);
    m.output("data_o", m.concat(&memory.read(!write, address)));
    let mut simulator = Simulator::observing(&m.finish().unwrap(), |_| true).unwrap();
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    for (cycle, inputs) in [[1, 2, 0xab_1234_5678], [0, 2, 0], [0, 0, 0]].into_iter().enumerate() {
        for (name, value) in ["write_i", "address_i", "data_i"].into_iter().zip(inputs) {
            simulator.set(simulator.input(name).unwrap(), value);
        }
        simulator.cycle();
        waves.sample(&simulator, cycle as u64).unwrap();
    }
    waves.finish().unwrap();
    let mut read = wellen::simple::read(&path).unwrap();
    let mut shown = |path: &[&str], name: &str| {
        let changes = changes(&mut read, path, name);
        [0, 10, 20].map(|time| value_at(&changes, time))
    };
    let scope = ["store", "u_memory"];
    assert_eq!(shown(&scope, "write_enable"), [1, 0, 0]);
    assert_eq!(shown(&scope, "write_upper"), [0xab, 0, 0]);
    assert_eq!(shown(&scope, "read_address"), [2, 2, 0]);
    assert_eq!(shown(&scope, "upper_2"), [0, 0xab, 0xab]);
    assert_eq!(shown(&scope, "lower_2"), [0, 0x1234_5678, 0x1234_5678]);
    assert_eq!(shown(&scope, "lower_1"), [0, 0, 0]);
    assert_eq!(shown(&["store"], "memory_upper"), [0, 0, 0xab]);
}

#[test]
fn a_single_sample_of_a_module_without_a_clock_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("single.fst");
    let m = Builder::new("plain");
    m.output("not_o", !m.input("a_i", 8));
    let mut simulator = Simulator::observing(&m.finish().unwrap(), |_| true).unwrap();
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    simulator.evaluate([0x0f]);
    waves.sample(&simulator, 0).unwrap();
    waves.finish().unwrap();
    let mut read = wellen::simple::read(&path).unwrap();
    assert_eq!(changes(&mut read, &["plain"], "not_o"), [(0, "11110000".to_string())]);
    assert!(read.hierarchy().lookup_var(&["plain"], "clk_i").is_none());
}

#[test]
fn only_observed_signals_are_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("some.fst");
    let simulator = Simulator::observing(&nested(), |name| name == "u_sum.sum_q").unwrap();
    WaveWriter::create(&path, &simulator).unwrap().finish().unwrap();
    let read = wellen::simple::read(&path).unwrap();
    let hierarchy = read.hierarchy();
    let mut names: Vec<_> = hierarchy.all_vars().map(|variable| hierarchy[variable].full_name(hierarchy)).collect();
    names.sort();
    assert_eq!(names, ["nested.clk_i", "nested.rst_ni", "nested.u_sum.sum_q"]);
}

#[test]
fn a_writer_dropped_before_the_end_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.fst");
    fs::write(&path, "of an earlier run").unwrap();
    let mut simulator = Simulator::observing(&nested(), |_| true).unwrap();
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    simulator.cycle();
    waves.sample(&simulator, 0).unwrap();
    assert_eq!(files(&directory).len(), 2, "a temporary file beside the target");
    drop(waves);
    assert_eq!(files(&directory), ["run.fst"]);
    assert_eq!(fs::read_to_string(&path).unwrap(), "of an earlier run");
}

#[test]
fn two_writers_of_one_path_do_not_disturb_each_other() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.fst");
    let mut simulator = Simulator::observing(&nested(), |_| true).unwrap();
    let mut first = WaveWriter::create(&path, &simulator).unwrap();
    let mut second = WaveWriter::create(&path, &simulator).unwrap();
    for cycle in 0..10 {
        simulator.cycle();
        first.sample(&simulator, cycle).unwrap();
        second.sample(&simulator, cycle).unwrap();
    }
    first.finish().unwrap();
    let once = fs::read(&path).unwrap();
    second.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), once, "the same run gives the same file");
    assert_eq!(files(&directory), ["run.fst"]);
}

#[test]
fn errors_name_the_file() {
    let simulator = Simulator::new(&nested()).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("file");
    fs::write(&file, "").unwrap();
    let path = file.join("run.fst");
    let found = WaveWriter::create(&path, &simulator).map(|_| ());
    let problem = found.expect_err("a file is no folder");
    assert!(problem.path == path && problem.problem.contains("os error"), "{problem}");
    fs::remove_file(&file).unwrap();

    let path = directory.path().join("run.fst");
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    waves.sample(&simulator, 5).unwrap();
    fs::create_dir(&path).unwrap();
    assert!(matches!(waves.finish(), Err(WaveError { .. })), "a directory is in the way");
    assert_eq!(files(&directory), ["run.fst"], "the temporary file is gone");
}

fn wave_error(path: &Path, problem: &str) -> WaveError {
    WaveError { path: path.to_path_buf(), problem: problem.to_string() }
}

#[test]
fn after_a_failed_sample_there_is_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.fst");
    let simulator = Simulator::observing(&nested(), |_| true).unwrap();
    let too_late = "cycle 18446744073709551615 is later than a waveform's times reach";
    for (cycle, problem) in [(5, "cycle 5 sampled after cycle 5"), (u64::MAX, too_late)] {
        let mut waves = WaveWriter::create(&path, &simulator).unwrap();
        waves.sample(&simulator, 5).unwrap();
        assert_eq!(waves.sample(&simulator, cycle), Err(wave_error(&path, problem)));
        let incomplete = Err(wave_error(&path, "incomplete, because a sample failed before"));
        assert_eq!(waves.sample(&simulator, 6), incomplete);
        assert_eq!(waves.finish(), incomplete);
        assert!(files(&directory).is_empty());
    }
    // The last cycle that there can be.
    let mut waves = WaveWriter::create(&path, &simulator).unwrap();
    waves.sample(&simulator, u64::MAX / 10 - 1).unwrap();
    waves.finish().unwrap();
}

#[test]
fn only_files_are_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let simulator = Simulator::new(&nested()).unwrap();
    let create = |path: &Path| WaveWriter::create(path, &simulator).map(|_| ());
    let (pipe, link) = (directory.path().join("pipe"), directory.path().join("link"));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    symlink(&pipe, &link).unwrap();
    let problem = "is not a regular file, expected a file or nothing";
    for path in [pipe.as_path(), &link, directory.path()] {
        assert_eq!(create(path), Err(wave_error(path, problem)));
    }
    assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
    assert_eq!(files(&directory).len(), 2);
}

#[test]
fn a_link_stays_and_what_it_leads_to_is_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let (folder, link) = (directory.path().join("elsewhere"), directory.path().join("run.fst"));
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("real.fst"), "of an earlier run").unwrap();
    symlink(folder.join("real.fst"), &link).unwrap();
    let simulator = Simulator::observing(&nested(), |_| true).unwrap();
    WaveWriter::create(&link, &simulator).unwrap().finish().unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(wellen::simple::read(folder.join("real.fst")).is_ok());
}
