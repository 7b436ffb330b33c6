//! Summaries of runs: proportions, means, ratios and slopes, each with a 95 % interval.
//!
//! The test values are those of the benchmark's reference (`metrics`). Roots, logarithms and exponentials come from
//! `libm`, sums run in the order of the data, and resampling takes its seed from the caller: equal data give equal
//! bytes.

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, StudentsT};

pub mod paired;
pub mod roc;
pub mod sequence;

/// The 97.5th percentile of the standard normal distribution.
const NORMAL_975: f64 = 1.959_963_984_540_054;
/// The tails that a 95 % interval leaves out, as probabilities.
const TAILS: (f64, f64) = (0.025, 0.975);
/// Resamples of a bootstrap. The percentiles at 2.5 % then rest on 50 draws in each tail.
pub const RESAMPLES: usize = 2000;

/// An estimate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// The Wilson 95 % interval of `successes` out of `trials` (Wilson 1927); [0, 1] where there is no trial.
///
/// Unlike the Wald interval it does not collapse at 0 and 1: 20 of 20 gives [0.839, 1.0].
pub fn wilson(successes: u32, trials: u32) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let (k, n, square) = (f64::from(successes), f64::from(trials), NORMAL_975 * NORMAL_975);
    let centre = (k + square / 2.0) / (n + square);
    let half = NORMAL_975 / (n + square) * libm::sqrt(k * (n - k) / n + square / 4.0);
    // At the ends the formula is exact and its rounding is not.
    let low = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
    let high = if successes >= trials { 1.0 } else { (centre + half).min(1.0) };
    (low, high)
}

/// The arithmetic mean; `None` where there is no value.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The median: of an even number of values, the mean of the two middle ones. `None` where there is no value.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(if sorted.len() % 2 == 1 { upper } else { 0.5 * (sorted[sorted.len() / 2 - 1] + upper) })
}

/// The quantile (0 to 1), linear between ranks; `None` where there is no value.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| percentile(&sorted, share))
}

/// The percentile (0 to 1) of sorted values, linear between ranks.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = share * (sorted.len() - 1) as f64;
    let below = rank as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (rank - below as f64) * (sorted[above] - sorted[below])
}

/// The percentile bootstrap of a statistic of `n` things. `statistic` takes the indices of a resample; a resample for
/// which it is `None` is left out. `None` where there is nothing to resample, and where the statistic of the things
/// themselves is `None`.
pub fn bootstrap(n: usize, seed: u64, statistic: impl Fn(&[usize]) -> Option<f64>) -> Option<Estimate> {
    bootstrap_within(&[n], seed, statistic)
}

/// The same with strata: each resample draws as many things from each stratum as there are in it. The things are
/// numbered through, stratum by stratum.
pub fn bootstrap_within(strata: &[usize], seed: u64, statistic: impl Fn(&[usize]) -> Option<f64>) -> Option<Estimate> {
    let n: usize = strata.iter().sum();
    if n == 0 {
        return None;
    }
    let value = statistic(&(0..n).collect::<Vec<_>>())?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = Vec::with_capacity(n);
    let mut values = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        drawn.clear();
        for &size in strata {
            let first = drawn.len();
            drawn.extend((0..size).map(|_| first + rng.random_range(0..size)));
        }
        values.extend(statistic(&drawn));
    }
    values.sort_by(f64::total_cmp);
    if values.is_empty() {
        return None;
    }
    Some(Estimate { value, low: percentile(&values, TAILS.0), high: percentile(&values, TAILS.1) })
}

