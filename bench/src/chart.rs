//! Charts as SVG: small panels of lines in a grid, with one legend. For print and for the colour-blind: every line has
//! a colour of Okabe and Ito's palette, a dash and a marker of its own. For light and dark: a style in the file itself.
//!
//! Equal numbers give equal bytes.

mod contents;
mod palette;
mod panel;
mod svg;

pub use contents::{Chart, ChartAxis, ChartPanel, ChartPoint, Line, Scale};
pub use svg::to_svg;
