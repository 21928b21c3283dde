//! Rays and hits as text files, for comparison with other tracers.
//!
//! A file of rays has one ray per line: `ox oy oz dx dy dz extent`, decimal numbers separated by spaces. The extent may
//! be `inf`. `#` starts a comment; empty lines are ignored. Rays are numbered from 0.
//!
//! A file of hits has one line per ray: `triangle t t_num t_denom t_bits t_num_bits t_denom_bits`, or `miss`.
//! `triangle` is the index in the mesh, from 0, followed by `b` for a hit from behind. Numbers are the shortest
//! decimals that denote the same binary32; bits are 8 hexadecimal digits. t is t_num / t_denom, rounded to binary32, in
//! units of the direction's length. Of several triangles at the closest t, the file has the one with the lowest index.

use crate::{Hit, ReadError};
use raypath_ops::{Binary32, Ray};
use std::io::{self, Write};
use std::path::Path;

const FIELDS: [&str; 7] = ["ox", "oy", "oz", "dx", "dy", "dz", "extent"];

/// Reads a file of rays.
///
/// # Errors
/// A file that cannot be read, or a line that is not a valid ray.
pub fn read_rays(path: &Path) -> Result<Vec<Ray<Binary32>>, ReadError> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|problem| ReadError::new(path, format!("cannot read: {problem}")))?;
    parse_rays(&text, path)
}

/// Reads rays from text. `path` appears in messages.
///
/// # Errors
/// A line that is not a valid ray.
pub fn parse_rays(text: &str, path: &Path) -> Result<Vec<Ray<Binary32>>, ReadError> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.split('#').next().unwrap_or("")));
    let rays = lines.filter(|(_, line)| !line.trim().is_empty());
    let ray = |(line, text)| {
        parse_ray(text).map_err(|problem| ReadError { line: Some(line), ..ReadError::new(path, problem) })
    };
    rays.map(ray).collect()
}

fn parse_ray(text: &str) -> Result<Ray<Binary32>, String> {
    let found = text.split_whitespace().count();
    if found != FIELDS.len() {
        return Err(format!("{found} numbers, expected 7: {}", FIELDS.join(" ")));
    }
    let mut numbers = [0.0; 7];
    for ((number, field), value) in numbers.iter_mut().zip(FIELDS).zip(text.split_whitespace()) {
        *number = value.parse().map_err(|_| format!("{field} = '{value}', expected a decimal number"))?;
    }
    let [ox, oy, oz, dx, dy, dz, extent] = numbers;
    Ray::new([ox, oy, oz], [dx, dy, dz], extent).map_err(|problem| problem.to_string())
}

/// Writes a line for each ray, after two lines of comment that describe the fields.
///
/// # Errors
/// Errors of the writer.
pub fn write_hits(mut writer: impl Write, hits: &[Option<Hit>]) -> io::Result<()> {
    writeln!(
        writer,
        "# one line per ray: triangle (b: from behind), t, t_num, t_denom, and the bits of the three; or miss"
    )?;
    writeln!(writer, "# t = t_num / t_denom in binary32, in units of the direction's length")?;
    for hit in hits {
        match hit {
            None => writeln!(writer, "miss")?,
            Some(Hit { triangle, from_behind, t_num, t_denom, t }) => {
                let side = if *from_behind { "b" } else { "" };
                let [t_bits, num_bits, denom_bits] = [t, t_num, t_denom].map(|x| x.to_bits());
                writeln!(
                    writer,
                    "{triangle}{side} {t:e} {t_num:e} {t_denom:e} {t_bits:08x} {num_bits:08x} {denom_bits:08x}"
                )?;
            }
        }
    }
    writer.flush()
}
