//! The versions of all external programs that are installed.

use crate::lint::ICARUS;
use crate::verilator::VERILATOR;
use crate::{Abc, OpenSta, SmtSolver, ToolError, Yosys, YosysKind};
use std::collections::BTreeMap;

/// The name and version of each program that checks a claim, by its kind. Programs that are not installed are left out.
pub fn versions() -> BTreeMap<&'static str, String> {
    let found: [(&str, Result<String, ToolError>); 8] = [
        ("abc", Abc::find().map(|abc| abc.version)),
        ("bitwuzla", SmtSolver::bitwuzla().map(|solver| solver.version)),
        ("iverilog", ICARUS.version()),
        ("opensta", OpenSta::find().map(|sta| sta.version)),
        ("pyosys", Yosys::find(Some(YosysKind::Python)).map(|yosys| yosys.version)),
        ("verilator", VERILATOR.version()),
        ("yosys", Yosys::find(None).map(|yosys| yosys.version)),
        ("z3", SmtSolver::z3().map(|solver| solver.version)),
    ];
    found.into_iter().filter_map(|(name, version)| Some((name, version.ok()?))).collect()
}
