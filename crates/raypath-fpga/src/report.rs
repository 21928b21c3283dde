//! What an implementation takes of a device, and how fast it is.

use crate::device::Target;
use crate::timing::Timing;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A design on a device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The design's name.
    pub design: String,
    /// The tools and the target.
    pub setting: Setting,
    /// All cells after synthesis.
    pub cells: Cells,
    /// What is used of the device, by nextpnr's names.
    pub used: BTreeMap<String, Use>,
    /// The fastest clock after routing, in MHz.
    pub clock_mhz: f64,
    /// The period of that clock, in nanoseconds.
    pub period_ns: f64,
    /// The nanoseconds of it that pass on wires.
    pub routing_ns: f64,
    /// The signals on the slowest path, in order.
    pub path: Vec<Step>,
    /// The parts: the datapath's stages, and what is around them.
    pub stages: Vec<Stage>,
}

/// With what and for what a report was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The synthesiser and its version.
    pub synthesis: String,
    /// The program that places and routes, and its version.
    pub place_and_route: String,
    /// The device.
    pub device: String,
    /// Its speed grade.
    pub speed: u8,
    /// The clock that placement and routing aimed at, in MHz.
    pub aim_mhz: f64,
    /// The seed of the placement.
    pub seed: u32,
}

/// Numbers of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Cells {
    /// Lookup tables of four inputs; those in carry cells do not count.
    pub luts: u64,
    /// Carry cells, of two bits each.
    pub carry_cells: u64,
    /// DSP multipliers of 18 by 18 bits.
    pub multipliers: u64,
    /// Flip-flops.
    pub flip_flops: u64,
    /// Block memories of 16 kbit.
    pub block_rams: u64,
    /// Memories of 16 by 4 bits in lookup tables.
    pub distributed_rams: u64,
}

/// How many of a device's resources are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Use {
    /// Used.
    pub used: u64,
    /// On the device.
    pub available: u64,
}

/// A part of the design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// The instance's name without `u_`.
    pub name: String,
    /// Its cells.
    pub cells: Cells,
    /// Nanoseconds of the slowest path that ends in it, if one does.
    pub slowest_ns: Option<f64>,
}

/// A signal on a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Its name in the flattened design; where synthesis has made a signal, the nearest name.
    pub signal: String,
    /// Nanoseconds from the clock edge until it has arrived where the path goes on.
    pub ns: f64,
}

impl Report {
    /// The report of a design whose cells and timing are known.
    pub(crate) fn new(
        design: &str,
        tools: [&str; 2],
        target: Target,
        cells: &BTreeMap<String, Cells>,
        timing: Timing,
        order: &[String],
    ) -> Self {
        let mut all = Cells::default();
        cells.values().for_each(|cells| all.add(cells));
        let mut names: Vec<&String> = order.iter().filter(|name| cells.contains_key(*name)).collect();
        names.extend(cells.keys().filter(|name| !order.contains(name)));
        let stage = |name: &String| Stage {
            name: name.clone(),
            cells: cells.get(name).copied().unwrap_or_default(),
            slowest_ns: timing.slowest.get(name).copied(),
        };
        let stages = names.into_iter().map(stage).collect();
        let Target { device, speed, clock_mhz, seed } = target;
        let [synthesis, place_and_route] = tools.map(str::to_string);
        Self {
            design: design.to_string(),
            setting: Setting {
                synthesis,
                place_and_route,
                device: device.to_string(),
                speed,
                aim_mhz: clock_mhz,
                seed,
            },
            cells: all,
            used: timing.used,
            clock_mhz: timing.clock_mhz,
            period_ns: 1000.0 / timing.clock_mhz,
            routing_ns: timing.routing_ns,
            path: timing.path,
            stages,
        }
    }
}

impl Cells {
    fn add(&mut self, other: &Self) {
        self.luts += other.luts;
        self.carry_cells += other.carry_cells;
        self.multipliers += other.multipliers;
        self.flip_flops += other.flip_flops;
        self.block_rams += other.block_rams;
        self.distributed_rams += other.distributed_rams;
    }
}
