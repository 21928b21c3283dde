//! Area and slowest path of dividers and square roots in binary32, as a table: the figures of
//! `docs/reference/division.md`. The argument is a cell library, by default Debian's.
//!
//! ```sh
//! cargo run --release -p raypath-ppa --example division_area -- sky130_fd_sc_hd__tt_025C_1v80.lib.gz
//! ```

use raypath_float::{DivSqrt, Format};
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library};
use raypath_tools::{OpenSta, Yosys};
use std::path::Path;
use std::sync::Arc;

const FORMAT: Format = Format::BINARY32;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    use DivSqrt::{Quotient, QuotientOrRoot, Reciprocal, Root};
    let library = std::env::args().nth(1).unwrap_or_else(|| DEFAULT_LIBRARY.to_string());
    let bench = Bench {
        library: Library::read(Path::new(&library))?,
        yosys: Yosys::find(None)?,
        sta: OpenSta::find()?,
        period: 12.0,
        unit_period: None,
        jobs: 2,
        cache: "build/ppa-cache".into(),
    };
    let iterative = [(Quotient, 1), (Quotient, 2), (Quotient, 3), (Reciprocal, 2), (Root, 2), (QuotientOrRoot, 2)];
    let pipelined =
        [(Quotient, 10), (Quotient, 14), (Quotient, 27), (Reciprocal, 14), (Root, 14), (QuotientOrRoot, 14)];
    println!("| unit | latency | interval | flip-flops | area | slowest path |\n|---|---|---|---|---|---|");
    for (function, digits) in iterative {
        let latency = DivSqrt::iterative_latency(FORMAT, digits);
        let name = format!("{function:?}, {digits} digits a cycle");
        print(&bench, &name, [latency, latency], &function.iterative(FORMAT, digits, 0)?)?;
    }
    for (function, latency) in pipelined {
        let name = format!("{function:?}, pipelined");
        print(&bench, &name, [latency, 1], &function.pipelined(FORMAT, latency, 0)?)?;
    }
    Ok(())
}

fn print(
    bench: &Bench,
    name: &str,
    [latency, interval]: [u32; 2],
    unit: &Arc<Module>,
) -> Result<(), Box<dyn std::error::Error>> {
    let reports = bench.measure(&[Design::new(name, &alone(unit)?)], |_| true)?;
    for report in reports {
        let (area, slowest) = (report.area.total, report.slowest.ns);
        println!("| {name} | {latency} | {interval} | {} | {area:.0} | {slowest:.1} |", report.flip_flops);
    }
    Ok(())
}

/// A top module with the unit as its only stage.
fn alone(unit: &Arc<Module>) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath");
    let input = |name: &str| m.input(name, unit.port_width(name).unwrap_or_default());
    let inputs: Vec<(&str, Wire<'_>)> =
        unit.inputs().iter().map(|port| (port.name.as_str(), input(&port.name))).collect();
    let outputs = m.instance("u_unit", unit, &inputs);
    unit.outputs().iter().zip(outputs).for_each(|(port, wire)| m.output(&port.name, wire));
    m.finish()
}
