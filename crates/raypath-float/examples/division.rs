//! Prints a unit for quotients, reciprocals or square roots as SystemVerilog:
//!
//! ```sh
//! cargo run --release -p raypath-float --example division -- div iterative fp32 2
//! ```

use raypath_float::{DivSqrt, Format};
use std::error::Error;

const USAGE: &str = "usage: division div|rcp|sqrt|div_sqrt iterative|pipelined|parts FORMAT COUNT\n\
                     COUNT: digits a cycle, latency in cycles, or parts without registers";

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [function, kind, format, count] = words.as_slice() else { return Err(USAGE.into()) };
    let function = match function.as_str() {
        "div" => DivSqrt::Quotient,
        "rcp" => DivSqrt::Reciprocal,
        "sqrt" => DivSqrt::Root,
        "div_sqrt" => DivSqrt::QuotientOrRoot,
        _ => return Err(USAGE.into()),
    };
    let (format, count): (Format, u32) = (format.parse()?, count.parse()?);
    let modules = match kind.as_str() {
        "iterative" => vec![function.iterative(format, count, 0)?],
        "pipelined" => vec![function.pipelined(format, count, 0)?],
        "parts" => function.parts(format, count)?,
        _ => return Err(USAGE.into()),
    };
    for module in modules {
        print!("{}", raypath_hdl::verilog::text(&module)?);
    }
    Ok(())
}
