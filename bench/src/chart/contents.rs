//! What a chart shows.

/// A number on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
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
    pub points: Vec<ChartPoint>,
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
pub struct ChartAxis {
    /// What it is, with its unit.
    pub name: String,
    /// How numbers are laid along it.
    pub scale: Scale,
    /// The ends that it has at least.
    pub covers: Option<(f64, f64)>,
    /// Where it has labels; a few round numbers where that is not said.
    pub labels: Option<Vec<f64>>,
}

impl ChartAxis {
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
pub struct ChartPanel {
    /// Its title.
    pub title: String,
    /// The axis along its lower edge.
    pub x: ChartAxis,
    /// The axis along its left edge.
    pub y: ChartAxis,
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
    pub panels: Vec<ChartPanel>,
}
