//! The datapaths whose text is covered.

use crate::covering::{Space, presets_and_pairs};
use crate::datapaths::TestedDatapath;
use raypath_float::Format;
use raypath_ops::Culling;
use raypath_ops::operations::NAMES;
use raypath_rtl::{Config, Features, Lanes};
use raypath_verify::{Error, Level};

/// The datapaths of a level. Regression: a small one with features. Full: the presets, small ones with every pair of
/// values of the parameters, and each added operation.
///
/// # Errors
/// A number format that does not exist; a parameter without the values that are given here.
pub fn choices(level: Level) -> Result<Vec<TestedDatapath>, Error> {
    let small = Config::DEFAULT.lanes(Lanes::Two).format(Format::new(4, 5)?);
    let features =
        Features { tag: 3, barycentrics: true, facing: true, culling: Culling::None, range: true, ..Features::OFF };
    let mut choices = vec![small.features(features).into()];
    if level == Level::Regression {
        return Ok(choices);
    }
    // Bounds of 8 bits need as many in the significand, and exceptions need binary32.
    let permits = |config: Config| {
        !config.semantics.features.quantised_boxes || config.semantics.format != small.semantics.format
    };
    let space = Space::new(&permits)
        .with("lanes", &["2", "none", "4"])?
        .with("format", &["e4s5", "bf16", "fp32"])?
        .with("box-bits", &["13", "8"])?
        .with("tag", &["0", "3"])?;
    choices.extend(presets_and_pairs(&space).into_iter().map(TestedDatapath::from));
    let boxes = small.lanes(Lanes::None).format(Format::BINARY16);
    choices.extend(NAMES.iter().map(|name| TestedDatapath { added: vec![name.to_string()], ..boxes.into() }));
    Ok(choices)
}
