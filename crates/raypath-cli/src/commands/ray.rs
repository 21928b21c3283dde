//! `raypath ray`: the values of the input ports for a ray, for use in a test bench.

use crate::error::CliError;
use clap::Args;
use raypath_ops::{Aabb, Job, PortKind, Ray, RayBoxInput};
use std::io::Write;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The origin: three numbers
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_names = ["X", "Y", "Z"], required = true, value_parser = finite)]
    origin: Vec<f32>,
    /// The direction, of any length except zero: three numbers
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_names = ["X", "Y", "Z"], required = true, value_parser = finite)]
    direction: Vec<f32>,
    /// The extent, in units of the direction's length
    #[arg(long, default_value_t = f32::INFINITY, allow_hyphen_values = true)]
    extent: f32,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let vector = |given: &[f32]| std::array::from_fn(|axis| given.get(axis).copied().unwrap_or(f32::NAN));
    let ray = Ray::new(vector(&arguments.origin), vector(&arguments.direction), arguments.extent)
        .map_err(CliError::unusable)?;
    let job: Job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([0.0; 3], [0.0; 3]); 4] });
    for port in job.ports().into_iter().filter(|port| port.name.starts_with("ray_")) {
        match port.kind {
            PortKind::Number => {
                let value = f32::from_bits(port.bits as u32);
                writeln!(out, "{:<16} {:08x}  {value:e}", port.name + "_i", port.bits)?;
            }
            PortKind::Flags | PortKind::Word => writeln!(out, "{:<16} {}", port.name + "_i", port.bits)?,
        }
    }
    Ok(())
}

fn finite(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number: &f32| number.is_finite());
    number.ok_or_else(|| format!("expected a number from {:e} to {:e}", f32::MIN, f32::MAX))
}
