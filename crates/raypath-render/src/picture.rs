//! Pictures in memory, and as PNG.

use font8x8::UnicodeFonts;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

/// Pixels, row by row from the top, red, green and blue in sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of one colour.
    pub(crate) fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width as usize * height as usize] }
    }

    pub(crate) fn of(width: u32, height: u32, pixels: Vec<[u8; 3]>) -> Self {
        Self { width, height, pixels }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Its pixels.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The content of a PNG file.
    ///
    /// # Errors
    /// What the encoder says; none is known.
    pub fn to_png(&self) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        let pixels = self.pixels.as_flattened();
        PngEncoder::new(&mut bytes).write_image(pixels, self.width, self.height, ExtendedColorType::Rgb8)?;
        Ok(bytes)
    }
}

/// How many jobs each pixel took, as a picture: black is none, through red to yellow, the palest is the most. Below it
/// stands a legend with the numbers at its ends.
pub fn heatmap(width: u32, height: u32, jobs: &[u32]) -> Picture {
    let most = jobs.iter().copied().max().unwrap_or(0).max(1);
    let mut picture = Picture::filled(width, height + LEGEND, [24, 24, 24]);
    for (pixel, &jobs) in picture.pixels.iter_mut().zip(jobs) {
        *pixel = colour(f64::from(jobs) / f64::from(most));
    }
    let label = most.to_string();
    let (left, right) = (MARGIN + 8 + MARGIN, width.saturating_sub(MARGIN + 8 * label.len() as u32 + MARGIN));
    for x in left..right {
        let colour = colour(f64::from(x - left) / f64::from(right - left));
        for y in 0..8 {
            picture.set(x, height + MARGIN + y, colour);
        }
    }
    picture.write(MARGIN, height + MARGIN, "0");
    picture.write(right + MARGIN, height + MARGIN, &label);
    picture.write(MARGIN, height + 2 * MARGIN + 8, "jobs a pixel");
    picture
}

const MARGIN: u32 = 6;
/// Two lines of letters.
const LEGEND: u32 = 3 * MARGIN + 16;

/// Equal steps look equally far apart.
fn colour(part: f64) -> [u8; 3] {
    colorous::INFERNO.eval_continuous(part).as_array()
}

impl Picture {
    /// Sets a pixel, if it is inside.
    fn set(&mut self, x: u32, y: u32, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y as usize * self.width as usize + x as usize] = colour;
        }
    }

    /// Writes in letters of 8 × 8 pixels.
    fn write(&mut self, x: u32, y: u32, text: &str) {
        for (place, letter) in (0..).zip(text.chars()) {
            let rows = font8x8::BASIC_FONTS.get(letter).unwrap_or_default();
            for (dy, row) in (0..).zip(rows) {
                for dx in (0..8).filter(|dx| row >> dx & 1 == 1) {
                    self.set(x + 8 * place + dx, y + dy, [230, 230, 230]);
                }
            }
        }
    }
}
