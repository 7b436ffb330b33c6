//! A sequence of changes: what is learned, what is forgotten, and how much is known all along.

use super::mean;

/// What a sequence of N stages comes to. `rates[m][n]` is the success on stage n after stage m, n ≤ m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceScore {
    /// Forward transfer: success on each stage once it was learned, (1/N) Σ r(n|n).
    pub forward: f64,
    /// Negative backward transfer: what later stages cost the earlier ones. `None` where there is one stage alone.
    pub negative_backward: Option<f64>,
    /// The area under the curve: success on each stage from then on.
    pub area: f64,
}

/// The scores of a sequence (Liu et al. 2023, LIBERO). `None` where a row is not as long as its number.
pub fn sequence(rates: &[Vec<f64>]) -> Option<SequenceScore> {
    if rates.iter().enumerate().any(|(m, row)| row.len() != m + 1) {
        return None;
    }
    let after = |n: usize| rates[n..].iter().map(move |row| row[n]);
    let stages = 0..rates.len();
    let forward = mean(&stages.clone().map(|n| rates[n][n]).collect::<Vec<_>>())?;
    let lost = |n: usize| mean(&after(n).skip(1).map(|rate| rates[n][n] - rate).collect::<Vec<_>>());
    let negative_backward = mean(&stages.clone().filter_map(lost).collect::<Vec<_>>());
    let area = mean(&stages.filter_map(|n| mean(&after(n).collect::<Vec<_>>())).collect::<Vec<_>>())?;
    Some(SequenceScore { forward, negative_backward, area })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of the benchmark's reference (`metrics`).
    #[test]
    fn the_reference_values() {
        let score = sequence(&[vec![0.8], vec![0.6, 0.9]]).unwrap();
        for (found, expected) in [(score.forward, 0.85), (score.negative_backward.unwrap(), 0.20), (score.area, 0.80)] {
            assert!((found - expected).abs() < 1e-12, "{score:?}");
        }
        assert_eq!(sequence(&[vec![1.0], vec![1.0]]), None);
        assert_eq!(sequence(&[]), None);
        assert_eq!(sequence(&[vec![0.5]]).unwrap().negative_backward, None);
    }
}
