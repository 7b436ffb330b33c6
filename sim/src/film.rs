//! Films: pictures of one size, shown one after the other for ever, as animated PNG or as GIF.
//!
//! A film keeps only the rectangle of each picture that differs from the picture before. It is small, since the table
//! stands still.

mod palette;

use gif::{DisposalMethod, Frame, Repeat};
use png::BlendOp;

use crate::error::SimError;
use crate::film::palette::{Palette, UNCHANGED};
use crate::image::{Image, encoder, refused};

/// The units of a GIF's delays in a second.
const GIF_TICKS: u64 = 100;

/// Pictures of one size, shown one after the other for ever.
#[derive(Debug, Clone)]
pub struct Film {
    /// How long a picture is shown: seconds, as a fraction.
    lasts: [u16; 2],
    last: Option<Image>,
    shots: Vec<Shot>,
}

/// What changes at one moment, and for how long nothing else does.
#[derive(Debug, Clone)]
struct Shot {
    left: u32,
    top: u32,
    patch: Image,
    /// Which pixels of the patch differ from what was there before.
    changed: Vec<bool>,
    /// Pictures that look like this, one after the other.
    times: u16,
}

impl Film {
    /// A film without pictures. Each will be shown for this fraction of a second (0 counts as 1, above and below).
    pub fn new(lasts: [u16; 2]) -> Film {
        Film { lasts: lasts.map(|number| number.max(1)), last: None, shots: Vec::new() }
    }

    /// How often a picture can be repeated in one frame of the animation.
    fn most_times(&self) -> u16 {
        u16::MAX / self.lasts[0]
    }

    /// Appends a picture.
    ///
    /// # Errors
    /// It differs in size from those before.
    pub fn push(&mut self, image: Image) -> Result<(), SimError> {
        let most = self.most_times();
        if let Some(last) = &self.last {
            if (last.width, last.height) != (image.width, image.height) {
                return Err(SimError::Picture { reason: "the pictures of the film differ in size".to_owned() });
            }
            match (changed(last, &image), self.shots.last_mut()) {
                (None, Some(shot)) if shot.times < most => shot.times += 1,
                (None, _) => self.shots.push(Shot::of(&image, [0, 0, 1, 1], Some(last))),
                (Some(rectangle), _) => self.shots.push(Shot::of(&image, rectangle, Some(last))),
            }
        } else {
            self.shots.push(Shot::of(&image, [0, 0, image.width, image.height], None));
        }
        self.last = Some(image);
        Ok(())
    }

    /// Shows the last picture for as long as so many more would take.
    pub fn rest(&mut self, times: u16) {
        let most = self.most_times();
        if let Some(shot) = self.shots.last_mut() {
            shot.times = shot.times.saturating_add(times).min(most);
        }
    }

    /// Pictures in so many seconds, rounded.
    pub fn pictures_in(&self, seconds: u16) -> u16 {
        let [above, below] = self.lasts.map(u32::from);
        let pictures = (u32::from(seconds) * below + above / 2) / above;
        u16::try_from(pictures).unwrap_or(u16::MAX)
    }

    /// Frames of the animation: successive pictures that are alike are one.
    pub fn frames(&self) -> usize {
        self.shots.len()
    }

    /// How long the film takes, seconds.
    pub fn seconds(&self) -> f64 {
        let times: u64 = self.shots.iter().map(|shot| u64::from(shot.times)).sum();
        times as f64 * f64::from(self.lasts[0]) / f64::from(self.lasts[1])
    }

    fn first(&self) -> Result<&Shot, SimError> {
        self.shots.first().ok_or_else(|| SimError::Picture { reason: "the film has no picture".to_owned() })
    }

    /// The bytes of the film as animated PNG. Each frame is the rectangle that changes, with all its pixels.
    ///
    /// # Errors
    /// There is no picture, or they are empty.
    pub fn png(&self) -> Result<Vec<u8>, SimError> {
        self.animated(png::ColorType::Rgb, BlendOp::Source, |shot| shot.patch.rgb.clone())
    }

