//! What a measurement found. The same structures are the JSON file, the tables and the pictures.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The figures of a design. Areas are in the library's unit, µm² in all that we know; times in nanoseconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What was measured.
    pub design: String,
    /// On what.
    pub setting: Setting,
    /// Everything.
    pub area: Area,
    /// All flip-flops.
    pub flip_flops: u64,
    /// Area in thousands of the library's smallest NAND of two inputs.
    pub kilo_gates: f64,
    /// The slowest path of all; its stage has it in full.
    pub slowest: Slowest,
    /// What that path allows.
    pub clock_mhz: f64,
    /// Area times the slowest path, in mm² ns: what throughput costs.
    pub area_period: f64,
    /// From the input to the output.
    pub stages: Vec<Stage>,
}

/// The tools and the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Yosys and its version.
    pub synthesis: String,
    /// OpenSTA and its version.
    pub timing: String,
    /// The cell library's name for itself.
    pub library: String,
    /// Its smallest NAND of two inputs.
    pub nand2: String,
    /// The buffer that drives every input.
    pub buffer: String,
    /// What every output drives, in femtofarads.
    pub load_ff: f64,
    /// The period that gates were chosen for, in nanoseconds.
    pub period_ns: f64,
}

/// One stage: its registers, and all gates and units that lead to them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// `input`, `stage 3`, `output`.
    pub name: String,
    /// Its share.
    pub area: Area,
    /// Its flip-flops.
    pub flip_flops: u64,
    /// The slowest path that ends in it; none where it has neither registers nor ports.
    pub slowest: Option<Path>,
}

/// Area by kind.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Area {
    /// The sum of all kinds.
    pub total: f64,
    /// Units by what they compute: `add`, `mul 1/2`.
    pub units: BTreeMap<String, Units>,
    /// Flip-flops that hold a job, or state of an operation.
    pub registers: f64,
    /// Gates that lead to units alone: the choice of their operands.
    pub operand_muxes: f64,
    /// Gates that lead to registers alone: the choice of what is handed on, and holding and skidding.
    pub register_muxes: f64,
    /// Gates that lead to both: what several units work on, and decoding of the opcode.
    pub shared_logic: f64,
    /// Gates that lead to output ports alone.
    pub output_gates: f64,
    /// Flip-flops of the handshake, and gates that lead to them alone.
    pub control: f64,
}

/// Units of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Units {
    /// How many.
    pub count: u64,
    /// What they take together.
    pub area: f64,
}

/// The slowest path of all.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Slowest {
    /// Where it ends.
    pub stage: String,
    /// How long it is, set-up time included.
    pub ns: f64,
}

/// A path from a register or an input port to a register or an output port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// From the clock's edge to where the value must stand: the last arrival and the set-up time.
    pub ns: f64,
    /// `stage 3 num_4_q[7]`, `port opcode_i[0]`.
    pub start: String,
    /// Likewise.
    pub end: String,
    /// What it passes, and when it leaves each.
    pub steps: Vec<Step>,
    /// The part of `ns` that the register at the end asks for.
    pub setup_ns: f64,
}

/// Something on a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// A register, a unit (`u_add_4`), or `gates`.
    pub through: String,
    /// When the signal leaves it, after the clock's edge.
    pub ns: f64,
}

impl Area {
    /// The kinds beside units, under their names in tables.
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

    /// All units.
    pub fn units_area(&self) -> f64 {
        self.units.values().map(|units| units.area).sum()
    }

    /// What units have of it, 0 to 1.
    pub fn unit_share(&self) -> f64 {
        if self.total > 0.0 { self.units_area() / self.total } else { 0.0 }
    }

    /// Adds another. Sums are rounded, so that no binary fractions trail behind them.
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

/// Rounded to thousandths: of µm², of ns.
pub(crate) fn thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}
