//! The measurement that tests make: small designs in the free library, with the system's tools.

pub mod setting;

use raypath_hdl::{Builder, Module, Wire};
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Library};
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::Path;
use std::sync::Arc;

/// The bits of a number in the designs.
pub const WIDTH: u32 = 6;

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

/// A valid bit with a reset.
fn control() -> Arc<Module> {
    let m = Builder::new("raypath_tiny_control");
    let valid = m.register("valid_q", 1).reset_to(0);
    valid.next(m.input("valid_i", 1));
    m.output("valid_o", valid.wire());
    m.finish().expect("control")
}

/// A stage that registers the number that `made` returns if the number is valid; with `extra`, it has an unread register.
pub fn stage(name: &str, extra: bool, made: impl for<'m> Fn(&'m Builder, Wire<'m>) -> Wire<'m>) -> Arc<Module> {
    let m = Builder::new(name);
    let number = m.input("num_0_i", WIDTH);
    let valid = m.input("valid_i", 1);
    let next = made(&m, number);
    let register = m.register("num_0_q", WIDTH);
    register.next_when(valid, next);
    if extra {
        let unread = m.register("unread_q", WIDTH);
        unread.next(number);
        m.unused("unused_register", &[unread.wire()]);
    }
    m.output("num_0_o", register.wire());
    m.output("valid_o", m.instance("u_control", &control(), &[("valid_i", valid)])[0]);
    m.finish().expect("a stage")
}

/// A datapath of stages in series.
pub fn chain(stages: &[(&str, Arc<Module>)]) -> Arc<Module> {
    let m = Builder::new("raypath");
    let mut wires = (m.input("num_0_i", WIDTH), m.input("valid_i", 1));
    for (name, module) in stages {
        let outputs = m.instance(name, module, &[("num_0_i", wires.0), ("valid_i", wires.1)]);
        wires = (outputs[0], outputs[1]);
    }
    m.output("num_0_o", wires.0);
    m.output("valid_o", wires.1);
    m.finish().expect("a design")
}
