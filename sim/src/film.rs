//! Films: pictures shown one after the other, encoded as animated PNG.
//!
//! A film keeps only the rectangle of each picture that differs from the picture before. It is small, since the table
//! stands still.

use crate::error::SimError;
use crate::image::{Image, encoder, refused};

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
