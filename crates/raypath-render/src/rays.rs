//! Rays and hits as text files, for comparison with other tracers.
//!
//! A file of rays has one ray per line: `ox oy oz dx dy dz extent`, decimal numbers separated by spaces. The extent may
//! be `inf`. `#` starts a comment; empty lines are ignored. Rays are numbered from 0.
//!
//! A file of hits has one line per ray: `triangle t t_num t_denom t_bits t_num_bits t_denom_bits`, or `miss`.
//! `triangle` is the index in the mesh, from 0, followed by `b` for a hit from behind, and by `@` and the number of the
//! instance in scenes with instances. Numbers are the shortest decimals that denote the same binary32; bits are 8
//! hexadecimal digits. t is t_num / t_denom, rounded to binary32, in units of the direction's length. Of several
//! triangles at the closest t, the file has the one with the lowest index.

use crate::read::{parse_lines, text};
use crate::{Hit, ReadError};
use raypath_ops::{Binary32, Ray};
use raypath_tools::MemoryLimit;
use std::io::{self, Write};
use std::path::Path;

const FIELDS: [&str; 7] = ["ox", "oy", "oz", "dx", "dy", "dz", "extent"];

/// Reads a file of rays.
///
/// # Errors
/// A file that cannot be read, or a line that is not a valid ray; lines that take more memory than `limit`, 256 bytes
/// each.
pub fn read_rays(path: &Path, limit: MemoryLimit) -> Result<Vec<Ray<Binary32>>, ReadError> {
    parse_rays(&text(path, limit, 256)?, path)
}

/// Reads rays from text. `path` appears in messages.
///
/// # Errors
/// A line that is not a valid ray.
pub fn parse_rays(text: &str, path: &Path) -> Result<Vec<Ray<Binary32>>, ReadError> {
    parse_lines(text, path, parse_ray)
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

/// Writes a file of rays. Reading it returns the same rays, bit for bit.
///
/// # Errors
/// Errors of the writer.
pub fn write_rays(mut writer: impl Write, rays: &[Ray<Binary32>]) -> io::Result<()> {
    writeln!(writer, "# {}", FIELDS.join(" "))?;
    for ray in rays {
        let (origin, direction): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        // In binary64 too, each decimal denotes the number itself.
        let numbers = origin.into_iter().chain(direction).chain([ray.extent.into()]).map(f64::from);
        let words: Vec<String> = numbers.map(|number| number.to_string()).collect();
        writeln!(writer, "{}", words.join(" "))?;
    }
    writer.flush()
}

/// Reads a file of hits. Only the bits of the numbers are read, not the decimals.
///
/// # Errors
/// A file that cannot be read, or a line that is not a hit; lines that take more memory than `limit`, 64 bytes each.
pub fn read_hits(path: &Path, limit: MemoryLimit) -> Result<Vec<Option<Hit>>, ReadError> {
    parse_hits(&text(path, limit, 64)?, path)
}

/// Reads hits from text, as [`read_hits`] does. `path` appears in messages.
///
/// # Errors
/// A line that is not a hit.
pub fn parse_hits(text: &str, path: &Path) -> Result<Vec<Option<Hit>>, ReadError> {
    parse_lines(text, path, parse_hit)
}

fn parse_hit(text: &str) -> Result<Option<Hit>, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words == ["miss"] {
        return Ok(None);
    }
    let [triangle, _, _, _, bits @ ..] = words.as_slice() else {
        return Err(format!("{} words, expected 7 or miss", words.len()));
    };
    let &[t, t_num, t_denom] = bits else { return Err(format!("{} words, expected 7 or miss", words.len())) };
    let wrong =
        || format!("triangle '{triangle}', expected a whole number, with a b if from behind, and @ and an instance");
    let (front, instance) = match triangle.split_once('@') {
        Some((front, instance)) => (front, Some(instance.parse().map_err(|_| wrong())?)),
        None => (*triangle, None),
    };
    let number = front.strip_suffix('b');
    let from_behind = number.is_some();
    let index = number.unwrap_or(front).parse().map_err(|_| wrong())?;
    let number = |word: &str| match u32::from_str_radix(word, 16) {
        Ok(bits) if word.len() == 8 => Ok(f32::from_bits(bits)),
        _ => Err(format!("bits '{word}', expected 8 hexadecimal digits")),
    };
    let (t, t_num, t_denom) = (number(t)?, number(t_num)?, number(t_denom)?);
    Ok(Some(Hit { triangle: index, from_behind, t_num, t_denom, t, instance }))
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
            Some(Hit { triangle, from_behind, t_num, t_denom, t, instance }) => {
                let side = if *from_behind { "b" } else { "" };
                let instance = instance.map_or(String::new(), |instance| format!("@{instance}"));
                let [t_bits, num_bits, denom_bits] = [t, t_num, t_denom].map(|x| x.to_bits());
                writeln!(
                    writer,
                    "{triangle}{side}{instance} {t:e} {t_num:e} {t_denom:e} {t_bits:08x} {num_bits:08x} \
                     {denom_bits:08x}"
                )?;
            }
        }
    }
    writer.flush()
}
