//! The units' SystemVerilog in the linters.

use raypath_float::{DivSqrt, Format};
use raypath_tools::Sources;
use raypath_verify_arithmetic::units::bench::Units;

#[test]
fn linters_are_silent() -> Result<(), Box<dyn std::error::Error>> {
    for (e, s) in [(8, 24), (3, 4), (5, 11), (8, 8), (3, 3), (11, 24)] {
        let folder = tempfile::tempdir()?;
        let format = Format::new(e, s)?;
        Sources::write(&Units::new(format)?.bench()?, folder.path())?.lint()?;
        for module in
            [DivSqrt::QuotientOrRoot.pipelined(format, 3, 5)?, DivSqrt::Reciprocal.iterative(format, s + 2, 1)?]
        {
            Sources::write(&module, tempfile::tempdir()?.path())?.lint()?;
        }
    }
    Ok(())
}
