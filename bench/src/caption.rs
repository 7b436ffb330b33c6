//! Captions: what is under way in a picture, in a band below it.

use situ_sim::Image;

/// Pixels: width and height of a picture.
pub type PixelSize = [u32; 2];

/// Characters that a line of a caption has room for, where the picture is wide enough.
const LINE: u32 = 40;
/// Lines of a caption.
const LINES: u32 = 2;
/// Pixels about a line, in those of the font.
const MARGIN: u32 = 3;
/// A band takes at most one part in so many of a picture's height. A picture that is too low or too narrow for that has
/// no caption.
const LEAST_PARTS: u32 = 3;
/// What a line that is too long ends with.
const CUT: &str = "...";
/// Colours of the band and of its two lines.
const BAND: [u8; 3] = [34, 38, 46];
const FIRST: [u8; 3] = [244, 244, 244];
const SECOND: [u8; 3] = [186, 194, 206];
/// The colours of how it ended: well, or not.
const GOOD: [u8; 3] = [128, 214, 140];
const BAD: [u8; 3] = [244, 146, 126];

/// What is under way from some step on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Caption {
    /// The skill, or how it ended.
    pub what: String,
    /// The keyframe and its like. The time comes before it.
    pub detail: String,
    /// Whether the goal was reached; `None` where it goes on.
    pub reached: Option<bool>,
}

/// The captions of a performance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Captions {
    /// What the performance is, before all that is said of it.
    title: String,
    /// Each with the first step at which it holds.
    from: Vec<(usize, Caption)>,
}

impl Captions {
    /// No captions yet.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), from: Vec::new() }
    }

    /// From this step on, this holds. Steps must not decrease.
    pub fn add(&mut self, step: usize, caption: Caption) {
        self.from.push((step, caption));
    }

    /// It ends at this step. What was to begin later does not.
    pub fn end(&mut self, step: usize, caption: Caption) {
        self.from.retain(|(from, _)| *from <= step);
        self.add(step, caption);
    }

    /// The lines of a step's picture, and the colour of the second one.
    fn lines(&self, step: usize, seconds: f64) -> ([String; LINES as usize], [u8; 3]) {
        let at = self.from.partition_point(|(from, _)| *from <= step);
        let caption = at.checked_sub(1).map(|index| self.from[index].1.clone()).unwrap_or_default();
        let color = caption.reached.map_or(SECOND, |reached| if reached { GOOD } else { BAD });
        let what = [self.title.as_str(), &caption.what].into_iter().filter(|part| !part.is_empty());
        let what = what.collect::<Vec<_>>().join(": ");
        ([what, format!("{seconds:.1} s  {}", caption.detail)], color)
    }
}

/// The band below a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Band {
    /// Pixels for one of the font.
    scale: u32,
}

impl Band {
    /// The band of a picture of this size; none where there is no room for one that can be read.
    pub fn of([width, height]: PixelSize) -> Option<Self> {
        let [line, _] = Image::text_size(&"m".repeat(LINE as usize), 1);
        let scale = (width / line).max(1);
        let scales = (1..=scale).rev().map(|scale| Self { scale });
        let mut fitting = scales.filter(|band| LEAST_PARTS * band.height() <= height && 2 * width >= line);
        fitting.next()
    }

    /// Its height, pixels.
    pub fn height(self) -> u32 {
        let [_, line] = Image::text_size("", self.scale);
        LINES * line + (LINES + 1) * MARGIN * self.scale
    }

    /// The picture with the caption of a step below it.
    pub fn below(self, picture: &Image, captions: &Captions, (step, seconds): (usize, f64)) -> Image {
        let mut image = Image::plain(picture.width, picture.height + self.height(), BAND);
        image.paste(picture, [0, 0]);
        let (lines, color) = captions.lines(step, seconds);
        let [_, line] = Image::text_size("", self.scale);
        let left = MARGIN * self.scale;
        let mut top = picture.height + left;
        for (text, color) in lines.iter().zip([FIRST, color]) {
            image.write([left, top], self.scale, color, &self.cut(text, picture.width));
            top += line + left;
        }
        image
    }

    /// A text that is too long for the band, with its end left out.
    fn cut(self, text: &str, width: u32) -> String {
        let fits = |text: &str| Image::text_size(text, self.scale)[0] + 2 * MARGIN * self.scale <= width + self.scale;
        if fits(text) {
            return text.to_owned();
        }
        let mut short: Vec<char> = text.chars().collect();
        while !short.is_empty() && !fits(&(short.iter().collect::<String>() + CUT)) {
            short.pop();
        }
        short.into_iter().collect::<String>() + CUT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn caption(what: &str, reached: Option<bool>) -> Caption {
        Caption { what: what.to_owned(), detail: "keyframe 1/2".to_owned(), reached }
    }

    #[test]
    fn a_caption_holds_from_its_step_on() {
        let mut captions = Captions::new("before");
        captions.add(3, caption("pick", None));
        captions.add(3, caption("place", None));
        captions.add(8, caption("never begun", None));
        captions.end(7, caption("end", Some(true)));
        let first = |step| captions.lines(step, 0.25).0[0].clone();
        assert_eq!(
            [0, 2, 3, 6, 7, 99].map(first),
            ["before", "before", "before: place", "before: place"]
                .into_iter()
                .chain(["before: end"; 2])
                .collect::<Vec<_>>()[..]
        );
        assert_eq!(captions.lines(4, 12.34), (["before: place".into(), "12.3 s  keyframe 1/2".into()], SECOND));
        assert_eq!(captions.lines(8, 0.0).1, GOOD);
    }

    #[test]
    fn a_band_can_be_read_or_is_not_there() {
        assert_eq!(Band::of([480, 300]), Some(Band { scale: 2 }));
        assert_eq!(Band::of([240, 150]), Some(Band { scale: 1 }));
        assert_eq!(Band::of([960, 100]), Some(Band { scale: 1 }), "low");
        assert_eq!([[48, 30], [480, 70], [100, 300]].map(Band::of), [None; 3]);
        for size in [[480, 300], [300, 200], [1920, 1080]] {
            let band = Band::of(size).unwrap();
            assert!(LEAST_PARTS * band.height() <= size[1]);
            let picture = Image::plain(size[0], size[1] - band.height(), [1, 2, 3]);
            let mut captions = Captions::new("");
            captions.add(0, caption(&"w".repeat(500), None));
            let image = band.below(&picture, &captions, (0, 1.0));
            assert_eq!([image.width, image.height], size);
            assert!(image.rgb.starts_with(&picture.rgb), "the picture itself is untouched");
            let ink = |color: [u8; 3]| image.rgb.chunks_exact(3).filter(|pixel| *pixel == color).count();
            assert!(ink(FIRST) > 200 && ink(SECOND) > 50 && ink(BAND) > ink(FIRST));
            let other = Captions::new("after");
            assert_ne!(band.below(&picture, &other, (0, 1.0)), image);
            let cut = band.cut(&"w".repeat(500), size[0]);
            assert!(cut.ends_with(CUT) && cut.len() > 30, "{cut}");
        }
    }
}
