//! Statistics of a dataset's numbers, element by element, as the package `lerobot` keeps them.

use serde_json::{Map, Value, json};

/// The shares of the numbers that are below each quantile, with its name.
const QUANTILES: [(&str, f64); 5] = [("q01", 0.01), ("q10", 0.10), ("q50", 0.50), ("q90", 0.90), ("q99", 0.99)];

/// Statistics of vectors; each list has one number an element.
pub(super) struct Statistics {
    named: Vec<(&'static str, Vec<f64>)>,
    /// How many vectors there are.
    pub(super) count: usize,
}

impl Statistics {
    /// The statistics of vectors of `width` elements, which stand one after another; at least one.
    pub(super) fn of(numbers: &[f64], width: usize) -> Self {
        let count = numbers.len() / width.max(1);
        let column = |element: usize| {
            let mut column: Vec<f64> = numbers.iter().skip(element).step_by(width).copied().collect();
            column.sort_by(f64::total_cmp);
            column
        };
        let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
        let each = |of: &dyn Fn(&[f64]) -> f64| columns.iter().map(|column| of(column)).collect::<Vec<f64>>();
        let mean = |column: &[f64]| column.iter().sum::<f64>() / count as f64;
        let spread = |column: &[f64]| {
            let middle = mean(column);
            libm::sqrt(column.iter().map(|value| (value - middle) * (value - middle)).sum::<f64>() / count as f64)
        };
        let quantile = |share: f64| {
            move |column: &[f64]| {
                let place = share * (column.len() - 1) as f64;
                let (low, part) = (place.floor() as usize, place.fract());
                let high = (low + 1).min(column.len() - 1);
                column[low] + (column[high] - column[low]) * part
            }
        };
        let mut named = vec![
            ("min", each(&|column| column[0])),
            ("max", each(&|column| column[column.len() - 1])),
            ("mean", each(&mean)),
            ("std", each(&spread)),
        ];
        named.extend(QUANTILES.map(|(name, share)| (name, each(&quantile(share)))));
        Self { named, count }
    }

    /// The lists with their names.
    pub(super) fn named(&self) -> Vec<(&'static str, Vec<f64>)> {
        self.named.clone()
    }

    /// The same as a value of a JSON file.
    pub(super) fn json(&self) -> Value {
        let lists = self.named.iter().map(|(name, list)| ((*name).to_owned(), json!(list)));
        let count = ("count".to_owned(), json!([self.count]));
        Value::Object(lists.chain([count]).collect::<Map<String, Value>>())
    }
}
