//! The colours of a GIF: at most 255 and one that leaves a pixel as it was.

use std::collections::BTreeMap;

use color_quant::NeuQuant;

use crate::image::Image;

/// The colour that leaves a pixel as it was: the last one.
pub(super) const UNCHANGED: u8 = COLORS as u8;
/// Colours that are seen.
const COLORS: usize = 255;
/// Every so many-th pixel teaches the colours: 1 is the best, 30 the fastest.
const SAMPLED: i32 = 1;
/// Pixels that teach the colours, at the most: enough that a small thing is among them in some picture.
const MOST_PIXELS: usize = 400_000;

/// The colours of a film.
pub(super) struct Palette {
    network: NeuQuant,
    /// The colours that were looked up before.
    known: BTreeMap<[u8; 3], u8>,
}

impl Palette {
    /// The colours that suit these pixels best, by a network that learns them one after another in a fixed order
    /// (Dekker, Network 5, 1994). Pixels that are not marked do not count.
    pub(super) fn of<'a>(pictures: impl Iterator<Item = (&'a Image, &'a [bool])> + Clone) -> Palette {
        let seen = pictures.flat_map(|(image, marks)| {
            image.rgb.chunks_exact(3).zip(marks).filter(|(_, mark)| **mark).map(|(pixel, _)| pixel)
        });
        let every = seen.clone().count().div_ceil(MOST_PIXELS).max(1);
        let taught: Vec<u8> = seen.step_by(every).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], u8::MAX]).collect();
        Palette { network: NeuQuant::new(SAMPLED, COLORS, &taught), known: BTreeMap::new() }
    }

    /// The colours one after the other, red, green and blue, the one that is never seen last.
    pub(super) fn colors(&self) -> Vec<u8> {
        let mut colors = self.network.color_map_rgb();
        colors.resize(3 * (COLORS + 1), 0);
        colors
    }

    /// The colour of each pixel; those that are not marked stay as they were.
    pub(super) fn indices(&mut self, image: &Image, marks: &[bool]) -> Vec<u8> {
        let network = &self.network;
        let known = &mut self.known;
        let mut index = |pixel: [u8; 3]| {
            *known.entry(pixel).or_insert_with(|| network.index_of(&[pixel[0], pixel[1], pixel[2], u8::MAX]) as u8)
        };
        let pixels = image.rgb.chunks_exact(3).zip(marks);
        pixels.map(|(pixel, mark)| if *mark { index([pixel[0], pixel[1], pixel[2]]) } else { UNCHANGED }).collect()
    }
}
