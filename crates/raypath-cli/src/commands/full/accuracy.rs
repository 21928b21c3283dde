//! `raypath accuracy`: the errors of number formats, compared with binary64.

use crate::accuracy::{Accuracy, DIMENSIONS, RAYS, SCALES, table};
use crate::{CliError, Progress, number, whole};
use clap::Args;
use raypath_float::Format;
use raypath_ops::Rules;
use std::io::Write;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The formats to measure: fp32, tf32, bf16, fp16, or eXsY for X exponent bits and Y significand bits
    #[arg(long, value_delimiter = ',', default_value = "fp32,tf32,bf16,fp16", value_name = "FORMAT,...")]
    format: Vec<Format>,
    /// Random jobs of each kind, at most a million
    #[arg(long, default_value_t = 20_000, value_name = "N", value_parser = whole(1..=1_000_000u32))]
    jobs: u32,
    /// Seed of the random jobs
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// The rules for edge cases: paper (this project's rulings) or chisel (the original hardware's)
    #[arg(long, default_value_t = Rules::Paper, value_name = "paper|chisel", value_parser = measured_rules)]
    rules: Rules,
    /// A factor on all coordinates, which are between -4 and 4 without it
    #[arg(long, default_value_t = 1.0, value_parser = number(SCALES, format!("a number from {:e} to {:e}", SCALES.start(), SCALES.end())))]
    scale: f64,
}

/// The rules `bounds` widen boxes on purpose, which is no error.
fn measured_rules(text: &str) -> Result<Rules, String> {
    match text.parse() {
        Ok(rules @ (Rules::Paper | Rules::Chisel)) => Ok(rules),
        _ => Err("expected paper or chisel".to_string()),
    }
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let Arguments { format: formats, jobs, seed, rules, scale } = arguments;
    let total = formats.len() * (*jobs as usize + RAYS);
    let mut progress = Progress::new("jobs and rays", total);
    let mut done = 0;
    let mut watch = || {
        done += 1;
        progress.at(done)
    };
    let (mut random, mut scene) = (Vec::new(), Vec::new());
    for format in formats {
        let accuracy = Accuracy { format: *format, rules: *rules, scale: *scale };
        random.extend(accuracy.random_jobs(*seed, *jobs, &mut watch));
        scene.extend(accuracy.scene(&mut watch));
    }
    progress.finish(done)?;

    writeln!(out, "Random jobs: {jobs} of each kind, seed {seed}; vectors of {DIMENSIONS} dimensions.\n")?;
    writeln!(out, "{}\n", table(&random))?;
    writeln!(out, "Scene: a torus in {RAYS} pixels.\n")?;
    writeln!(out, "{}\n", table(&scene))?;
    writeln!(
        out,
        "Rules {rules}, scale {scale}. Columns a compare with binary64 on the inputs rounded to the format,"
    )?;
    writeln!(out, "columns b with binary64 on the original inputs. differ: results that hit where the reference")?;
    writeln!(
        out,
        "misses or miss where it hits, and their share of the hits. 50 %, 99 %, max: bounds of that share of"
    )?;
    writeln!(out, "the errors, in ulps of the format. no number: results that are infinite or NaN.")?;
    Ok(())
}
