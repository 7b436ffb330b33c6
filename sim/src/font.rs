//! Text in pictures: a fixed-width bitmap font of our own, for the printable characters of ASCII.

use std::sync::LazyLock;

use crate::image::Image;

/// The characters' shapes, from the space to the tilde, in bands of [`BAND`]. `#` is ink.
const SHAPES: &str = include_str!("font.txt");
/// Characters in a band of the file.
const BAND: usize = 19;
/// Columns of a character.
const COLUMNS: usize = 5;
/// Rows of a character: seven of a capital letter, and two below the line that it stands on.
const ROWS: usize = 9;
/// Columns from one character to the next.
const ADVANCE: u32 = COLUMNS as u32 + 1;
/// What stands for a character that the font has not.
const UNKNOWN: u8 = b'?';

/// The rows of a character from the top. The lowest bit is the leftmost column.
type Glyph = [u8; ROWS];

/// The characters in the order of ASCII, from the space on.
static GLYPHS: LazyLock<Vec<Glyph>> = LazyLock::new(|| {
    let lines: Vec<&str> = SHAPES.lines().filter(|line| !line.is_empty()).collect();
    let row = |line: &str, place: usize| {
        let ink = line.bytes().skip(place * ADVANCE as usize).take(COLUMNS).enumerate();
        ink.map(|(column, shape)| u8::from(shape == b'#') << column).sum()
    };
    let band = |band: &[&str]| -> Vec<Glyph> {
        (0..BAND).map(|place| std::array::from_fn(|line| row(band[line], place))).collect()
    };
    lines.chunks_exact(ROWS).flat_map(band).collect()
});

fn glyph(character: char) -> &'static Glyph {
    let known = |byte: u8| GLYPHS.get(usize::from(byte.checked_sub(b' ')?));
    let found = u8::try_from(character).ok().and_then(known);
    found.or_else(|| known(UNKNOWN)).expect("the font has it")
}

impl Image {
    /// Width and height of a line of text, pixels. A pixel of the font is a square of `scale` pixels.
    pub fn text_size(text: &str, scale: u32) -> [u32; 2] {
        [ADVANCE * scale * text.chars().count() as u32, ROWS as u32 * scale]
    }

    /// Writes a line of text, its upper left corner at `left` and `top`. What does not fit is cut off at the edge. A
    /// character outside of printable ASCII is shown as a question mark.
    pub fn write(&mut self, [left, top]: [u32; 2], scale: u32, color: [u8; 3], text: &str) {
        for (place, character) in (0..).zip(text.chars()) {
            for (row, columns) in (0..).zip(glyph(character)) {
                for column in (0..COLUMNS as u32).filter(|column| columns >> column & 1 == 1) {
                    let corner = [left + (ADVANCE * place + column) * scale, top + row * scale];
                    self.fill(corner, [scale; 2], color);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_character_has_a_shape_of_its_own() {
        assert_eq!(GLYPHS.len(), 95, "the printable characters");
        let shapes: BTreeSet<&Glyph> = GLYPHS.iter().collect();
        assert_eq!(shapes.len(), GLYPHS.len());
        assert_eq!(glyph(' '), &[0; ROWS]);
        assert_eq!(glyph('é'), glyph('?'));
        assert_eq!(glyph('L'), &[1, 1, 1, 1, 1, 1, 31, 0, 0]);
        // Only what hangs below the line has ink there.
        let hanging = (' '..='~').filter(|character| glyph(*character)[7..] != [0, 0]);
        assert_eq!(hanging.collect::<String>(), ",;_gjpqy");
    }

    #[test]
    fn text_is_where_it_is_written_and_stays_in_the_picture() {
        let ink = |at: [u32; 2], scale: u32| {
            let mut image = Image::plain(40, 20, [0; 3]);
            image.write(at, scale, [9, 8, 7], "I.");
            let is_ink = |x: u32, y: u32| image.pixel(x, y) == Some([9, 8, 7]);
            (0..20).flat_map(|y| (0..40).map(move |x| (x, y))).filter(|&(x, y)| is_ink(x, y)).collect::<Vec<_>>()
        };
        assert_eq!(Image::text_size("I.", 2), [24, 18]);
        // The letter has 3 + 5 + 3 pixels, the full stop 4.
        assert_eq!((ink([0, 0], 1).len(), ink([0, 0], 2).len()), (15, 4 * 15));
        let moved: Vec<(u32, u32)> = ink([0, 0], 1).into_iter().map(|(x, y)| (x + 7, y + 5)).collect();
        assert_eq!(ink([7, 5], 1), moved);
        assert!(ink([38, 15], 2).iter().all(|&(x, y)| x < 40 && y < 20) && ink([100, 100], 1).is_empty());
    }
}
