//! Pictures, their PNG encoding, and heat maps.

use font8x8::UnicodeFonts;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

/// A picture: rows of sRGB pixels from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of uniform colour.
    pub(crate) fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width as usize * height as usize] }
    }

    pub(crate) fn new(width: u32, height: u32, pixels: Vec<[u8; 3]>) -> Self {
        Self { width, height, pixels }
    }

    /// The width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixels, row by row, as red, green and blue.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The content of a PNG file with this picture.
    ///
    /// # Errors
    /// Errors of the encoder; none is expected.
    pub fn to_png(&self) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        let pixels = self.pixels.as_flattened();
        PngEncoder::new(&mut bytes).write_image(pixels, self.width, self.height, ExtendedColorType::Rgb8)?;
        Ok(bytes)
    }
}

/// Draws the number of jobs of each pixel as a heat map, from black for none to pale yellow for the maximum, with a
/// legend below.
pub fn heatmap(width: u32, height: u32, jobs: &[u32]) -> Picture {
    let max = jobs.iter().copied().max().unwrap_or(0).max(1);
    let mut picture = Picture::filled(width, height + LEGEND, [24, 24, 24]);
    for (pixel, &jobs) in picture.pixels.iter_mut().zip(jobs) {
        *pixel = colour(f64::from(jobs) / f64::from(max));
    }
    let label = max.to_string();
    let (left, right) = (MARGIN + 8 + MARGIN, width.saturating_sub(MARGIN + 8 * label.len() as u32 + MARGIN));
    for x in left..right {
        let colour = colour(f64::from(x - left) / f64::from(right - left));
        for y in 0..8 {
            picture.set(x, height + MARGIN + y, colour);
        }
    }
    picture.write(MARGIN, height + MARGIN, "0");
    picture.write(right + MARGIN, height + MARGIN, &label);
    picture.write(MARGIN, height + 2 * MARGIN + 8, "jobs per pixel");
    picture
}

const MARGIN: u32 = 6;
/// The height of the legend: two lines of text.
const LEGEND: u32 = 3 * MARGIN + 16;

/// The colour of a value from 0 to 1, from a perceptually uniform map.
fn colour(part: f64) -> [u8; 3] {
    colorous::INFERNO.eval_continuous(part).as_array()
}

impl Picture {
    /// Sets a pixel; coordinates outside are ignored.
    fn set(&mut self, x: u32, y: u32, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y as usize * self.width as usize + x as usize] = colour;
        }
    }

    /// Writes text in an 8 × 8 pixel font.
    fn write(&mut self, x: u32, y: u32, text: &str) {
        for (column, letter) in (0..).zip(text.chars()) {
            let rows = font8x8::BASIC_FONTS.get(letter).unwrap_or_default();
            for (dy, row) in (0..).zip(rows) {
                for dx in (0..8).filter(|dx| row >> dx & 1 == 1) {
                    self.set(x + 8 * column + dx, y + dy, [230, 230, 230]);
                }
            }
        }
    }
}
