//! Pictures, their PNG encoding, and heat maps.

use font8x8::UnicodeFonts;
use image::{ImageError, ImageFormat, Rgb, RgbImage};
use std::io::Cursor;

/// A picture: rows of sRGB pixels from the top.
pub type Picture = RgbImage;

/// The content of a PNG file with this picture.
///
/// # Errors
/// Errors of the encoder; none is expected.
pub fn to_png(picture: &Picture) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Draws the number of jobs of each pixel as a heat map, from black to pale yellow for the maximum, with a legend.
pub fn heatmap(width: u32, height: u32, jobs: &[u32]) -> Picture {
    let max = jobs.iter().copied().max().unwrap_or(0).max(1);
    let mut picture = Picture::from_pixel(width, height + LEGEND, Rgb([24; 3]));
    for (pixel, &jobs) in picture.pixels_mut().zip(jobs) {
        *pixel = colour(f64::from(jobs) / f64::from(max));
    }
    let label = max.to_string();
    let (left, right) = (MARGIN + 8 + MARGIN, width.saturating_sub(MARGIN + 8 * label.len() as u32 + MARGIN));
    for x in left..right {
        let colour = colour(f64::from(x - left) / f64::from(right - left));
        for y in 0..8 {
            set(&mut picture, x, height + MARGIN + y, colour);
        }
    }
    write(&mut picture, MARGIN, height + MARGIN, "0");
    write(&mut picture, right + MARGIN, height + MARGIN, &label);
    write(&mut picture, MARGIN, height + 2 * MARGIN + 8, "jobs per pixel");
    picture
}

const MARGIN: u32 = 6;
/// The height of the legend: two lines of text.
const LEGEND: u32 = 3 * MARGIN + 16;

/// The colour of a value from 0 to 1, from a perceptually uniform map.
fn colour(part: f64) -> Rgb<u8> {
    Rgb(colorous::INFERNO.eval_continuous(part).as_array())
}

/// Sets a pixel; coordinates outside are ignored.
fn set(picture: &mut Picture, x: u32, y: u32, colour: Rgb<u8>) {
    if let Some(pixel) = picture.get_pixel_mut_checked(x, y) {
        *pixel = colour;
    }
}

/// Writes text in an 8 × 8 pixel font.
fn write(picture: &mut Picture, x: u32, y: u32, text: &str) {
    for (column, letter) in (0..).zip(text.chars()) {
        let rows = font8x8::BASIC_FONTS.get(letter).unwrap_or_default();
        for (dy, row) in (0..).zip(rows) {
            for dx in (0..8).filter(|dx| row >> dx & 1 == 1) {
                set(picture, x + 8 * column + dx, y + dy, Rgb([230; 3]));
            }
        }
    }
}
