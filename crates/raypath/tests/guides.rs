//! The code of guides is that of examples, which are compiled and run.

use std::fs;
use std::path::Path;

#[test]
fn guides_show_the_code_of_examples() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = |path: &str| fs::read_to_string(root.join(path)).unwrap_or_else(|problem| panic!("{path}: {problem}"));
    let guides = [
        ("docs/user/models.md", "crates/raypath-model/examples", &["hits.rs", "distance.rs", "cycles.rs"][..]),
        (
            "docs/extending/operations.md",
            "examples/within_radius",
            &["src/lib.rs", "src/first_cut.rs", "src/nearest.rs", "tests/whole.rs"],
        ),
    ];
    for (guide, folder, sources) in guides {
        let examples: String = sources.iter().map(|source| flush_left(&text(&format!("{folder}/{source}")))).collect();
        let page = text(guide);
        let blocks: Vec<&str> = page
            .split("```rust")
            .skip(1)
            .filter_map(|it| it.split("```").next()?.split_once('\n'))
            .map(|(_, code)| code)
            .collect();
        assert!(blocks.len() >= 4, "{guide}");
        for block in blocks {
            assert!(examples.contains(&flush_left(block)), "{guide}: no example has\n{block}");
        }
    }
}

/// The text without indentation, and without the lines that mark parts.
fn flush_left(text: &str) -> String {
    let lines = text.lines().map(str::trim_start).filter(|line| !line.starts_with("// ANCHOR"));
    lines.map(|line| format!("{line}\n")).collect()
}
