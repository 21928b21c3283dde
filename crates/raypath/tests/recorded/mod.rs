//! Reads the golden vectors for the tests: the quarter in the repository, or the whole set in the folder that
//! `RAYPATH_GOLDEN` names.

use raypath_ops::JobKind;
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_sim::transactions::{Transaction, merge, read};
use std::path::PathBuf;

/// All golden vectors as one stream.
pub fn golden() -> Vec<Transaction> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../raypath/tests/data/golden");
    let folder = std::env::var_os("RAYPATH_GOLDEN").map_or(PathBuf::from(default), PathBuf::from);
    // Rules and sums do not affect the reading.
    let model = Datapath::paper(Config::DEFAULT).model();
    let files = model.kinds().into_iter().map(|kind| {
        read(&folder.join(format!("{kind}.txt.gz")), kind, &model, Config::DEFAULT).expect("golden vectors")
    });
    let stream = merge(files.collect());
    assert!(stream.len() >= 24_576, "golden vectors are missing: {} jobs", stream.len());
    for kind in JobKind::ALL {
        assert!(stream.iter().any(|transaction| transaction.job.kind() == kind), "no {kind} jobs");
    }
    stream
}
