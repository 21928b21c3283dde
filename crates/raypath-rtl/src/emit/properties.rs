//! Assertions about the control of the pipeline: checkers in SystemVerilog, and the modules that they are bound to.
//!
//! The checkers are clocked processes with immediate assertions. Simulators and Yosys read the same text, so users bind
//! the text that is proved.

use crate::allocate::plan::Plan;
use crate::config::Control;
use crate::emit::control::words;
use crate::emit::top::Pipeline;
use crate::emit::{interface, positions, stage};
use crate::fold::Rounds;
use crate::ir::graph::OperationGraph;
use crate::ir::position::Step;
use raypath_hdl::{Driver, Module, RegisterInfo};
use std::collections::BTreeSet;
use std::fmt;

/// Checkers and the modules that they are bound to. Its `Display` is the file `raypath_properties.sv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Properties {
    binds: Vec<Bind>,
}

/// A checker in a module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bind {
    /// The module that it is bound to.
    pub module: String,
    /// The checker.
    pub checker: Checker,
    /// Its parameters and their values.
    pub parameters: Vec<(&'static str, u64)>,
    /// Its ports, without clock and reset, and the nets of the module that are connected to them.
    pub connections: Vec<(&'static str, String)>,
    /// The part of the instance name that distinguishes checkers of one kind in a module; may be empty.
    pub about: String,
}

/// A kind of checker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Checker {
    /// Jobs are neither lost nor repeated nor reordered.
    Order,
    /// An output that is not accepted stays valid and unchanged.
    Stall,
    /// An accumulator acts exactly once for each beat.
    State,
    /// A beat reads the value that the beat before it wrote.
    Beats,
    /// The pipeline accepts no more jobs than it can hold.
    Credit,
    /// Jobs of a folded pipeline keep their distance.
    Rounds,
}

impl Properties {
    pub(crate) fn new(plan: &Plan, pipeline: &Pipeline) -> Self {
        let mut binds = vec![order_of_top(plan), stall_of_top(&pipeline.top)];
        binds.extend(pipeline.credit.iter().map(|module| entrance(plan, module)));
        // The credits of a folded pipeline keep the jobs of a loop apart.
        for traced in plan.operations.iter().filter(|traced| traced.is_loop() && plan.rounds.is_none()) {
            binds.push(beats(plan, traced));
        }
        binds.extend(plan.rounds.iter().zip(&pipeline.rounds).map(|(rounds, module)| distance(plan, rounds, module)));
        for (step, module) in pipeline.steps.iter().enumerate() {
            // The jobs of a folded pipeline are in one register of positions, up to the exit.
            if plan.rounds.is_none() || step == plan.last() {
                binds.push(order_of_step(plan, step, module));
            }
            binds.extend(states(plan, step, module));
        }
        Self { binds }
    }

    /// The checkers with their modules.
    pub fn binds(&self) -> &[Bind] {
        &self.binds
    }

    /// The checkers that are bound somewhere.
    pub fn checkers(&self) -> BTreeSet<Checker> {
        self.binds.iter().map(|bind| bind.checker).collect()
    }
}

impl Checker {
    /// Its module.
    pub fn module(self) -> String {
        format!("raypath_{}_properties", self.name())
    }

    /// The text of its module.
    pub fn text(self) -> &'static str {
        match self {
            Self::Order => include_str!("properties/order.sv"),
            Self::Stall => include_str!("properties/stall.sv"),
            Self::State => include_str!("properties/state.sv"),
            Self::Beats => include_str!("properties/beats.sv"),
            Self::Credit => include_str!("properties/credit.sv"),
            Self::Rounds => include_str!("properties/rounds.sv"),
        }
    }

    /// The number of its assertions.
    pub fn assertions(self) -> usize {
        self.text().matches("assert (").count()
    }

    fn name(self) -> &'static str {
        match self {
            Self::Order => "order",
            Self::Stall => "stall",
            Self::State => "state",
            Self::Beats => "beats",
            Self::Credit => "credit",
            Self::Rounds => "rounds",
        }
    }
}

impl Bind {
    fn new(module: &str, checker: Checker) -> Self {
        Self {
            module: module.to_string(),
            checker,
            parameters: Vec::new(),
            connections: Vec::new(),
            about: String::new(),
        }
    }

