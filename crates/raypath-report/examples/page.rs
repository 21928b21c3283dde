//! Writes a page and a log of a made-up run, to look at: `cargo run --release -p raypath-report --example page -- DIR`.

#[path = "../tests/common/mod.rs"]
mod common;

use raypath_model::{Control, CycleModel, Functional};
use raypath_ops::Rules;
use raypath_report::Recording;
use raypath_timing::{Machine, plot, sweep};
use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let folder: PathBuf = std::env::args().nth(1).unwrap_or_else(|| ".".to_string()).into();
    let jobs = std::env::args().nth(2).and_then(|jobs| jobs.parse().ok()).unwrap_or(2000);
    for (name, control, stalls) in
        [("skid", Control::Skid, 0.15), ("credit", Control::Credit, 0.15), ("free", Control::Skid, 0.0)]
    {
        let recording = Recording { sweep: Some(throughput(control)), ..common::recording(control, jobs, stalls) };
        std::fs::write(folder.join(format!("{name}.html")), raypath_report::html(&recording))?;
        std::fs::write(folder.join(format!("{name}.kanata")), raypath_report::konata(&recording))?;
    }
    Ok(())
}

fn throughput(control: Control) -> String {
    let model = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &common::shape(control));
    let agents = || (0..2000).map(|seed| common::Walk::new(seed, 10));
    let in_flight = [1, 2, 4, 8, 16, 32, 64, 128, 256];
    let sweep = sweep(&in_flight, &[0, 40, 100, 400], &Machine::default(), &model, agents, &|_| true);
    plot(&sweep.unwrap_or_default(), "Throughput of a made-up run", "rays")
}
