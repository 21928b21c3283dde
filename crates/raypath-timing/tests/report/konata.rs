//! The log, read by a strict parser written after the description of the format (`docs/kanata-log-format.md` of
//! Konata).

use crate::report::common;
use raypath_model::Control;
use raypath_timing::report::{Recording, konata};
use std::collections::HashMap;

/// An instruction of the log.
#[derive(Debug, Default)]
struct Instruction {
    begins: u64,
    thread: u64,
    left_pane: String,
    detail: String,
    /// The stages of each lane: name, first cycle, cycle of the end.
    stages: HashMap<u64, Vec<(String, u64, Option<u64>)>>,
    retires: Option<(u64, u64)>,
}

/// Parses a log, and panics on anything that the description does not allow.
fn read(log: &str) -> Vec<Instruction> {
    let mut lines = log.lines();
    assert_eq!(lines.next(), Some("Kanata\t0004"));
    let start = lines.next().and_then(|line| line.strip_prefix("C=\t")).expect("the first cycle");
    let mut now: u64 = start.parse().expect("a cycle");
    let mut instructions: Vec<Instruction> = Vec::new();
    let mut retired = 0;
    for line in lines {
        let columns: Vec<&str> = line.split('\t').collect();
        let number = |index: usize| columns[index].parse::<u64>().unwrap_or_else(|_| panic!("a number in '{line}'"));
        if columns[0] == "C" {
            assert!(columns.len() == 2 && number(1) > 0, "{line}");
            now += number(1);
            continue;
        }
        let id = number(1) as usize;
        if columns[0] == "I" {
            assert_eq!((columns.len(), id), (4, instructions.len()), "{line}");
            instructions.push(Instruction { begins: now, thread: number(3), ..Instruction::default() });
            continue;
        }
        let instruction = &mut instructions[id];
        assert!(instruction.retires.is_none(), "'{line}' after its end");
        match columns[0] {
            "L" => {
                assert_eq!(columns.len(), 4, "{line}");
                match number(2) {
                    0 => instruction.left_pane += columns[3],
                    1 => instruction.detail += columns[3],
                    other => panic!("text of type {other}"),
                }
            }
            "S" => {
                assert_eq!(columns.len(), 4, "{line}");
                let lane = instruction.stages.entry(number(2)).or_default();
                assert!(
                    lane.last().is_none_or(|(.., end)| *end == Some(now) || number(2) == 1 && end.is_some()),
                    "{line}"
                );
                lane.push((columns[3].to_string(), now, None));
            }
            "E" => {
                assert_eq!(columns.len(), 4, "{line}");
                let open = instruction.stages.get_mut(&number(2)).and_then(|lane| lane.last_mut()).expect("a stage");
                assert_eq!((open.0.as_str(), open.2), (columns[3], None), "{line}");
                assert!(now > open.1, "a stage of no cycles: {line}");
                open.2 = Some(now);
            }
            "R" => {
                assert_eq!((columns.len(), number(2), number(3)), (4, retired, 0), "{line}");
                retired += 1;
                instruction.retires = Some((now, number(2)));
            }
            other => panic!("a command '{other}'"),
        }
    }
    instructions
}

fn check_log(recording: &Recording) -> usize {
    let instructions = read(&konata(recording));
    let window = &recording.window;
    assert_eq!(instructions.len(), window.jobs.len());
    let mut stalled = 0;
    for (job, instruction) in window.jobs.iter().zip(&instructions) {
        assert_eq!((instruction.begins, instruction.thread), (job.accepted, job.operation as u64));
        assert_eq!(instruction.left_pane, format!("{} ray {}", recording.operations[job.operation], job.owner));
        let lane = &instruction.stages[&0];
        assert_eq!((lane[0].0.as_str(), lane[0].1), ("in", job.accepted));
        assert_eq!(lane.len(), job.entered.len() + 1);
        for (stage, entered) in job.entered.iter().enumerate() {
            assert_eq!((&lane[stage + 1].0, lane[stage + 1].1), (&format!("s{}", stage + 1), *entered));
        }
        assert_eq!(instruction.retires.map(|(cycle, _)| cycle), job.left.map(|left| left + 1));
        let stalls = instruction.stages.get(&1).map_or(&[][..], |lane| lane);
        let cycles: u64 = stalls.iter().filter_map(|(_, from, end)| end.map(|end| end - from)).sum();
        if let Some(left) = job.left {
            // The cycles from acceptance to exit, less one per stage.
            assert_eq!(cycles, left - job.accepted - window.stages as u64);
            assert_eq!(lane.last().and_then(|(.., end)| *end), Some(left + 1));
        }
        assert!(instruction.detail.contains("accepted in cycle"));
        stalled += cycles as usize;
    }
    stalled
}

#[test]
fn the_log_has_the_jobs_stages_and_stalls_of_the_recording() {
    for control in [Control::Skid, Control::Credit] {
        assert!(check_log(&common::recording(control, 1000, 0.3)) > 1000);
        let mut cut = common::recording(control, 300, 0.3);
        // A recording that ends while jobs are inside.
        cut.window.end = cut.window.jobs[290].accepted + 5;
        for job in &mut cut.window.jobs {
            job.entered.retain(|cycle| *cycle < cut.window.end);
            job.left = job.left.filter(|left| *left < cut.window.end);
        }
        cut.window.jobs.retain(|job| job.accepted < cut.window.end);
        assert!(cut.window.jobs.iter().any(|job| job.left.is_none()));
        check_log(&cut);
    }
}

#[test]
fn labels_stay_in_their_column() {
    let mut recording = common::recording(Control::Skid, 20, 0.0);
    recording.window.owner = "ra\ty\nR\t0\t0\t0".to_string();
    let instructions = read(&konata(&recording));
    assert!(instructions[0].left_pane.contains("ra y R 0 0 0"));
    assert_eq!(read(&konata(&Recording::default())).len(), 0);
}
