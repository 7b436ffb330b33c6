//! A panel: where its numbers lie, and which of them have labels.

use super::contents::{ChartAxis, ChartPanel, ChartPoint, Line, Scale};

/// About so many labels an axis has of its own.
const LABELS: f64 = 4.0;

/// An axis over numbers: its ends and labels, on the scale.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Laid {
    scale: Scale,
    /// The ends.
    pub(super) ends: (f64, f64),
    /// Where there are labels.
    pub(super) labels: Vec<f64>,
}

impl Laid {
    /// An axis over these numbers.
    pub(super) fn over(axis: &ChartAxis, numbers: impl Iterator<Item = f64>) -> Self {
        let on = |number: f64| place(axis.scale, number);
        let named = axis.labels.iter().flatten().copied();
        let covered = axis.covers.iter().flat_map(|(low, high)| [*low, *high]);
        let numbers: Vec<f64> = numbers.chain(named).chain(covered).filter_map(on).collect();
        let (mut low, mut high) = numbers
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| (low.min(*number), high.max(*number)));
        if numbers.is_empty() {
            (low, high) = (0.0, 1.0);
        }
        if high - low < 1e-9 * high.abs().max(1.0) {
            (low, high) = match axis.scale {
                Scale::Linear => (low.min(0.0), high + high.abs().max(1.0)),
                Scale::Log => (low - 1.0, high + 1.0),
            };
        }
        let labels = match &axis.labels {
            Some(labels) => labels.iter().copied().filter_map(on).collect(),
            None => round_numbers(axis.scale, low, high),
        };
        Self { scale: axis.scale, ends: (low, high), labels }
    }

    /// Where a number lies; `None` where it has no place.
    pub(super) fn place(&self, number: f64) -> Option<f64> {
        place(self.scale, number).map(|place| place.clamp(self.ends.0, self.ends.1))
    }

    /// What is written at a label.
    pub(super) fn text(&self, place: f64) -> String {
        let number = match self.scale {
            Scale::Linear => place,
            Scale::Log => 10_f64.powf(place),
        };
        // A power of ten comes back a little off.
        let number: f64 = format!("{number:.6e}").parse().unwrap_or(number);
        if number != 0.0 && (number.abs() >= 1e5 || number.abs() < 1e-3) {
            format!("{number:e}")
        } else {
            number.to_string()
        }
    }
}

/// Beyond these a chart has no place for a number.
const LARGEST: f64 = 1e15;

fn place(scale: Scale, number: f64) -> Option<f64> {
    let place = match scale {
        Scale::Linear => number,
        Scale::Log if number > 0.0 => number.log10(),
        Scale::Log => return None,
    };
    (place.is_finite() && place.abs() <= LARGEST).then_some(place)
}

/// A few round numbers between the ends: multiples of 1, 2 or 5 times a power of ten, or powers of ten.
fn round_numbers(scale: Scale, low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / LABELS;
    let step = match scale {
        Scale::Log => rough.ceil().max(1.0),
        Scale::Linear => {
            let unit = 10_f64.powf(rough.log10().floor());
            [1.0, 2.0, 5.0, 10.0].into_iter().map(|times| times * unit).find(|step| *step >= rough).unwrap_or(rough)
        }
    };
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|times| times as f64 * step).collect()
}

impl ChartPanel {
    /// Both axes over all that the panel shows.
    pub(super) fn axes(&self) -> [Laid; 2] {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let heights = |point: &ChartPoint| {
            let (low, high) = point.interval.unwrap_or((point.y, point.y));
            [point.y, low, high]
        };
        [Laid::over(&self.x, points().map(|point| point.x)), Laid::over(&self.y, points().flat_map(heights))]
    }
}

impl Line {
    /// Its points on the axes, but for those that have no place there.
    pub(super) fn places(&self, [x, y]: &[Laid; 2]) -> Vec<ChartPoint> {
        let place = |point: &ChartPoint| {
            let interval = point.interval.and_then(|(low, high)| Some((y.place(low)?, y.place(high)?)));
            Some(ChartPoint { x: x.place(point.x)?, y: y.place(point.y)?, interval })
        };
        self.points.iter().filter_map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_few_and_round() {
        let labels = |axis: ChartAxis, numbers: &[f64]| {
            let laid = Laid::over(&axis, numbers.iter().copied());
            laid.labels.iter().map(|place| laid.text(*place)).collect::<Vec<_>>()
        };
        assert_eq!(labels(ChartAxis::amounts("n"), &[3.0, 17.0]), ["0", "5", "10", "15"]);
        assert_eq!(labels(ChartAxis::amounts("n"), &[0.013]), ["0", "0.005", "0.01"]);
        assert_eq!(labels(ChartAxis::log("n", None), &[0.02, 900.0]), ["1", "100"]);
        assert_eq!(labels(ChartAxis::log("cm", Some(vec![1.0, 2.0, 16.0])), &[]), ["1", "2", "16"]);
        assert_eq!(labels(ChartAxis::amounts("n"), &[]), ["0", "0.5", "1"]);
    }
}
