//! Pictures: rows of pixels, set side by side or one below the other. They are encoded as PNG.

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

    /// Colours a rectangle, as far as it lies in the picture.
    pub fn fill(&mut self, [left, top]: [u32; 2], [width, height]: [u32; 2], color: [u8; 3]) {
        for y in top..top.saturating_add(height).min(self.height) {
            for x in left..left.saturating_add(width).min(self.width) {
                self.set(x, y, color);
            }
        }
    }

    /// Copies a picture into this one, its upper left corner at `left` and `top`.
    ///
    /// # Panics
    /// There is no room for it there.
    pub fn paste(&mut self, image: &Image, [left, top]: [u32; 2]) {
        for row in 0..image.height {
            let (from, to, length) = (image.offset(0, row), self.offset(left, top + row), 3 * image.width as usize);
            self.rgb[to..to + length].copy_from_slice(&image.rgb[from..from + length]);
        }
    }

    /// The part of this picture inside a rectangle, which must lie in it.
    pub(crate) fn cut(&self, left: u32, top: u32, width: u32, height: u32) -> Image {
        let row = |y| &self.rgb[self.offset(left, y)..self.offset(left, y) + 3 * width as usize];
        Image { width, height, rgb: (top..top + height).flat_map(row).copied().collect() }
    }

    /// A strip: the pictures side by side from left to right, aligned at their tops. No pictures give an empty one.
    pub fn beside(images: &[Image]) -> Image {
        let width = images.iter().map(|image| image.width).sum::<u32>() + gaps(images);
        let height = images.iter().map(|image| image.height).max().unwrap_or(0);
        let mut strip = Image::plain(width, height, PAPER);
        let mut left = 0;
        for image in images {
            strip.paste(image, [left, 0]);
            left += image.width + GAP;
        }
        strip
    }

    /// The pictures one below the other from the top, aligned at their left. No pictures give an empty one.
    pub fn below(images: &[Image]) -> Image {
        let width = images.iter().map(|image| image.width).max().unwrap_or(0);
        let height = images.iter().map(|image| image.height).sum::<u32>() + gaps(images);
        let mut column = Image::plain(width, height, PAPER);
        let mut top = 0;
        for image in images {
            column.paste(image, [0, top]);
            top += image.height + GAP;
        }
        column
    }

    /// The bytes of the picture as PNG.
    ///
    /// # Errors
    /// The picture is empty.
    pub fn png(&self) -> Result<Vec<u8>, SimError> {
        let mut bytes = Vec::new();
        let mut encode = || -> Result<(), png::EncodingError> {
            let mut writer = encoder(&mut bytes, self.width, self.height).write_header()?;
            writer.write_image_data(&self.rgb)?;
            writer.finish()
        };
        encode().map_err(refused)?;
        Ok(bytes)
    }
}

/// Pixels between so many pictures.
fn gaps(images: &[Image]) -> u32 {
    GAP * images.len().saturating_sub(1) as u32
}

/// How all our PNG are encoded.
pub(crate) fn encoder(bytes: &mut Vec<u8>, width: u32, height: u32) -> png::Encoder<'static, &mut Vec<u8>> {
    let mut encoder = png::Encoder::new(bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder
}

/// The encoder's error in our words.
pub(crate) fn refused(error: png::EncodingError) -> SimError {
    SimError::Picture { reason: error.to_string() }
}
