//! The behaviour of a cell, from the functions in its Liberty description: what a simulation of gates computes.

use crate::function::truth_table;
use crate::liberty::Group;

/// The limit on the inputs of a cell: those of a truth table.
pub const MAX_INPUTS: usize = 6;

/// The behaviour of a cell with at most six inputs: a gate, or a flip-flop on the rising edge of its clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Logic {
    /// The input pins. Bit i of a position in a truth table is input i.
    pub inputs: Vec<String>,
    /// The output pins.
    pub outputs: Vec<(String, Output)>,
    /// The state of a flip-flop.
    pub state: Option<State>,
    /// The clock pin of a flip-flop or a clock gate.
    pub clock: Option<ClockPin>,
    /// Whether it is a clock gate with a latch, which is open while the clock is 0. The value of a gated clock is
    /// whether it has a pulse in the cycle, so a gate is the conjunction of its clock and its enable.
    pub is_clock_gate: bool,
}

/// The clock pin of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockPin {
    /// The index of the input.
    pub input: usize,
    /// Its capacitance in the library's unit.
    pub capacitance: f64,
}

/// The value of an output pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// A truth table of the inputs.
    Table(u64),
    /// The state of the flip-flop.
    State,
    /// The complement of the state.
    Complement,
}

/// The state of a flip-flop, as truth tables of the inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The state after a rising edge of the clock.
    pub next: u64,
    /// When the state is 0 at once; constant 0 without such an input.
    pub clear: u64,
    /// When the state is 1 at once; a clear takes precedence.
    pub preset: u64,
}

impl Logic {
    /// The behaviour of a cell. None if it is neither a gate nor a flip-flop on a rising edge, or has more than six
    /// inputs or an output without a function.
    pub fn of(cell: &Group<'_>) -> Option<Self> {
        let pins = |direction| cell.of_kind("pin").filter(move |pin| pin.attribute("direction") == Some(direction));
        let inputs: Vec<&str> = pins("input").map(Group::name).collect();
        if let Some(gate) = ClockGate::of(cell) {
            let inputs = [gate.clock, gate.enable].map(str::to_string).to_vec();
            let outputs = vec![(gate.output.to_string(), Output::Table(0b1000))];
            return Some(Self {
                inputs,
                outputs,
                state: None,
                clock: ClockPin::of(cell, gate.clock, 0),
                is_clock_gate: true,
            });
        }
        let is_other = |kind: &str| ["latch", "latch_bank", "ff_bank", "statetable"].contains(&kind);
        if inputs.len() > MAX_INPUTS || cell.groups.iter().any(|group| is_other(group.kind)) {
            return None;
        }
        let flip_flop = cell.of_kind("ff").next();
        let state = match flip_flop {
            Some(flip_flop) => Some(State::of(flip_flop, &inputs)?),
            None => None,
        };
        let names = flip_flop.map(|flip_flop| flip_flop.names.as_slice()).unwrap_or_default();
        let output = |pin: &Group<'_>| {
            if pin.attribute("three_state").is_some() {
                return None;
            }
            let function = pin.attribute("function")?.trim_matches(|c: char| c == '(' || c == ')' || c.is_whitespace());
            let value = match names.iter().position(|name| *name == function.trim_start_matches('!')) {
                Some(place) if (place == 1) != function.starts_with('!') => Output::Complement,
                Some(_) => Output::State,
                None => Output::Table(truth_table(pin.attribute("function")?, &inputs)?),
            };
            Some((pin.name().to_string(), value))
        };
        let outputs = pins("output").map(output).collect::<Option<_>>()?;
        let clock = flip_flop.map(|flip_flop| clocked_on(flip_flop)).map(|clock| {
            let input = inputs.iter().position(|input| Some(*input) == clock)?;
            ClockPin::of(cell, clock?, input)
        });
        let clock = match clock {
            Some(found) => Some(found?),
            None => None,
        };
        let inputs = inputs.into_iter().map(str::to_string).collect();
        Some(Self { inputs, outputs, state, clock, is_clock_gate: false })
    }
}

/// The input in the attribute `clocked_on`; None if it is another expression.
fn clocked_on<'a>(flip_flop: &Group<'a>) -> Option<&'a str> {
    Some(flip_flop.attribute("clocked_on")?.trim_matches(|c: char| c == '(' || c == ')' || c.is_whitespace()))
}

impl ClockPin {
    fn of(cell: &Group<'_>, name: &str, input: usize) -> Option<Self> {
        let pin = cell.of_kind("pin").find(|pin| pin.name() == name)?;
        let capacitance = pin.attribute("capacitance").and_then(|capacitance| capacitance.parse().ok());
        Some(Self { input, capacitance: capacitance.unwrap_or(0.0) })
    }
}

/// The pins of an integrated clock gate with a latch for the rising edge, and no other inputs.
pub struct ClockGate<'a> {
    pub clock: &'a str,
    pub enable: &'a str,
    pub output: &'a str,
}

impl<'a> ClockGate<'a> {
    /// None if the cell is no such gate.
    pub fn of(cell: &Group<'a>) -> Option<Self> {
        if cell.attribute("clock_gating_integrated_cell") != Some("latch_posedge") {
            return None;
        }
        let pin = |attribute| {
            let mut marked = cell.of_kind("pin").filter(move |pin| pin.attribute(attribute) == Some("true"));
            marked.next().map(|pin| pin.names.first().copied()).filter(|_| marked.next().is_none()).flatten()
        };
        let inputs = cell.of_kind("pin").filter(|pin| pin.attribute("direction") == Some("input")).count();
        let gate = Self {
            clock: pin("clock_gate_clock_pin")?,
            enable: pin("clock_gate_enable_pin")?,
            output: pin("clock_gate_out_pin")?,
        };
        (inputs == 2).then_some(gate)
    }
}

