//! What a design takes of a device, and how fast it is.

use crate::device::{Device, Target};
use crate::netlist::Netlist;
use crate::timing::Timing;
use serde::{Deserialize, Serialize};

/// A design on a device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The design's name.
    pub design: String,
    /// The synthesiser and its version.
    pub synthesis: String,
    /// The device.
    pub device: String,
    /// All cells after synthesis.
    pub cells: Cells,
    /// The parts: the stages, and what is around them.
    pub stages: Vec<Stage>,
    /// Placement and routing, if there are any for the device.
    pub routed: Option<Routed>,
}

/// A placed and routed design: the run with the fastest clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Routed {
    /// The program that places and routes, and its version.
    pub place_and_route: String,
    /// The speed grade.
    pub speed: u8,
    /// The clock that placement and routing aimed at, in MHz.
    pub aim_mhz: f64,
    /// The seed of the placement.
    pub seed: u32,
    /// Its figures.
    #[serde(flatten)]
    pub timing: Timing,
    /// All runs, with their clocks.
    pub runs: Vec<Run>,
}

/// A run of placement and routing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The speed grade.
    pub speed: u8,
    /// The seed of the placement.
    pub seed: u32,
    /// The fastest clock, in MHz.
    pub clock_mhz: f64,
}

/// Numbers of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Cells {
    /// Lookup tables, of four inputs in an ECP5, of up to six in Xilinx's; those in carry cells do not count.
    pub luts: u64,
    /// Carry cells, of two bits each in an ECP5, of four in series 7, of eight in UltraScale+.
    pub carry_cells: u64,
    /// DSP multipliers, of 18 by 18 bits in an ECP5; or DSP48.
    pub multipliers: u64,
    /// Flip-flops.
    pub flip_flops: u64,
    /// Block memories, of 16 kbit in an ECP5, of 18 in Xilinx's: a RAMB36 is two.
    pub block_rams: u64,
    /// Memories in lookup tables, of 16 by 4 bits in an ECP5.
    pub distributed_rams: u64,
    /// Shift registers in lookup tables (SRL) of Xilinx's.
    pub shift_registers: u64,
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
    /// The instance's name without `u_`; `datapath.stage_1` is a stage of a traversal unit's datapath.
    pub name: String,
    /// Its cells.
    pub cells: Cells,
    /// Nanoseconds of the slowest path that ends in it, if one does.
    pub slowest_ns: Option<f64>,
}

/// A cell or a wire on a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The type of the cell, with `clk-to-q` or `setup` at the ends; or `wire`, with the number of its readers.
    pub what: String,
    /// Nanoseconds in it.
    pub ns: f64,
    /// Nanoseconds from the clock edge to its end.
    pub at_ns: f64,
    /// The stage.
    pub stage: String,
    /// The signal of the text; `near` one if synthesis has made it; empty if no name is near.
    pub signal: String,
    /// The module and the line in the text that was synthesised, of cells for which synthesis keeps it.
    pub text: String,
}

impl Report {
    /// The report of a synthesised design. `routed` has the best run and the clocks of all.
    pub(crate) fn new(
        design: &str,
        [synthesis, place_and_route]: [&str; 2],
        device: Device,
        netlist: &Netlist,
        routed: Option<(Target, Timing, Vec<Run>)>,
    ) -> Self {
        let (cells, order) = (netlist.count(), &netlist.stages);
        let mut all = Cells::default();
        cells.values().for_each(|cells| all.add(cells));
        let mut names: Vec<&String> =
            order.iter().map(|(name, _)| name).filter(|name| cells.contains_key(*name)).collect();
        names.extend(cells.keys().filter(|name| !order.iter().any(|(other, _)| other == *name)));
        let slowest = |name: &str| routed.as_ref().and_then(|(_, timing, _)| timing.slowest.get(name).copied());
        let stage = |name: &String| Stage {
            name: name.clone(),
            cells: cells.get(name).copied().unwrap_or_default(),
            slowest_ns: slowest(name),
        };
        Self {
            design: design.to_string(),
            synthesis: synthesis.to_string(),
            device: device.to_string(),
            cells: all,
            stages: names.into_iter().map(stage).collect(),
            routed: routed.map(|(target, timing, runs)| Routed {
                place_and_route: place_and_route.to_string(),
                speed: target.speed,
                aim_mhz: target.clock_mhz,
                seed: target.seed,
                timing,
                runs,
            }),
        }
    }
}

impl Run {
    /// The speed grades of runs, in order, each with the best and the median clock in MHz.
    pub fn grades(runs: &[Self]) -> Vec<(u8, f64, f64)> {
        let mut speeds: Vec<u8> = Vec::new();
        runs.iter().for_each(|run| {
            if !speeds.contains(&run.speed) {
                speeds.push(run.speed)
            }
        });
        let grade = |speed: u8| {
            let mut clocks: Vec<f64> = runs.iter().filter(|run| run.speed == speed).map(|run| run.clock_mhz).collect();
            clocks.sort_by(f64::total_cmp);
            let middle = clocks.len() / 2;
            let median =
                if clocks.len() % 2 == 1 { clocks[middle] } else { (clocks[middle - 1] + clocks[middle]) / 2.0 };
            (speed, clocks[clocks.len() - 1], median)
        };
        speeds.into_iter().map(grade).collect()
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
        self.shift_registers += other.shift_registers;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn best_and_median_by_grade() {
        let runs = [(6, 1, 40.0), (6, 2, 50.0), (6, 3, 42.0), (8, 1, 60.0), (8, 2, 70.0)];
        let runs = runs.map(|(speed, seed, clock_mhz)| Run { speed, seed, clock_mhz });
        assert_eq!(Run::grades(&runs), [(6, 50.0, 42.0), (8, 70.0, 65.0)]);
    }
}
