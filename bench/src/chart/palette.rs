//! How lines look, and how the same looks on a dark page.

use plotters::style::RGBColor;

/// A colour on a light page, and what it becomes on a dark one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour {
    light: (u8, u8, u8),
    dark: (u8, u8, u8),
}

impl Colour {
    const fn new(light: (u8, u8, u8), dark: (u8, u8, u8)) -> Self {
        Self { light, dark }
    }

    /// For the page that is drawn.
    pub(super) fn rgb(self) -> RGBColor {
        let (red, green, blue) = self.light;
        RGBColor(red, green, blue)
    }

    /// As it stands in the file.
    pub(super) fn hex(self) -> String {
        let (red, green, blue) = self.light;
        format!("#{red:02X}{green:02X}{blue:02X}")
    }

    fn dark_hex(self) -> String {
        let (red, green, blue) = self.dark;
        format!("#{red:02X}{green:02X}{blue:02X}")
    }
}

/// What is written and drawn in.
pub(super) const INK: Colour = Colour::new((38, 38, 38), (230, 230, 230));
/// What it stands on.
pub(super) const PAPER: Colour = Colour::new((255, 255, 255), (24, 26, 27));
/// Lines across a panel.
pub(super) const RULE: Colour = Colour::new((224, 224, 224), (58, 62, 64));

/// Of Okabe and Ito (2008), but for their yellow, which is too pale for a line; the first is their black.
const COLOURS: [Colour; 7] = [
    Colour::new((0, 114, 178), (86, 170, 230)),
    Colour::new((213, 94, 0), (240, 130, 50)),
    Colour::new((0, 158, 115), (40, 190, 145)),
    Colour::new((204, 121, 167), (220, 150, 190)),
    Colour::new((90, 90, 90), (170, 170, 170)),
    Colour::new((86, 180, 233), (130, 205, 245)),
    Colour::new((230, 159, 0), (240, 180, 60)),
];

/// A shape at each point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marker {
    Disc,
    Square,
    Triangle,
    Cross,
    Ring,
}

/// How a line looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Look {
    pub(super) colour: Colour,
    pub(super) marker: Marker,
    /// Lengths of dash and gap; drawn through without.
    pub(super) dash: Option<(u32, u32)>,
}

/// The look of the line of this number.
pub(super) fn look(index: usize) -> Look {
    const MARKERS: [Marker; 5] = [Marker::Disc, Marker::Square, Marker::Triangle, Marker::Cross, Marker::Ring];
    const DASHES: [Option<(u32, u32)>; 4] = [None, Some((6, 3)), Some((2, 3)), Some((9, 3))];
    let of = |count: usize| index % count;
    Look { colour: COLOURS[of(COLOURS.len())], marker: MARKERS[of(MARKERS.len())], dash: DASHES[of(DASHES.len())] }
}

/// The style that turns the colours of a file on a dark page.
pub(super) fn style() -> String {
    let rules = [INK, PAPER, RULE].into_iter().chain(COLOURS).map(|colour| {
        let (light, dark) = (colour.hex(), colour.dark_hex());
        format!("[fill=\"{light}\"]{{fill:{dark}}}[stroke=\"{light}\"]{{stroke:{dark}}}")
    });
    format!("<style>@media (prefers-color-scheme:dark){{{}}}</style>", rules.collect::<String>())
}