/// The interquartile mean of scores pooled over tasks: a quarter of them, rounded down, is left out at each end
/// (Agarwal et al. 2021). `None` where there is no score.
pub fn interquartile_mean(scores: &[f64]) -> Option<f64> {
    let mut sorted = scores.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The restricted mean of what was spent until the target was first reached, or the budget was used up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestrictedMean {
    /// E[min(T, budget)], with a bootstrap interval over the runs.
    pub estimate: Estimate,
    /// Runs that used the budget up. Where there is one, the mean without a budget is greater.
    pub censored: usize,
}

/// The restricted mean over runs. Each is what it spent, and whether it was censored at the budget. `None` where there
/// is no run.
pub fn restricted_mean(spent: &[(f64, bool)], seed: u64) -> Option<RestrictedMean> {
    let value = |drawn: &[usize]| mean(&drawn.iter().map(|index| spent[*index].0).collect::<Vec<_>>());
    let estimate = bootstrap(spent.len(), seed, value)?;
    Some(RestrictedMean { estimate, censored: spent.iter().filter(|(_, censored)| *censored).count() })
}

/// The ratio of the sums of pairs (numerator, denominator), resampled by pairs; `None` where the denominators sum to 0.
pub fn paired_ratio(pairs: &[(f64, f64)], seed: u64) -> Option<Estimate> {
    bootstrap(pairs.len(), seed, |drawn| {
        let sum = |part: fn(&(f64, f64)) -> f64| drawn.iter().map(|index| part(&pairs[*index])).sum::<f64>();
        let below = sum(|pair| pair.1);
        (below > 0.0).then(|| sum(|pair| pair.0) / below)
    })
}

/// y = factor · x^exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// ln of the factor.
    pub log_factor: f64,
    /// The exponent: the slope of ln y over ln x.
    pub exponent: Estimate,
}