    /// The same film as animated PNG, in which the pixels that stay as they were are left out: they are transparent. It
    /// looks alike, and takes a part of the bytes.
    ///
    /// # Errors
    /// As [`Film::png`].
    pub fn sparse_png(&self) -> Result<Vec<u8>, SimError> {
        self.animated(png::ColorType::Rgba, BlendOp::Over, |shot| {
            let pixels = shot.patch.rgb.chunks_exact(3).zip(&shot.changed);
            pixels.flat_map(|(p, changed)| if *changed { [p[0], p[1], p[2], u8::MAX] } else { [0; 4] }).collect()
        })
    }

    /// The bytes of the film as animated PNG, whose frames hold these pixels.
    fn animated(
        &self,
        color: png::ColorType,
        blend: BlendOp,
        pixels: impl Fn(&Shot) -> Vec<u8>,
    ) -> Result<Vec<u8>, SimError> {
        let first = self.first()?;
        let [above, below] = self.lasts;
        let mut bytes = Vec::new();
        let mut encode = || -> Result<(), png::EncodingError> {
            let mut encoder = encoder(&mut bytes, first.patch.width, first.patch.height);
            encoder.set_color(color);
            encoder.set_animated(self.shots.len() as u32, 0)?;
            encoder.set_frame_delay(first.times * above, below)?;
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&pixels(first))?;
            for shot in &self.shots[1..] {
                writer.reset_frame_position()?;
                writer.set_frame_dimension(shot.patch.width, shot.patch.height)?;
                writer.set_frame_position(shot.left, shot.top)?;
                writer.set_frame_delay(shot.times * above, below)?;
                writer.set_blend_op(blend)?;
                writer.write_image_data(&pixels(shot))?;
            }
            writer.finish()
        };
        encode().map_err(refused)?;
        Ok(bytes)
    }

    /// The bytes of the film as GIF, in the 255 colours that suit it best. The same film gives the same bytes.
    ///
    /// A GIF counts time in hundredths of a second. Each frame begins at the one nearest to its time, so that no error
    /// adds up.
    ///
    /// # Errors
    /// There is no picture, or they are empty or have more than 65535 pixels an edge.
    pub fn gif(&self) -> Result<Vec<u8>, SimError> {
        let first = self.first()?;
        let size = [first.patch.width, first.patch.height].map(u16::try_from);
        let ([Ok(width), Ok(height)], false) = (size, first.patch.rgb.is_empty()) else {
            return Err(SimError::Picture { reason: "a GIF has 1 to 65535 pixels an edge".to_owned() });
        };
        let mut palette = Palette::of(self.shots.iter().map(|shot| (&shot.patch, shot.changed.as_slice())));
        let mut bytes = Vec::new();
        let mut encode = || -> Result<(), gif::EncodingError> {
            let mut encoder = gif::Encoder::new(&mut bytes, width, height, &palette.colors())?;
            encoder.set_repeat(Repeat::Infinite)?;
            let mut shown = 0;
            for shot in &self.shots {
                let begin = self.gif_time(shown);
                shown += u64::from(shot.times);
                encoder.write_frame(&Frame {
                    delay: u16::try_from(self.gif_time(shown) - begin).unwrap_or(u16::MAX),
                    dispose: DisposalMethod::Keep,
                    transparent: Some(UNCHANGED),
                    left: shot.left as u16,
                    top: shot.top as u16,
                    width: shot.patch.width as u16,
                    height: shot.patch.height as u16,
                    buffer: palette.indices(&shot.patch, &shot.changed).into(),
                    ..Frame::default()
                })?;
            }
            Ok(())
        };
        encode().map_err(|error| SimError::Picture { reason: error.to_string() })?;
        Ok(bytes)
    }

    /// When so many pictures have been shown, in the units of a GIF.
    fn gif_time(&self, times: u64) -> u64 {
        let [above, below] = self.lasts.map(u64::from);
        (GIF_TICKS * times * above + below / 2) / below
    }
}

impl Shot {
    /// The part of a picture inside a rectangle, to be shown once, after another picture or none.
    fn of(image: &Image, [left, top, width, height]: [u32; 4], before: Option<&Image>) -> Shot {
        let patch = image.cut(left, top, width, height);
        let pixels = || patch.rgb.chunks_exact(3);
        let changed = match before.map(|before| before.cut(left, top, width, height)) {
            Some(old) => pixels().zip(old.rgb.chunks_exact(3)).map(|(new, old)| new != old).collect(),
            None => vec![true; pixels().count()],
        };
        Shot { left, top, patch, changed, times: 1 }
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
