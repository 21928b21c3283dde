//! The measurement that tests make: small designs in the free library, with the system's tools.

pub mod setting;

use raypath_ppa::{Bench, DEFAULT_LIBRARY, Library};
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::Path;

pub fn bench(cache: &Path) -> Bench {
    Bench {
        library: Library::read(Path::new(DEFAULT_LIBRARY)).expect("the package qflow-tech-osu018"),
        yosys: Yosys::find(Some(YosysKind::Program)).expect("the package yosys"),
        sta: OpenSta::find().expect("the package opensta"),
        period: 5.0,
        unit_period: None,
        jobs: 2,
        cache: cache.to_path_buf(),
    }
}
