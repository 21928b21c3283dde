//! `raypath replay --report`.

use crate::{GOLDEN, ends_with, folder, page, raypath, said, text};

#[test]
fn recorded_jobs_in_a_report() {
    let folder = folder();
    let (report, log) = (folder.path().join("report.html"), folder.path().join("log.txt"));
    let files = ["triangle", "quadbox", "euclidean", "angular"].map(|kind| format!("{GOLDEN}/{kind}.txt.gz"));
    for engine in ["cycle", "netlist"] {
        let mut arguments = vec!["replay", "--rules", "chisel", "--engine", engine, "--interleave", "--handshake"];
        let (report, log) = (text(&report), text(&log));
        arguments.extend(["random", "--report", &report, "--konata", &log, "--window-jobs", "500"]);
        arguments.extend(files.iter().map(String::as_str));
        let output = raypath(&arguments);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains(&format!("wrote {report}")) && said.contains(&format!("wrote {log}")), "{said}");
        page::agrees(report.as_ref(), &said);
        // 24,576 jobs went in, and as many answers came out as recorded.
        let counts = page::counts(report.as_ref());
        assert!(counts.contains(&("jobs".to_string(), "24576".to_string())), "{counts:?}");
        assert!(counts.contains(&("mismatches".to_string(), "0".to_string())), "{counts:?}");
        // The log has the window's jobs, each of which begins and retires.
        let log = std::fs::read_to_string(&log).expect("a log");
        let lines = |kind: &str| log.lines().filter(|line| line.starts_with(kind)).count();
        assert_eq!((lines("I\t"), lines("R\t")), (500, 500));
    }
    // The functional model knows no cycles.
    ends_with(
        &["replay", "--rules", "chisel", &files[0], "--report", "r.html"],
        2,
        &["--engine model knows no cycles"],
    );
}