impl State {
    fn of(flip_flop: &Group<'_>, inputs: &[&str]) -> Option<Self> {
        let table = |name: &str| flip_flop.attribute(name).map_or(Some(0), |text| truth_table(text, inputs));
        Some(Self {
            next: truth_table(flip_flop.attribute("next_state")?, inputs)?,
            clear: table("clear")?,
            preset: table("preset")?,
        })
    }
}

/// The value of a truth table for each of 64 lanes; bit i of an input is its value in lane i.
pub fn evaluate(table: u64, inputs: &[u64]) -> u64 {
    let Some((first, others)) = inputs.split_first() else { return 0_u64.wrapping_sub(table & 1) };
    // The functions of the first input that the table has for each combination of the others.
    let mut values = [0; 32];
    let combinations = 1 << others.len();
    for (combination, value) in values[..combinations].iter_mut().enumerate() {
        *value = match table >> (2 * combination) & 3 {
            0 => 0,
            1 => !first,
            2 => *first,
            _ => u64::MAX,
        };
    }
    let mut left = combinations;
    for input in others {
        left /= 2;
        for pair in 0..left {
            values[pair] = (values[2 * pair] & !input) | (values[2 * pair + 1] & input);
        }
    }
    values[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::liberty;

    fn logic(cell: &str) -> Option<Logic> {
        let text = format!("library (l) {{ {cell} }}");
        let library = liberty::read(&text).expect("Liberty");
        Logic::of(library.of_kind("cell").next().expect("a cell"))
    }

    const PINS: &str = "pin (A) { direction : input; } pin (B) { direction : input; } ";

    #[test]
    fn gates_and_flip_flops() {
        let half_adder = logic(&format!(
            "cell (HA) {{ {PINS} pin (S) {{ direction : output; function : \"A^B\"; }}
             pin (C) {{ direction : output; function : \"A B\"; }} }}"
        ));
        let outputs = half_adder.expect("a gate").outputs;
        assert_eq!(outputs, [("S".to_string(), Output::Table(0b0110)), ("C".to_string(), Output::Table(0b1000))]);

        let flip_flop = logic(
            "cell (DFFR) { ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; clear : \"!R\"; }
             pin (CK) { direction : input; capacitance : 0.5; } pin (D) { direction : input; } pin (R) { direction : input; }
             pin (Q) { direction : output; function : \"IQ\"; } pin (QN) { direction : output; function : \"IQN\"; }
             pin (P) { direction : output; function : \"(!IQN)\"; } }",
        )
        .expect("a flip-flop");
        assert_eq!(flip_flop.clock, Some(ClockPin { input: 0, capacitance: 0.5 }));
        let state = State { next: 0b1100_1100, clear: 0b0000_1111, preset: 0 };
        assert_eq!(flip_flop.state, Some(state));
        let outputs: Vec<Output> = flip_flop.outputs.iter().map(|(_, output)| *output).collect();
        assert_eq!(outputs, [Output::State, Output::Complement, Output::State]);
    }

    #[test]
    fn clock_gates() {
        let cell = |kind: &str, more: &str| {
            logic(&format!(
                "cell (ICG) {{ clock_gating_integrated_cell : \"{kind}\"; statetable (\"CK EN\", \"M\") {{ }}
                 pin (EN) {{ direction : input; clock_gate_enable_pin : true; }}
                 pin (CK) {{ direction : input; clock_gate_clock_pin : true; capacitance : 0.25; }} {more}
                 pin (GCK) {{ direction : output; clock_gate_out_pin : true; state_function : \"CK M\"; }} }}"
            ))
        };
        let gate = cell("latch_posedge", "").expect("a gate");
        assert_eq!((gate.inputs.join(" "), gate.is_clock_gate), ("CK EN".to_string(), true));
        assert_eq!(gate.outputs, [("GCK".to_string(), Output::Table(0b1000))]);
        assert_eq!(gate.clock, Some(ClockPin { input: 0, capacitance: 0.25 }));
        // One with a pin for tests, and one for the falling edge.
        let scan = "pin (SE) { direction : input; clock_gate_test_pin : true; }";
        assert_eq!(cell("latch_posedge_precontrol", scan), None);
        assert_eq!(cell("latch_negedge", ""), None);
    }

    #[test]
    fn other_cells_have_none() {
        let output = "pin (Q) { direction : output; function : \"IQ\"; }";
        for cell in [
            format!("cell (LATCH) {{ latch (IQ, IQN) {{ enable : \"A\"; data_in : \"B\"; }} {PINS} {output} }}"),
            format!("cell (FALL) {{ ff (IQ, IQN) {{ next_state : \"A\"; clocked_on : \"!B\"; }} {PINS} {output} }}"),
            format!("cell (TRI) {{ {PINS} pin (Y) {{ direction : output; function : \"A\"; three_state : \"B\"; }} }}"),
            format!("cell (NONE) {{ {PINS} pin (Y) {{ direction : output; }} }}"),
        ] {
            assert_eq!(logic(&cell), None, "{cell}");
        }
    }

    /// Each lane against the bit of the table that its inputs select.
    #[test]
    fn tables_are_evaluated_in_every_lane() {
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        let mut word = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            random ^ random >> 29
        };
        for count in 0..=6 {
            let (table, inputs) = (word(), [(); 6].map(|()| word()));
            let found = evaluate(table, &inputs[..count]);
            for lane in 0..64 {
                let position: u64 = (0..count).map(|input| (inputs[input] >> lane & 1) << input).sum();
                assert_eq!(found >> lane & 1, table >> position & 1, "{count} inputs, lane {lane}");
            }
        }
    }
}