    /// A checker of opcodes, with the width of the plan's opcodes.
    fn of_opcodes(plan: &Plan, module: &str, checker: Checker) -> Self {
        Self::new(module, checker).parameter("OpcodeWidth", plan.opcode_width().into())
    }

    fn parameter(mut self, name: &'static str, value: u64) -> Self {
        self.parameters.push((name, value));
        self
    }

    fn connect(mut self, port: &'static str, net: impl Into<String>) -> Self {
        self.connections.push((port, net.into()));
        self
    }

    /// The checker as an instance for the text of the module.
    pub fn instance(&self) -> String {
        let parameters: Vec<String> =
            self.parameters.iter().map(|(name, value)| format!("    .{name} ({value})")).collect();
        let parameters = match parameters.as_slice() {
            [] => String::new(),
            some => format!(" #(\n{}\n  )", some.join(",\n")),
        };
        let fixed = [("clk_i", "clk_i"), ("rst_ni", "rst_ni")];
        let others = self.connections.iter().map(|(port, net)| (*port, net.as_str()));
        let connections: Vec<String> =
            fixed.into_iter().chain(others).map(|(port, net)| format!("    .{port} ({net})")).collect();
        let about = if self.about.is_empty() { String::new() } else { format!("{}_", self.about) };
        let name = format!("u_{about}{}_properties", self.checker.name());
        format!("{}{parameters} {name} (\n{}\n  );", self.checker.module(), connections.join(",\n"))
    }
}

/// The modules of the checkers, then the bind statements.
impl fmt::Display for Properties {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for checker in self.checkers() {
            writeln!(f, "\n{}", checker.text().trim_end())?;
        }
        self.binds.iter().try_for_each(|bind| write!(f, "\nbind {} {}\n", bind.module, bind.instance()))
    }
}

/// Jobs from the source to the sink. The oldest job inside waits for nothing but the sink.
fn order_of_top(plan: &Plan) -> Bind {
    Bind::of_opcodes(plan, "raypath", Checker::Order)
        .parameter("Capacity", plan.capacity())
        .parameter("MaxWaits", plan.latency().into())
        .connect("enter_valid_i", "input_valid_i")
        .connect("enter_ready_i", "input_ready_o")
        .connect("enter_opcode_i", "opcode_i")
        .connect("leave_valid_i", "output_valid_o")
        .connect("leave_ready_i", "output_ready_i")
        .connect("leave_opcode_i", "opcode_o")
}

fn stall_of_top(top: &Module) -> Bind {
    let handshake = ["input_ready_o", "output_valid_o"];
    let data: Vec<_> = top.outputs().iter().filter(|port| !handshake.contains(&port.name.as_str())).collect();
    let width = data.iter().map(|port| u64::from(top.signal(port.signal).width)).sum();
    let names: Vec<&str> = data.iter().map(|port| port.name.as_str()).collect();
    Bind::new("raypath", Checker::Stall)
        .parameter("Width", width)
        .connect("valid_i", "output_valid_o")
        .connect("ready_i", "output_ready_i")
        .connect("data_i", format!("{{\n      {}\n    }}", names.join(",\n      ")))
}

fn entrance(plan: &Plan, module: &Module) -> Bind {
    Bind::new(module.name(), Checker::Credit)
        .parameter("Capacity", plan.capacity())
        .connect("enters_i", "valid_o")
        .connect("returned_i", "returned_i")
}

/// The distance of jobs in a folded pipeline.
fn distance(plan: &Plan, rounds: &Rounds, module: &Module) -> Bind {
    let last = rounds.positions() - 1;
    let words = words(rounds.positions());
    let (enters, leaves) = match plan.microarchitecture.control {
        Control::Skid => ("enters", format!("at_q[{last}] & ready_i")),
        Control::Credit => ("valid_i", format!("{}[{}]", words[words.len() - 1].0, words[words.len() - 1].1 - 1)),
    };
    let all: Vec<&str> = words.iter().rev().map(|(name, _)| name.as_str()).collect();
    Bind::new(module.name(), Checker::Rounds)
        .parameter("Positions", rounds.positions().into())
        .parameter("Interval", rounds.interval.into())
        .connect("enters_i", enters)
        .connect("leaves_i", leaves)
        .connect("at_i", if all.len() == 1 { all[0].to_string() } else { format!("{{{}}}", all.join(", ")) })
}

