//! The output of runs that succeed, and reports as a browser shows them.

use crate::command_line::{raypath, said, text};
use std::path::Path;
use std::process::Command;

/// Runs the program, which must succeed, and returns its output.
pub fn succeeds(arguments: &[&str]) -> String {
    let output = raypath(arguments);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    said
}

/// Runs the program with options that name files in `folder`, and returns its output, which must name each file.
pub fn writes(arguments: &[&str], folder: &Path, files: &[(&str, &str)]) -> String {
    let files: Vec<_> = files.iter().map(|(option, name)| (*option, text(&folder.join(name)))).collect();
    let options: Vec<&str> = files.iter().flat_map(|(option, path)| [*option, path.as_str()]).collect();
    let said = succeeds(&[arguments, &options].concat());
    for (_, path) in &files {
        assert!(said.contains(&format!("wrote {path}")), "{path}: {said}");
    }
    said
}

/// The rows of a report's table of counts after Chromium has run the page's script: labels and values.
pub fn counts(page: &Path) -> Vec<(String, String)> {
    let folder = crate::command_line::folder();
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", folder.path().display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("chromium, of the Debian package of that name");
    let shown = String::from_utf8(output.stdout).expect("text");
    // The script has run and has drawn the timeline.
    assert!(shown.contains(">cycles "), "no timeline: {}", &shown[..shown.len().min(2000)]);
    let table = shown.split("id=\"counts\"").nth(1).expect("counts").split("</table>").next().expect("an end");
    let cell = |row: &str, tag: &str| {
        let inside = row.split(&format!("<{tag}")).nth(1).expect(tag).split_once('>').expect(tag).1;
        inside.split(&format!("</{tag}>")).next().expect(tag).trim().to_string()
    };
    table.split("<tr").skip(1).map(|row| (cell(row, "th"), cell(row, "td"))).collect()
}

/// Checks that each row of a report's table of counts was printed.
pub fn agrees(page: &Path, printed: &str) {
    let counts = counts(page);
    assert!(counts.len() > 3);
    for (label, value) in counts {
        let is_printed = printed.lines().any(|line| {
            let rest = line.trim().strip_prefix(label.trim());
            rest.is_some_and(|rest| rest.trim() == value)
        });
        assert!(is_printed, "'{label}' is {value} on the page, but not in:\n{printed}");
    }
}
