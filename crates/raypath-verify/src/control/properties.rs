//! The properties to prove of a datapath: of each step, of the entrance, and of the whole pipeline.

use super::lemmas;
use super::model_checker::{Method, SafetyProblem};
use crate::error::Error;
use raypath_hdl::Module;
use raypath_hdl::verilog::{self, Source};
use raypath_rtl::{Bind, Checker, Config, Control, Datapath, UnitLatency};
use std::collections::HashMap;
use std::sync::Arc;

/// A deliberate fault: a text in a module, and its replacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextFault {
    /// The module's name.
    pub module: &'static str,
    /// The original text.
    pub from: &'static str,
    /// The faulty text.
    pub to: &'static str,
}

/// The modules of a datapath as text, with empty units.
#[derive(Debug, Clone)]
pub struct ModuleTexts {
    modules: Vec<(String, String)>,
}

impl ModuleTexts {
    /// Prints a datapath.
    ///
    /// # Errors
    /// It cannot be printed.
    pub fn new(top: &Arc<Module>) -> Result<Self, Error> {
        let modules = verilog::modules(top)?;
        let units = modules.iter().filter(|module| is_free(module.name()));
        let shells: HashMap<&str, String> = units.map(|unit| (unit.name(), shell(unit))).collect();
        let text = |source: Source| {
            let text = shells.get(source.name.as_str()).cloned().unwrap_or(source.text);
            (source.name, text)
        };
        Ok(Self { modules: verilog::sources(top, &[])?.into_iter().map(text).collect() })
    }

    /// Inserts a fault. Returns false if its original text does not occur.
    pub fn insert(&mut self, fault: TextFault) -> bool {
        let module = self.modules.iter_mut().find(|(name, _)| name == fault.module);
        let Some((_, text)) = module.filter(|(_, text)| text.contains(fault.from)) else { return false };
        *text = text.replace(fault.from, fault.to);
        true
    }

    /// A module with `inside` before its end, and the modules below it. There is no other text, so that equal modules
    /// of different datapaths have equal texts.
    pub(crate) fn with(&self, module: &str, inside: &str) -> String {
        let mut below = vec![module];
        let mut next = 0;
        while let Some(&name) = below.get(next) {
            next += 1;
            let Some((_, text)) = self.modules.iter().find(|(other, _)| other == name) else { continue };
            let is_new = |other: &&str| !below.contains(other) && text.contains(&format!("  {other} "));
            let new: Vec<&str> = self.modules.iter().map(|(name, _)| name.as_str()).filter(is_new).collect();
            below.extend(new);
        }
        let mut all = String::new();
        let is_needed = |name: &str, text: &str| below.contains(&name) || text.contains("\nendpackage");
        for (name, text) in self.modules.iter().filter(|(name, text)| is_needed(name, text)) {
            match text.rsplit_once("endmodule").filter(|_| name == module) {
                Some((head, _)) => all += &format!("{head}{inside}\nendmodule\n"),
                None => all += text,
            }
        }
        all
    }
}

/// Whether the outputs of a module are free in every cycle: a floating-point unit, a rounding to fewer bits, or what a
/// step of the traversal unit prepares.
fn is_free(module: &str) -> bool {
    module.starts_with("raypath_fp_") || module.starts_with("raypath_narrow_") || module == "raypath_unit_prepare"
}

/// A unit's ports without its logic.
fn shell(module: &Module) -> String {
    let port = |direction: &str, name: &str, width: u32| format!("{direction} logic [{}:0] {name}", width - 1);
    let clock = [("clk_i", module.is_clocked()), ("rst_ni", module.has_reset())];
    let clock = clock.iter().filter(|(_, there)| *there).map(|(name, _)| port("input", name, 1));
    let width = |port: &raypath_hdl::Port| module.signal(port.signal).width;
    let inputs = module.inputs().iter().map(|p| port("input", &p.name, width(p)));
    let outputs = module.outputs().iter().map(|p| port("output", &p.name, width(p)));
    let ports: Vec<String> = clock.chain(inputs).chain(outputs).collect();
    format!("(* blackbox *)\nmodule {} (\n  {}\n);\nendmodule\n", module.name(), ports.join(",\n  "))
}

/// Reset in the first cycle; later cycles are free to reset.
pub(crate) const RESET: &str = "  initial assume (!rst_ni);\n";