/// A power law by least squares of ln y over ln x. The exponent has Student's 95 % interval of n − 2 degrees of
/// freedom.
///
/// `None` where there are fewer than three points, a coordinate is not above 0, or every x is the same.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let n = points.len();
    if n < 3 || points.iter().any(|(x, y)| !(*x > 0.0 && *y > 0.0)) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (libm::log(*x), libm::log(*y))).collect();
    let average = |part: fn(&(f64, f64)) -> f64| logs.iter().map(part).sum::<f64>() / n as f64;
    let (x, y) = (average(|point| point.0), average(|point| point.1));
    let spread: f64 = logs.iter().map(|point| (point.0 - x) * (point.0 - x)).sum();
    if spread <= 0.0 {
        return None;
    }
    let value = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>() / spread;
    let residual = |point: &(f64, f64)| point.1 - y - value * (point.0 - x);
    let squares: f64 = logs.iter().map(|point| residual(point) * residual(point)).sum();
    let freedom = (n - 2) as f64;
    let half = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(TAILS.1) * libm::sqrt(squares / freedom / spread);
    let exponent = Estimate { value, low: value - half, high: value + half };
    Some(PowerLaw { log_factor: y - value * x, exponent })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn close(left: f64, right: f64) {
        assert!((left - right).abs() < 1e-9, "{left} against {right}");
    }

    #[test]
    fn the_reference_values() {
        let (low, high) = wilson(20, 20);
        assert_eq!((format!("{low:.3}"), high), ("0.839".to_owned(), 1.0));
        let x = [1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 2.0, 1.0];
        let y = [1.0, 1.0, 2.0, 2.0, 3.0, 3.0];
        assert_eq!((interquartile_mean(&x), interquartile_mean(&y)), (Some(1.5), Some(2.0)));
    }

    /// A stratum of one thing is always drawn, so that what differs between strata is no spread.
    #[test]
    fn strata_are_drawn_apart() {
        let scores = [1.0, 3.0, 100.0];
        let value = |drawn: &[usize]| mean(&drawn.iter().map(|index| scores[*index]).collect::<Vec<_>>());
        let within = bootstrap_within(&[2, 1], 7, value).unwrap();
        assert_eq!((within.low, within.high), (102.0 / 3.0, 106.0 / 3.0));
        let across = bootstrap(3, 7, value).unwrap();
        assert!(across.low < within.low && across.high > within.high);
    }

    /// The ends of the Wilson interval solve (p̂ − p)² = z² p (1 − p) / n: an oracle that does not use the formula.
    #[test]
    fn wilson_ends_solve_the_score_equation() {
        for (k, n) in [(1, 7), (3, 10), (0, 4), (12, 12), (47, 50)] {
            let (low, high) = wilson(k, n);
            let (share, n) = (f64::from(k) / f64::from(n), f64::from(n));
            for end in [low, high] {
                close((share - end).powi(2), NORMAL_975.powi(2) * end * (1.0 - end) / n);
            }
        }
    }

    /// By hand: x = 1, e, e² and ln y = 0, 2, 1. Slope 0.5 about the point (1, 1), residuals −0.5, 1, −0.5, its
    /// standard error √(1.5/2), and t(0.975, 1 degree of freedom) = tan(0.475 π).
    #[test]
    fn a_slope_by_hand() {
        let e = std::f64::consts::E;
        let PowerLaw { log_factor, exponent: slope } = power_law(&[(1.0, 1.0), (e, e * e), (e * e, e)]).unwrap();
        close(slope.value, 0.5);
        close(log_factor, 0.5);
        let half = (0.475 * std::f64::consts::PI).tan() * 0.75_f64.sqrt();
        assert!((slope.high - 0.5 - half).abs() < 1e-6 && (0.5 - slope.low - half).abs() < 1e-6, "{slope:?}");
        assert_eq!(power_law(&[(1.0, 1.0), (2.0, 0.0), (3.0, 1.0)]), None);
        assert_eq!(power_law(&[(2.0, 1.0), (2.0, 2.0), (2.0, 3.0)]), None);
    }

    /// With two values the resampled mean is a, (a + b)/2 or b, with probabilities 1/4, 1/2, 1/4. So the interval is
    /// [a, b].
    #[test]
    fn bootstrap_of_two_values_spans_both() {
        let mean = restricted_mean(&[(1.0, false), (4.0, true)], 7).unwrap();
        assert_eq!((mean.estimate.value, mean.estimate.low, mean.estimate.high, mean.censored), (2.5, 1.0, 4.0, 1));
        assert_eq!(restricted_mean(&[], 7), None);
        assert_eq!(paired_ratio(&[(1.0, 0.0)], 7), None);
        assert_eq!(paired_ratio(&[(1.0, 2.0), (2.0, 4.0)], 7).map(|ratio| (ratio.low, ratio.high)), Some((0.5, 0.5)));
    }

    /// For many values the bootstrap of a mean approaches the normal interval of the mean.
    #[test]
    fn bootstrap_agrees_with_the_normal_interval() {
        let spent: Vec<(f64, bool)> = (0..400).map(|index| (f64::from(index * 37 % 101), false)).collect();
        let estimate = restricted_mean(&spent, 3).unwrap().estimate;
        let variance = spent.iter().map(|(value, _)| (value - estimate.value).powi(2)).sum::<f64>() / 400.0;
        let half = NORMAL_975 * (variance / 400.0).sqrt();
        for end in [estimate.high - estimate.value, estimate.value - estimate.low] {
            assert!((end / half - 1.0).abs() < 0.1, "{end} against {half}");
        }
    }

    proptest! {
        /// A power law is recovered, whatever its exponent, and a slope never depends on the unit of either axis.
        #[test]
        fn a_power_law_has_its_exponent(exponent in -3.0..3.0_f64, unit in 0.01..100.0_f64) {
            let point = |x| (unit * f64::from(x), unit * f64::from(x).powf(exponent));
            let points: Vec<(f64, f64)> = (1..9).map(point).collect();
            let law = power_law(&points).unwrap();
            let slope = law.exponent;
            prop_assert!((slope.value - exponent).abs() < 1e-9 && slope.high - slope.low < 1e-6);
            prop_assert!((law.log_factor - unit.ln() * (1.0 - exponent)).abs() < 1e-9);
        }

        /// The interval holds the estimate, mirrors when successes and failures change places, and shrinks with n.
        #[test]
        fn wilson_is_an_interval(n in 1_u32..200, share in 0.0..=1.0_f64) {
            let k = (share * f64::from(n)) as u32;
            let (low, high) = wilson(k, n);
            let rate = f64::from(k) / f64::from(n);
            prop_assert!(0.0 <= low && low <= rate && rate <= high && high <= 1.0);
            let (other_low, other_high) = wilson(n - k, n);
            prop_assert!((low - (1.0 - other_high)).abs() < 1e-12 && (high - (1.0 - other_low)).abs() < 1e-12);
            let (wider_low, wider_high) = wilson(4 * k, 4 * n);
            prop_assert!(wider_high - wider_low < high - low);
        }
    }
}
