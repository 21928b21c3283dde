//! What is proved of a datapath: each step alone, the entrance alone, the whole.

use super::engine::{Method, Problem};
use crate::Error;
use raypath_hdl::{Module, verilog};
use raypath_rtl::{Bind, Checker, Config, Control, Datapath};
use std::sync::Arc;

/// A text that stands in a module in the place of another: a fault to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// The module.
    pub module: &'static str,
    /// What is there.
    pub from: &'static str,
    /// What is put there.
    pub to: &'static str,
}

/// Modules of a datapath as text, units empty.
#[derive(Debug, Clone)]
pub struct Texts {
    modules: Vec<(String, String)>,
}

impl Texts {
    /// Prints a datapath.
    ///
    /// # Errors
    /// It cannot be printed.
    pub fn new(top: &Arc<Module>) -> Result<Self, Error> {
        let print = |module: &Arc<Module>| {
            let name = module.name().to_string();
            let text =
                if name.starts_with("raypath_fp_") { shell(module) } else { verilog::print_module(module, &[])? };
            Ok((name, text))
        };
        let modules = verilog::modules(top)?;
        Ok(Self { modules: modules.iter().map(print).collect::<Result<_, Error>>()? })
    }

    /// Puts a fault in. False where the text is not there.
    pub fn insert(&mut self, fault: Fault) -> bool {
        let module = self.modules.iter_mut().find(|(name, _)| name == fault.module);
        let Some((_, text)) = module.filter(|(_, text)| text.contains(fault.from)) else { return false };
        *text = text.replace(fault.from, fault.to);
        true
    }

    /// All of it, with `inside` before the end of `module`.
    fn with(&self, module: &str, inside: &str) -> String {
        let mut all = String::new();
        for (name, text) in &self.modules {
            match text.rsplit_once("endmodule").filter(|_| name == module) {
                Some((head, _)) => all += &format!("{head}{inside}\nendmodule\n"),
                None => all += text,
            }
        }
        all
    }
}

/// A unit without its inside.
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

/// The first cycle is a reset; later ones may be, at any moment.
const RESET: &str = "  initial assume (!rst_ni);\n";

/// Everything to prove of a datapath. `cycles` is how far the whole pipeline's order is followed.
pub fn problems(datapath: &Datapath, config: Config, texts: &Texts, cycles: u32) -> Vec<Problem> {
    let properties = datapath.properties();
    let mut modules: Vec<&str> = properties.binds().iter().map(|bind| bind.module.as_str()).collect();
    modules.dedup();
    let mut problems = Vec::new();
    for module in modules {
        let own: Vec<&Bind> = properties.binds().iter().filter(|bind| bind.module == module).collect();
        let is_top = module == datapath.top().name();
        // In the whole, and at an exit with pointers, the order of 13 to 60 jobs is beyond the lemmas that induction
        // finds by itself.
        let last = datapath.steps().count() - 1;
        let is_exit = config.control == Control::Credit && datapath.module(last).is_some_and(|m| m.name() == module);
        let bounded = |bind: &&&Bind| (is_top || is_exit) && bind.checker == Checker::Order;
        let (order, others): (Vec<&Bind>, Vec<&Bind>) = own.iter().partition(bounded);
        let environment = environment(datapath, config, module);
        for (binds, method) in [(others, Method::Unbounded), (order, Method::Bounded(cycles))] {
            if !binds.is_empty() {
                problems.push(problem(texts, module, &binds, &environment, method));
            }
        }
    }
    problems
}

fn problem(texts: &Texts, module: &str, binds: &[&Bind], environment: &str, method: Method) -> Problem {
    let instances: String = binds.iter().map(|bind| format!("  {}\n", bind.instance())).collect();
    let mut text = texts.with(module, &format!("{instances}{environment}{RESET}"));
    let mut checkers: Vec<Checker> = binds.iter().map(|bind| bind.checker).collect();
    checkers.sort_unstable();
    checkers.dedup();
    checkers.iter().for_each(|checker| text += checker.text());
    let assertions = binds.iter().map(|bind| bind.checker.assertions()).sum();
    let names: Vec<String> = checkers.iter().map(|checker| checker.module()).collect();
    Problem { name: format!("{module}: {}", names.join(", ")), top: module.to_string(), text, assertions, method }
}

/// What a module alone may rely on: nothing arrives at an exit that is full, which `raypath_credit` sees to; nothing is
/// returned to `raypath_credit` that it has not let in, which the exit sees to.
fn environment(datapath: &Datapath, config: Config, module: &str) -> String {
    let steps = datapath.steps().count();
    let is_exit = datapath.module(steps - 1).is_some_and(|last| last.name() == module);
    let (up, down, never) = match (config.control, module) {
        (Control::Credit, "raypath_credit") => {
            ("valid_o", "returned_i", "returned_i && environment_q == 0".to_string())
        }
        (Control::Credit, _) if is_exit => {
            let full = datapath.latency() + 1;
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

/// That no job ever leaves a module: what must be refuted, or else all that is proved of it says nothing.
pub fn vacuous(datapath: &Datapath, config: Config, texts: &Texts, module: &str) -> Problem {
    let leaves = if module == datapath.top().name() { "output_valid_o && output_ready_i" } else { "valid_o" };
    let never = format!("  always_ff @(posedge clk_i) never_leaves: assert (!({leaves}));\n");
    Problem {
        name: format!("{module}: never_leaves"),
        top: module.to_string(),
        text: texts.with(module, &format!("{never}{}{RESET}", environment(datapath, config, module))),
        assertions: 1,
        method: Method::Bounded(datapath.latency() + 4),
    }
}