/// All properties to prove of a datapath.
pub fn problems(datapath: &Datapath, config: Config, texts: &ModuleTexts) -> Vec<SafetyProblem> {
    let properties = datapath.properties();
    let mut modules: Vec<&str> = properties.binds().iter().map(|bind| bind.module.as_str()).collect();
    modules.dedup();
    let mut problems = Vec::new();
    for module in modules {
        let own: Vec<&Bind> = properties.binds().iter().filter(|bind| bind.module == module).collect();
        let last = datapath.module(datapath.steps().count() - 1);
        let is_exit =
            config.microarchitecture.control == Control::Credit && last.is_some_and(|last| last.name() == module);
        let is_top = module == datapath.top().name();
        // The order of many jobs needs lemmas, the order in a single step does not.
        let is_long = |bind: &&&Bind| (is_top || is_exit) && bind.checker == Checker::Order;
        let (order, others): (Vec<&Bind>, Vec<&Bind>) = own.iter().partition(is_long);
        let environment = environment(datapath, config, module);
        // A longer pipeline is proved step by step.
        let order =
            if is_top && config.microarchitecture.unit_latency != UnitLatency::One { Vec::new() } else { order };
        let lemmas = || if is_top { lemmas::of_pipeline(datapath, config) } else { lemmas::of_exit(datapath) };
        for (binds, method) in [(others, Method::Unbounded), (order, Method::Inductive)] {
            if !binds.is_empty() {
                let (besides, more) = match method {
                    Method::Inductive => (environment.clone() + &lemmas(), 1),
                    _ => (environment.clone(), 0),
                };
                let problem = problem(texts, module, &binds, &besides, method);
                problems.push(SafetyProblem { assertions: problem.assertions + more, ..problem });
            }
        }
    }
    problems
}

fn problem(texts: &ModuleTexts, module: &str, binds: &[&Bind], environment: &str, method: Method) -> SafetyProblem {
    let instances: String = binds.iter().map(|bind| format!("  {}\n", bind.instance())).collect();
    let mut text = texts.with(module, &format!("{instances}{environment}{RESET}"));
    let mut checkers: Vec<Checker> = binds.iter().map(|bind| bind.checker).collect();
    checkers.sort_unstable();
    checkers.dedup();
    checkers.iter().for_each(|checker| text += checker.text());
    let assertions = binds.iter().map(|bind| bind.checker.assertions()).sum();
    let names: Vec<String> = checkers.iter().map(|checker| checker.module()).collect();
    SafetyProblem { name: format!("{module}: {}", names.join(", ")), top: module.to_string(), text, assertions, method }
}

/// Assumptions about a module's neighbours: no job arrives at a full exit (`raypath_credit` ensures it), and no credit
/// returns to `raypath_credit` that it has not given (the exit ensures it).
fn environment(datapath: &Datapath, config: Config, module: &str) -> String {
    let steps = datapath.steps().count();
    let is_exit = datapath.module(steps - 1).is_some_and(|last| last.name() == module);
    let (up, down, never) = match (config.microarchitecture.control, module) {
        (Control::Credit, "raypath_credit") => {
            ("valid_o", "returned_i", "returned_i && environment_q == 0".to_string())
        }
        // `raypath_credit` keeps jobs apart; a lemma of the whole pipeline shows it.
        (Control::Credit, "raypath_rounds") => {
            let near = datapath.interval() - 2;
            return format!("  always_comb assume (!(valid_i && at_q[{near}:0] != 0));\n");
        }
        (Control::Credit, _) if is_exit => {
            let full = datapath.capacity();
            ("valid_i", "valid_o && ready_i", format!("valid_i && environment_q == {full}"))
        }
        _ => return String::new(),
    };
    format!(
        "  logic [7:0] environment_q;\n  \
         always_ff @(posedge clk_i or negedge rst_ni)\n    \
         if (!rst_ni) environment_q <= 0;\n    \
         else environment_q <= environment_q + 8'({up}) - 8'({down});\n  \
         always_comb assume (!({never}));\n"
    )
}

/// The property that no job ever leaves a module. It must be refuted; otherwise the module's other proofs are vacuous.
pub fn never_leaves(datapath: &Datapath, config: Config, texts: &ModuleTexts, module: &str) -> SafetyProblem {
    let leaves = if module == datapath.top().name() { "output_valid_o && output_ready_i" } else { "valid_o" };
    let never = format!("  always_ff @(posedge clk_i) never_leaves: assert (!({leaves}));\n");
    SafetyProblem {
        name: format!("{module}: never_leaves"),
        top: module.to_string(),
        text: texts.with(module, &format!("{never}{}{RESET}", environment(datapath, config, module))),
        assertions: 1,
        method: Method::Bounded(datapath.latency() + 4),
    }
}
