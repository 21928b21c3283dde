//! Writes a page and a log of a made-up run, to look at: `cargo run --release -p raypath-report --example page -- DIR`.

#[path = "../tests/common/mod.rs"]
mod common;

use raypath_model::Control;
use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let folder: PathBuf = std::env::args().nth(1).unwrap_or_else(|| ".".to_string()).into();
    let jobs = std::env::args().nth(2).and_then(|jobs| jobs.parse().ok()).unwrap_or(2000);
    for (name, control, stalls) in
        [("skid", Control::Skid, 0.15), ("credit", Control::Credit, 0.15), ("free", Control::Skid, 0.0)]
    {
        let recording = common::recording(control, jobs, stalls);
        std::fs::write(folder.join(format!("{name}.html")), raypath_report::html(&recording))?;
        std::fs::write(folder.join(format!("{name}.kanata")), raypath_report::konata(&recording))?;
    }
    Ok(())
}
