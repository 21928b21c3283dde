//! Parsers of numbers on the command line, whose errors state what was expected.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A parser, for clap, of whole numbers in a range.
pub fn whole<N>(range: RangeInclusive<N>) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static
where
    N: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| match text.parse() {
        Ok(number) if range.contains(&number) => Ok(number),
        _ => Err(format!("expected a whole number from {} to {}", range.start(), range.end())),
    }
}

/// A parser, for clap, of numbers in a range, which `expected` describes.
pub fn number(
    range: RangeInclusive<f64>,
    expected: impl Display,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    let expected = format!("expected {expected}");
    move |text| text.parse().ok().filter(|number| range.contains(number)).ok_or_else(|| expected.clone())
}
