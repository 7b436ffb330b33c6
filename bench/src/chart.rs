//! Charts as SVG: small panels of lines in a grid, with one legend. For print and for the colour-blind: every line has a
//! colour of Okabe and Ito's palette, a dash and a marker of its own. For light and dark: a style in the file itself.
//!
//! Equal numbers give equal bytes.

mod palette;
mod panel;
mod svg;

use std::collections::BTreeMap;

/// A number on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// The interval of y.
    pub interval: Option<(f64, f64)>,
}

/// A line of a panel. Lines of one name look alike in all panels of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// Its points, by x.
    pub points: Vec<Point>,
}

/// How numbers are laid along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// As they are.
    Linear,
    /// By their logarithms; what is not above 0 has no place.
    Log,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it is, with its unit.
    pub name: String,
    /// How numbers are laid along it.
    pub scale: Scale,
    /// The ends that it has at least.
    pub covers: Option<(f64, f64)>,
    /// Where it has labels; a few round numbers where that is not said.
    pub labels: Option<Vec<f64>>,
}

impl Axis {
    /// An axis of shares, from 0 to 1.
    pub fn shares(name: &str) -> Self {
        let labels = Some(vec![0.0, 0.25, 0.5, 0.75, 1.0]);
        Self { name: name.to_owned(), scale: Scale::Linear, covers: Some((0.0, 1.0)), labels }
    }

    /// An axis from 0 on.
    pub fn amounts(name: &str) -> Self {
        Self { name: name.to_owned(), scale: Scale::Linear, covers: Some((0.0, 0.0)), labels: None }
    }

    /// A logarithmic axis that has labels at these numbers.
    pub fn log(name: &str, labels: Option<Vec<f64>>) -> Self {
        Self { name: name.to_owned(), scale: Scale::Log, covers: None, labels }
    }

    /// An axis of whole numbers, each with a label.
    pub fn counts(name: &str, to: u32) -> Self {
        let labels = (1..=to).map(f64::from).collect();
        let covers = Some((1.0, f64::from(to.max(1))));
        Self { name: name.to_owned(), scale: Scale::Linear, covers, labels: Some(labels) }
    }
}

/// One panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its title.
    pub title: String,
    /// The axis along its lower edge.
    pub x: Axis,
    /// The axis along its left edge.
    pub y: Axis,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// Panels in a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What it shows, in one sentence; for those who cannot see it, too.
    pub title: String,
    /// How many panels stand side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

impl Chart {
    /// The names of its lines, in the order in which they are met, each with its look.
    fn looks(&self) -> Vec<(&str, palette::Look)> {
        let mut met = BTreeMap::new();
        let mut names = Vec::new();
        for line in self.panels.iter().flat_map(|panel| &panel.lines) {
            met.entry(&*line.name).or_insert_with(|| names.push(&*line.name));
        }
        names.into_iter().enumerate().map(|(index, name)| (name, palette::look(index))).collect()
    }

    /// The chart as an SVG file.
    pub fn to_svg(&self) -> String {
        svg::of(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(axis: Axis, ys: &[f64]) -> Chart {
        let point = |(x, y): (usize, &f64)| Point { x: x as f64 + 1.0, y: *y, interval: Some((*y * 0.9, *y * 1.1)) };
        let points: Vec<Point> = ys.iter().enumerate().map(point).collect();
        let lines = ["a <b>", "c & d"].map(|name| Line { name: name.to_owned(), points: points.clone() });
        let x = Axis::counts("stage", 3);
        let panel = Panel { title: "one \"panel\"".to_owned(), x, y: axis, lines: lines.to_vec() };
        Chart { title: "What <it> & shows".to_owned(), columns: 2, panels: vec![panel.clone(), panel.clone(), panel] }
    }

    /// Any numbers make a well-formed file, the same each time, in which nothing lies outside of the picture.
    #[test]
    fn any_numbers_make_a_sound_picture() {
        let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 1e300];
        for ys in [&[][..], &[0.5], &[0.2, 0.4, 0.9], &odd] {
            for axis in [Axis::shares("share"), Axis::amounts("n"), Axis::log("s", None)] {
                let chart = chart(axis, ys);
                let svg = chart.to_svg();
                assert_eq!(svg, chart.to_svg());
                assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                assert!(svg.contains("What &lt;it&gt; &amp; shows") && svg.contains("a &lt;b&gt;"), "{svg}");
                let opened = svg.matches("<text").count();
                assert_eq!(opened, svg.matches("</text>").count());
            }
        }
    }

    #[test]
    fn lines_of_one_name_look_alike() {
        let mut chart = chart(Axis::shares("share"), &[0.5, 0.6]);
        chart.panels[1].lines.reverse();
        let names: Vec<&str> = chart.looks().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["a <b>", "c & d"]);
        let svg = chart.to_svg();
        // Three panels and the legend.
        let colour = |index| palette::look(index).colour.hex();
        assert!(svg.matches(&colour(0)).count() >= 4 && svg.matches(&colour(1)).count() >= 4, "{svg}");
    }
}
