//! The properties to prove of a datapath: of each step, of the entrance, and of the whole pipeline.

use super::lemmas;
use raypath_hdl::verilog::RAM;
use raypath_rtl::{Bind, Checker, Config, Control, DatapathNetlist, UnitLatency};
use raypath_tools::ToolError;
use raypath_verify::Error;
use raypath_verify::safety::{Method, ModuleTexts, RESET, SafetyProblem};

/// All properties to prove of a datapath.
///
/// # Errors
/// The text of the pipeline is not as it is printed.
pub fn problems(datapath: &DatapathNetlist, config: Config, texts: &ModuleTexts) -> Result<Vec<SafetyProblem>, Error> {
    let properties = datapath.properties();
    let mut modules: Vec<&str> = properties.binds().iter().map(|bind| bind.module.as_str()).collect();
    modules.dedup();
    let mut with_words = texts.clone();
    with_words.append(RAM, lemmas::WORDS);
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
        // A stalled output is stable whatever data enter the last step. With them the proof would take the whole path of
        // the data.
        let (stall, others): (Vec<&Bind>, Vec<&Bind>) =
            others.into_iter().partition(|bind| bind.checker == Checker::Stall);
        let environment = environment(datapath, config, module);
        // A longer pipeline is proved step by step.
        let order =
            if is_top && config.microarchitecture.unit_latency != UnitLatency::ONE { Vec::new() } else { order };
        let lemmas = || if is_top { lemmas::of_pipeline(datapath, config) } else { lemmas::of_exit(datapath) };
        if !stall.is_empty() {
            let problem = problem(texts, module, &stall, &environment, Method::Unbounded);
            problems.push(SafetyProblem {
                text: with_free_data(&problem.text, module, last.map(|last| last.name()))?,
                ..problem
            });
        }
        for (binds, method) in [(others, Method::Unbounded), (order, Method::Inductive)] {
            if !binds.is_empty() {
                let (texts, besides, more) = match method {
                    Method::Inductive => (&with_words, environment.clone() + &lemmas(), 1),
                    _ => (texts, environment.clone(), 0),
                };
                let problem = problem(texts, module, &binds, &besides, method);
                problems.push(SafetyProblem { assertions: problem.assertions + more, ..problem });
            }
        }
    }
    Ok(problems)
}

/// The text with any data before the last step: the words that the steps before it pass on are connected to nothing.
fn with_free_data(text: &str, top: &str, last: Option<&str>) -> Result<String, Error> {
    const WORD: &str = ".data_o (";
    let unexpected = |found: &str| ToolError::unexpected("raypath", found.to_string(), "the text of a pipeline");
    let begin = text.find(&format!("\nmodule {top} (")).ok_or_else(|| unexpected("no top module"))?;
    let (before, text) = text.split_at(begin);
    let (own, after) = text.split_once("\nendmodule").ok_or_else(|| unexpected("no end of the top module"))?;
    let last = last.unwrap_or_default();
    let steps = own.split_once(&format!("\n  {last} "));
    let (steps, rest) = steps.ok_or_else(|| unexpected("no last step"))?;
    let mut words = steps.split(WORD);
    let mut free = words.next().unwrap_or_default().to_string();
    for word in words {
        let (_, rest) = word.split_once(')').ok_or_else(|| unexpected(word))?;
        free += &format!("{WORD}){rest}");
    }
    Ok(format!("{before}{free}\n  {last} {rest}\nendmodule{after}"))
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
fn environment(datapath: &DatapathNetlist, config: Config, module: &str) -> String {
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
pub fn never_leaves(datapath: &DatapathNetlist, config: Config, texts: &ModuleTexts, module: &str) -> SafetyProblem {
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