/// Jobs through the registers of a step, which hold one or two jobs, or at the exit one for every credit.
fn order_of_step(plan: &Plan, step: usize, module: &Module) -> Bind {
    let capacity = match plan.microarchitecture.control {
        Control::Skid => 2,
        Control::Credit if step == plan.last() => plan.capacity(),
        Control::Credit => 1,
    };
    Bind::of_opcodes(plan, module.name(), Checker::Order)
        .parameter("Capacity", capacity)
        .parameter("MaxWaits", 1)
        .connect("enter_valid_i", "valid_i")
        .connect("enter_ready_i", port_or_one(module, "ready_o"))
        .connect("enter_opcode_i", module.port_text("opcode_i"))
        .connect("leave_valid_i", "valid_o")
        .connect("leave_ready_i", port_or_one(module, "ready_i"))
        .connect("leave_opcode_i", module.port_text("opcode_o"))
}

/// The port, or 1 if the module never stalls and has no such port.
fn port_or_one(module: &Module, port: &str) -> String {
    module.port_width(port).map_or("1'b1", |_| port).to_string()
}

/// The accumulators that a step writes.
fn states(plan: &Plan, step: usize, module: &Module) -> Vec<Bind> {
    let mut binds = Vec::new();
    for (op, traced) in plan.operations.iter().enumerate() {
        let own = traced.states.iter().enumerate().filter(|(_, state)| state.written == Step(step as u32));
        for (number, state) in own {
            // In a folded pipeline the state changes at one position of the step.
            let valid = plan.rounds.as_ref().map_or("valid_i".to_string(), |rounds| {
                format!("{}_i", positions::moves(rounds.states[op][number], &positions::stops(plan)))
            });
            let stem = stage::port(traced, state);
            let named = |register: &&RegisterInfo| module.signal(register.signal).name == Some(format!("{stem}_q"));
            let Some(register) = module.registers().iter().find(named) else { continue };
            let (reset, sum) = reset_and_sum(module, register);
            let bind = Bind { about: stem.clone(), ..Bind::of_opcodes(plan, module.name(), Checker::State) };
            binds.push(
                bind.parameter("Width", module.signal(register.signal).width.into())
                    .parameter("Opcode", traced.opcode)
                    .connect("valid_i", valid)
                    .connect("ready_i", port_or_one(module, "ready_o"))
                    .connect("opcode_i", module.port_text("opcode_i"))
                    .connect("reset_i", reset)
                    .connect("sum_i", sum)
                    .connect("state_i", format!("{stem}_q")),
            );
        }
    }
    binds
}

/// A state's next value as two nets: zero where the first is 1, else the second.
fn reset_and_sum(module: &Module, register: &RegisterInfo) -> (String, String) {
    let name = |signal| module.signal(signal).name.clone();
    let zero = |signal| module.signal(signal).driver == Driver::Constant(0);
    let parts = match module.signal(register.next).driver {
        Driver::Mux { select, if_true, if_false } if zero(if_true) => name(select).zip(name(if_false)),
        _ => None,
    };
    let next = module.signal(register.next);
    let whole = match next.driver {
        Driver::Constant(value) => Some(format!("{}'h{value:x}", next.width)),
        _ => next.name.clone(),
    };
    // A state that no beat resets takes its next value whole.
    parts.or_else(|| Some(("1'b0".to_string(), whole?))).unwrap_or_default()
}

/// Beats between the step that reads a state and the one that writes it.
fn beats(plan: &Plan, traced: &OperationGraph<Step>) -> Bind {
    let read = traced.first_read().0 as usize;
    let written = traced.last_write().0 as usize;
    // The top names the wires around a step after the instances that drive them.
    let before = |step: usize| interface::step_name(plan.steps[step.saturating_sub(1)].label);
    let ready = |step: usize| match plan.microarchitecture.control {
        Control::Skid => format!("{}_ready", interface::step_name(plan.steps[step].label)),
        Control::Credit => "1'b1".to_string(),
    };
    Bind { about: traced.name.to_string(), ..Bind::of_opcodes(plan, "raypath", Checker::Beats) }
        .parameter("Opcode", traced.opcode)
        .connect("read_valid_i", format!("{}_valid", before(read)))
        .connect("read_ready_i", ready(read))
        .connect("read_opcode_i", format!("{}_data.opcode", before(read)))
        .connect("write_valid_i", format!("{}_valid", before(written)))
        .connect("write_ready_i", ready(written))
        .connect("write_opcode_i", format!("{}_data.opcode", before(written)))
}
