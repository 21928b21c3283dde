//! The results of a measurement. The JSON file, the tables and the pictures show the same structures.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The figures of a design. Areas are in the library's unit, which is µm² in all known libraries; times in nanoseconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The design's name.
    pub design: String,
    /// The tools, the library and the period.
    pub setting: Setting,
    /// The area of the whole design.
    pub area: Area,
    /// The number of flip-flops.
    pub flip_flops: u64,
    /// Bits of memories, which are neither in the area nor among the flip-flops.
    #[serde(default)]
    pub memory_bits: u64,
    /// The area in kGE: thousands of the library's smallest NAND of two inputs.
    pub kilo_gates: f64,
    /// The slowest path of the design; its stage has the full path.
    pub slowest: Slowest,
    /// The clock frequency that this path allows.
    pub clock_mhz: f64,
    /// Area times the slowest path, in mm² ns.
    pub area_period: f64,
    /// The stages, from the input to the output.
    pub stages: Vec<Stage>,
    /// The power, if it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<Power>,
}

/// The power of a design in workloads, without glitches and wires.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// The clock period in nanoseconds: the design's slowest path. Leakage energy and power depend on it.
    pub period_ns: f64,
    /// The number of streams of jobs that were simulated side by side.
    pub streams: u64,
    /// The simulated cycles of all streams, in each of which the outputs of the gates were those of the netlist before
    /// synthesis.
    pub compared_cycles: u64,
    /// The workloads.
    pub workloads: Vec<WorkloadPower>,
}

/// The power of a design in a workload. Energies are in picojoules per cycle where nothing else is said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorkloadPower {
    /// The workload's name.
    pub name: String,
    /// The measured cycles of all streams.
    pub cycles: u64,
    /// The jobs accepted in them.
    pub jobs: u64,
    /// The power in milliwatts at [`Power::period_ns`].
    pub milliwatts: f64,
    /// The energy of a cycle.
    pub picojoules_per_cycle: f64,
    /// The energy of a job, with what the design takes meanwhile; None without jobs.
    pub picojoules_per_job: Option<f64>,
    /// Energy inside flip-flops for their clock pins, and for charging these.
    pub clock: f64,
    /// Other energy inside cells.
    pub internal: f64,
    /// Energy for charging the loads of cells.
    pub switching: f64,
    /// Energy that leaks in a cycle.
    pub leakage: f64,
    /// The stages, from the input to the output.
    pub stages: Vec<StagePower>,
}

/// The energy of a stage in picojoules per cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StagePower {
    /// The stage's name.
    pub name: String,
    /// The sum of all kinds.
    pub picojoules: f64,
    /// By kind: those of [`Area`], and `clock` for the clock pins of flip-flops.
    pub kinds: BTreeMap<String, f64>,
}

impl WorkloadPower {
    /// The energy of all stages by kind, in picojoules per cycle.
    pub fn kinds(&self) -> BTreeMap<&str, f64> {
        let mut sums = BTreeMap::new();
        for (kind, energy) in self.stages.iter().flat_map(|stage| &stage.kinds) {
            *sums.entry(kind.as_str()).or_default() += energy;
        }
        sums
    }
}

/// The tools and the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Yosys and its version.
    pub synthesis: String,
    /// OpenSTA and its version.
    pub timing: String,
    /// The cell library's own name.
    pub library: String,
    /// The library's smallest NAND of two inputs.
    pub nand2: String,
    /// The buffer that drives every input.
    pub buffer: String,
    /// The load of every output, in femtofarads.
    pub load_ff: f64,
    /// The clock period for which gates were chosen, in nanoseconds.
    pub period_ns: f64,
    /// The part of it for which units were optimised, if the gates around them were optimised for the rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_period_ns: Option<f64>,
}

impl Setting {
    /// The periods for which gates were chosen: `12 ns`, or `12 ns, of which 8 ns for units`.
    pub fn periods(&self) -> String {
        let units = self.unit_period_ns.map(|ns| format!(", of which {ns} ns for units")).unwrap_or_default();
        format!("{} ns{units}", self.period_ns)
    }
}

/// A stage: its registers, and the units and gates before them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// The stage's name: `input`, `stage 3`, `output`.
    pub name: String,
    /// The stage's area.
    pub area: Area,
    /// The stage's flip-flops.
    pub flip_flops: u64,
    /// The slowest path that ends in the stage; None if it has neither registers nor ports.
    pub slowest: Option<Path>,
}

