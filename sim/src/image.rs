//! Pictures: rows of pixels, written as PNG, set side by side, or shown one after the other.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::error::SimError;

/// A picture: 8 bits each of red, green and blue, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `3 × width × height` bytes.
    pub rgb: Vec<u8>,
}

/// Colour of the gap between pictures of a strip, and of what is left over.
const PAPER: [u8; 3] = [255, 255, 255];
/// Pixels between the pictures of a strip.
const GAP: u32 = 4;

impl Image {
    /// A picture of one colour.
    pub fn plain(width: u32, height: u32, color: [u8; 3]) -> Image {
        Image { width, height, rgb: color.repeat(width as usize * height as usize) }
    }

    /// The colour at column `x` from the left and row `y` from the top; nothing outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        let at = self.offset(x, y);
        (x < self.width && y < self.height).then(|| [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]])
    }

    /// Sets the colour of a pixel inside the picture.
    pub(crate) fn set(&mut self, x: u32, y: u32, color: [u8; 3]) {
        let at = self.offset(x, y);
        self.rgb[at..at + 3].copy_from_slice(&color);
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        3 * (y as usize * self.width as usize + x as usize)
    }

    /// A strip: the pictures side by side from left to right, aligned at their tops. No pictures give an empty one.
    pub fn beside(images: &[Image]) -> Image {
        let gaps = GAP * (images.len().saturating_sub(1)) as u32;
        let width = images.iter().map(|image| image.width).sum::<u32>() + gaps;
        let height = images.iter().map(|image| image.height).max().unwrap_or(0);
        let mut strip = Image::plain(width, height, PAPER);
        let mut left = 0;
        for image in images {
            for row in 0..image.height {
                let (from, to, length) = (image.offset(0, row), strip.offset(left, row), 3 * image.width as usize);
                strip.rgb[to..to + length].copy_from_slice(&image.rgb[from..from + length]);
            }
            left += image.width + GAP;
        }
        strip
    }

    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// The file cannot be written, or the picture is empty.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), SimError> {
        write(path.as_ref(), std::slice::from_ref(self), None)
    }
}

/// Writes the pictures as an animated PNG that runs for ever, each shown for `delay_ms` milliseconds.
///
/// # Errors
/// The file cannot be written, there are no pictures, or they differ in size.
pub fn write_apng(path: impl AsRef<Path>, frames: &[Image], delay_ms: u16) -> Result<(), SimError> {
    write(path.as_ref(), frames, Some(delay_ms))
}

fn write(path: &Path, frames: &[Image], delay_ms: Option<u16>) -> Result<(), SimError> {
    let fail = |reason: String| SimError::Picture { path: path.display().to_string(), reason };
    let Some(first) = frames.first() else {
        return Err(fail("there is no picture to write".to_owned()));
    };
    if frames.iter().any(|frame| (frame.width, frame.height) != (first.width, first.height)) {
        return Err(fail("the pictures differ in size".to_owned()));
    }
    let file = BufWriter::new(File::create(path).map_err(|error| fail(error.to_string()))?);
    let encode = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(file, first.width, first.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        if let Some(delay) = delay_ms {
            encoder.set_animated(frames.len() as u32, 0)?;
            encoder.set_frame_delay(delay, 1000)?;
        }
        let mut writer = encoder.write_header()?;
        for frame in frames {
            writer.write_image_data(&frame.rgb)?;
        }
        writer.finish()
    };
    encode().map_err(|error| fail(error.to_string()))
}
