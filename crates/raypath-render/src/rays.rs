//! Rays and hits as text, to hold this tracer against another.
//!
//! A file of rays has a ray a line: `ox oy oz dx dy dz extent`, decimal numbers with spaces between them. The extent may be
//! `inf`. What follows a `#` is a comment; empty lines do not count. Rays are numbered from 0.
//!
//! A file of hits has a line for each ray: `triangle t t_num t_denom t_bits t_num_bits t_denom_bits`, or `miss`. The triangle
//! is its index in the mesh, from 0, with `b` behind it if it is hit from behind. Numbers are the shortest decimals that
//! are read back as the same binary32; the bits are 8 hexadecimal digits. t is t_num / t_denom, rounded once, in units of
//! the direction's length. Of several triangles at the closest t the one with the lowest index is given.

use crate::trace::Hit;
use raypath_ops::{Binary32, Ray, RayError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

const FIELDS: [&str; 7] = ["ox", "oy", "oz", "dx", "dy", "dz", "extent"];

/// Why a file is not one of rays. Messages begin with file and line.
#[derive(Debug, Error)]
pub enum RaysError {
    /// The operating system refused, or it is not text.
    #[error("{}: cannot read: {problem}", .path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What it said.
        problem: io::Error,
    },
    /// A line has too few or too many numbers.
    #[error("{}:{line}: {found} numbers, expected 7: {}", .path.display(), FIELDS.join(" "))]
    Fields {
        /// Which file.
        path: PathBuf,
        /// Which line; the first is 1.
        line: usize,
        /// How many numbers it has.
        found: usize,
    },
    /// Something is not a number.
    #[error("{}:{line}: {field} = '{value}', expected a decimal number", .path.display())]
    Number {
        /// Which file.
        path: PathBuf,
        /// Which line; the first is 1.
        line: usize,
        /// Which of the seven.
        field: &'static str,
        /// What stands there.
        value: String,
    },
    /// The numbers are not a ray.
    #[error("{}:{line}: {problem}", .path.display())]
    Ray {
        /// Which file.
        path: PathBuf,
        /// Which line; the first is 1.
        line: usize,
        /// Why not.
        problem: RayError,
    },
}

/// Reads a file of rays.
///
/// # Errors
/// A file that cannot be read, or a line that is not a ray.
pub fn read_rays(path: &Path) -> Result<Vec<Ray<Binary32>>, RaysError> {
    let text = std::fs::read_to_string(path).map_err(|problem| RaysError::File { path: path.to_owned(), problem })?;
    parse_rays(&text, path)
}

/// Reads rays from text; `path` is for messages.
///
/// # Errors
/// A line that is not a ray.
pub fn parse_rays(text: &str, path: &Path) -> Result<Vec<Ray<Binary32>>, RaysError> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.split('#').next().unwrap_or("")));
    let rays = lines.filter(|(_, line)| !line.trim().is_empty());
    rays.map(|(line, text)| parse_ray(text, line, path)).collect()
}

fn parse_ray(text: &str, line: usize, path: &Path) -> Result<Ray<Binary32>, RaysError> {
    let path = || path.to_owned();
    let found = text.split_whitespace().count();
    if found != FIELDS.len() {
        return Err(RaysError::Fields { path: path(), line, found });
    }
    let mut numbers = [0.0; 7];
    for ((number, field), value) in numbers.iter_mut().zip(FIELDS).zip(text.split_whitespace()) {
        let wrong = |_| RaysError::Number { path: path(), line, field, value: value.to_string() };
        *number = value.parse().map_err(wrong)?;
    }
    let [ox, oy, oz, dx, dy, dz, extent] = numbers;
    Ray::new([ox, oy, oz], [dx, dy, dz], extent).map_err(|problem| RaysError::Ray { path: path(), line, problem })
}

/// Writes a line for each ray, after two that say what they mean.
///
/// # Errors
/// What the writer says.
pub fn write_hits(mut writer: impl Write, hits: &[Option<Hit>]) -> io::Result<()> {
    writeln!(
        writer,
        "# a line a ray: triangle (b: from behind), t, t_num, t_denom, and the bits of the three; or miss"
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
