//! Pictures: rows of pixels, set side by side or one below the other. Films: pictures shown one after the other.
//!
//! They are encoded as PNG. A film keeps only the rectangle of each picture that differs from the picture before. It is
//! small, since the table stands still.

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

    /// Copies a picture into this one, which must have room for it there.
    fn paste(&mut self, image: &Image, left: u32, top: u32) {
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
            strip.paste(image, left, 0);
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
            column.paste(image, 0, top);
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

/// Pictures of one size, shown one after the other for ever.
#[derive(Debug, Clone)]
pub struct Film {
    rate: u16,
    last: Option<Image>,
    shots: Vec<Shot>,
}

/// What changes at one moment, and for how long nothing else does.
#[derive(Debug, Clone)]
struct Shot {
    left: u32,
    top: u32,
    patch: Image,
    /// Pictures that look like this, one after the other.
    times: u16,
}

impl Film {
    /// A film without pictures, to be shown at so many pictures a second (0 counts as 1).
    pub fn new(rate: u16) -> Film {
        Film { rate: rate.max(1), last: None, shots: Vec::new() }
    }

    /// Appends a picture.
    ///
    /// # Errors
    /// It differs in size from those before.
    pub fn push(&mut self, image: Image) -> Result<(), SimError> {
        if let Some(last) = &self.last {
            if (last.width, last.height) != (image.width, image.height) {
                return Err(SimError::Picture { reason: "the pictures of the film differ in size".to_owned() });
            }
            match (changed(last, &image), self.shots.last_mut()) {
                (None, Some(shot)) if shot.times < u16::MAX => shot.times += 1,
                (None, _) => self.shots.push(Shot { left: 0, top: 0, patch: image.cut(0, 0, 1, 1), times: 1 }),
                (Some([left, top, width, height]), _) => {
                    self.shots.push(Shot { left, top, patch: image.cut(left, top, width, height), times: 1 });
                }
            }
        } else {
            self.shots.push(Shot { left: 0, top: 0, patch: image.clone(), times: 1 });
        }
        self.last = Some(image);
        Ok(())
    }

    /// Shows the last picture for as long as so many more would take.
    pub fn rest(&mut self, times: u16) {
        if let Some(shot) = self.shots.last_mut() {
            shot.times = shot.times.saturating_add(times);
        }
    }

    /// Frames of the animation: successive pictures that are alike are one.
    pub fn frames(&self) -> usize {
        self.shots.len()
    }

    /// The bytes of the film as animated PNG.
    ///
    /// # Errors
    /// There is no picture, or they are empty.
    pub fn png(&self) -> Result<Vec<u8>, SimError> {
        let Some(first) = self.shots.first() else {
            return Err(SimError::Picture { reason: "the film has no picture".to_owned() });
        };
        let mut bytes = Vec::new();
        let mut encode = || -> Result<(), png::EncodingError> {
            let mut encoder = encoder(&mut bytes, first.patch.width, first.patch.height);
            encoder.set_animated(self.shots.len() as u32, 0)?;
            encoder.set_frame_delay(first.times, self.rate)?;
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&first.patch.rgb)?;
            for Shot { left, top, patch, times } in &self.shots[1..] {
                writer.reset_frame_position()?;
                writer.set_frame_dimension(patch.width, patch.height)?;
                writer.set_frame_position(*left, *top)?;
                writer.set_frame_delay(*times, self.rate)?;
                writer.write_image_data(&patch.rgb)?;
            }
            writer.finish()
        };
        encode().map_err(refused)?;
        Ok(bytes)
    }
}

/// Left, top, width and height of the smallest rectangle that holds all pixels that differ, if any do.
fn changed(before: &Image, after: &Image) -> Option<[u32; 4]> {
    let row_bytes = 3 * after.width as usize;
    let rows = || before.rgb.chunks(row_bytes).zip(after.rgb.chunks(row_bytes)).enumerate();
    let top = rows().find(|(_, (old, new))| old != new)?.0;
    let (mut bottom, mut left, mut right) = (top, row_bytes, 0);
    for (row, (old, new)) in rows().skip(top).filter(|(_, (old, new))| old != new) {
        let differs = |byte: &usize| old[*byte] != new[*byte];
        bottom = row;
        left = left.min((0..row_bytes).find(differs).unwrap_or(left));
        right = right.max((0..row_bytes).rev().find(differs).unwrap_or(right));
    }
    let (left, right) = (left / 3, right / 3);
    Some([left, top, right - left + 1, bottom - top + 1].map(|pixels| pixels as u32))
}
