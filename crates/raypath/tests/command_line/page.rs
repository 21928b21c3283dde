//! Reports as a browser shows them.

use std::path::Path;
use std::process::Command;

/// The rows of a report's table of counts, as Chromium has them once the page's script has run, each in the two columns
/// in which the program prints them.
pub fn counts(page: &Path) -> Vec<(String, String)> {
    let folder = crate::folder();
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", folder.path().display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("chromium, of the Debian package of that name");
    let shown = String::from_utf8(output.stdout).expect("text");
    // The script has drawn the timeline, or this has not changed.
    assert!(shown.contains(">cycles "), "no timeline: {}", &shown[..shown.len().min(2000)]);
    let table = shown.split("id=\"counts\"").nth(1).expect("counts").split("</table>").next().expect("an end");
    let cell = |row: &str, tag: &str| {
        let inside = row.split(&format!("<{tag}")).nth(1).expect(tag).split_once('>').expect(tag).1;
        inside.split(&format!("</{tag}>")).next().expect(tag).trim().to_string()
    };
    table.split("<tr").skip(1).map(|row| (cell(row, "th"), cell(row, "td"))).collect()
}

/// Every one of them was printed.
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