/// Area by kind.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Area {
    /// The sum of all kinds.
    pub total: f64,
    /// Floating-point units by operation, and part if pipelined: `add`, `mul 1/2`.
    pub units: BTreeMap<String, Units>,
    /// Flip-flops that hold a job's data or an operation's state.
    pub registers: f64,
    /// Gates that reach units only: operand multiplexers.
    pub operand_muxes: f64,
    /// Gates that reach registers only: multiplexers of results, and those of skid buffers.
    pub register_muxes: f64,
    /// Gates that reach both: shared subexpressions and opcode decoders.
    pub shared_logic: f64,
    /// Gates that reach output ports only.
    pub output_gates: f64,
    /// Flip-flops of the handshake, and gates that reach only them.
    pub control: f64,
}

/// Units of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Units {
    /// Their number.
    pub count: u64,
    /// Their area together.
    pub area: f64,
}

/// The slowest path of a design.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Slowest {
    /// The stage that it ends in; empty if unknown.
    #[serde(default)]
    pub stage: String,
    /// Its delay, set-up time included.
    pub ns: f64,
}

/// A path from a register or an input port to a register or an output port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// The delay from the clock edge: arrival time at the end, and set-up time.
    pub ns: f64,
    /// The register or port that it starts at: `stage 3 num_4_q[7]`, `port opcode_i[0]`.
    pub start: String,
    /// The register or port that it ends at.
    pub end: String,
    /// The elements on the path, from the start to the end.
    pub steps: Vec<Step>,
    /// The part of `ns` that is the set-up time of the register at the end.
    pub setup_ns: f64,
}

/// An element of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// A register, a unit (`u_add_4`), or `gates`.
    pub through: String,
    /// The time after the clock edge at which the signal leaves it.
    pub ns: f64,
}

impl Area {
    /// The kinds other than units, with their names in tables.
    pub fn other_kinds(&self) -> [(&'static str, f64); 6] {
        [
            ("registers", self.registers),
            ("operand muxes", self.operand_muxes),
            ("register muxes", self.register_muxes),
            ("shared logic", self.shared_logic),
            ("output gates", self.output_gates),
            ("control", self.control),
        ]
    }

    /// The area of all units.
    pub fn units_area(&self) -> f64 {
        self.units.values().map(|units| units.area).sum()
    }

    /// The share of units in the total, 0 to 1.
    pub fn unit_share(&self) -> f64 {
        if self.total > 0.0 { self.units_area() / self.total } else { 0.0 }
    }

    /// Adds another area. Sums are rounded, so that they print without trailing digits.
    pub(crate) fn add(&mut self, other: &Self) {
        for (kind, units) in &other.units {
            let sum = self.units.entry(kind.clone()).or_default();
            sum.count += units.count;
            sum.area = thousandths(sum.area + units.area);
        }
        self.registers = thousandths(self.registers + other.registers);
        self.operand_muxes = thousandths(self.operand_muxes + other.operand_muxes);
        self.register_muxes = thousandths(self.register_muxes + other.register_muxes);
        self.shared_logic = thousandths(self.shared_logic + other.shared_logic);
        self.output_gates = thousandths(self.output_gates + other.output_gates);
        self.control = thousandths(self.control + other.control);
        self.total = thousandths(self.units_area() + self.other_kinds().iter().map(|(_, area)| area).sum::<f64>());
    }
}

/// The measured configurations of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exploration {
    /// In the order of the sweep.
    pub points: Vec<DesignPoint>,
}

/// A measured configuration with its throughput.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignPoint {
    /// A preset's name, or what differs from the default.
    pub name: String,
    /// The command-line options for it.
    pub options: String,
    /// Box tests per second at the reported clock: a job per cycle, four boxes per job.
    pub boxes_per_second: f64,
    /// Dimensions of Euclidean distances per second at the reported clock: a beat per cycle; 0 without distance modes.
    pub dimensions_per_second: f64,
    /// The measurement.
    pub report: Report,
}

/// Boxes per job.
const BOXES: f64 = 4.0;

impl DesignPoint {
    /// A configuration with this number of Euclidean lanes (0 without distance modes), and its measurement.
    pub fn new(name: impl Into<String>, options: impl Into<String>, lanes: usize, report: Report) -> Self {
        let cycles = report.clock_mhz * 1e6;
        Self {
            name: name.into(),
            options: options.into(),
            boxes_per_second: cycles * BOXES,
            dimensions_per_second: cycles * lanes as f64,
            report,
        }
    }
}

/// Rounds to thousandths.
pub(crate) fn thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
