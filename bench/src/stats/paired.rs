//! Paired comparisons: sign-flip tests over units, and Holm's correction for several of them.

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Up to so many differences all sign vectors are gone through; 2¹⁶ of them take milliseconds.
const EXACT: usize = 16;
/// Sign vectors that are drawn where there are more. The standard error of a p-value of .05 is then .0007.
pub const FLIPS: u32 = 100_000;
/// Sums that differ by less than this share of the largest one are equal but for rounding.
const ROUNDING: f64 = 1e-12;

/// The result of a sign-flip test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignFlip {
    /// The two-sided p-value: the share of sign vectors under which the sum of the differences is as far from 0.
    pub p: f64,
    /// The least p-value that as many differences can have as are not 0.
    pub least: f64,
}

/// The sign-flip permutation test of paired differences, one for each unit (Fisher 1935, section 21). Under the
/// hypothesis that nothing differs, the sign of each difference is a fair coin. `None` where there is no difference.
///
/// Up to 16 differences the test is exact; beyond, [`FLIPS`] sign vectors are drawn and the observed one is counted
/// among them (Phipson and Smyth 2010).
pub fn sign_flip(differences: &[f64], seed: u64) -> Option<SignFlip> {
    if differences.is_empty() {
        return None;
    }
    // The sign of what does not differ is of no matter.
    let rounding = ROUNDING * differences.iter().fold(0.0_f64, |most, difference| most.max(difference.abs()));
    let differences: Vec<f64> = differences.iter().copied().filter(|difference| difference.abs() > rounding).collect();
    let n = differences.len();
    if n == 0 {
        return Some(SignFlip { p: 1.0, least: 1.0 });
    }
    let scale: f64 = differences.iter().map(|difference| difference.abs()).sum();
    let observed = differences.iter().sum::<f64>().abs() - ROUNDING * scale;
    if n <= EXACT {
        let vectors = 1_u32 << n;
        let sum = |signs: u32| -> f64 {
            differences
                .iter()
                .enumerate()
                .map(|(k, difference)| if signs >> k & 1 == 0 { *difference } else { -difference })
                .sum()
        };
        let as_far = (0..vectors).filter(|signs| sum(*signs).abs() >= observed).count();
        return Some(SignFlip { p: as_far as f64 / f64::from(vectors), least: 2.0 / f64::from(vectors) });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut flipped =
        || -> f64 { differences.iter().map(|difference| if rng.random() { *difference } else { -difference }).sum() };
    let as_far = (0..FLIPS).filter(|_| flipped().abs() >= observed).count();
    let least = 1.0 / f64::from(FLIPS + 1);
    Some(SignFlip { p: (as_far as f64 + 1.0) * least, least })
}

/// The p-values of the tests of one table, corrected by Holm (1979): whoever rejects at 5 % then errs in 5 % of tables,
/// whatever the tests have to do with each other. In the order given.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|a, b| p_values[*a].total_cmp(&p_values[*b]));
    let mut corrected = vec![0.0; p_values.len()];
    let mut before: f64 = 0.0;
    for (rank, index) in order.into_iter().enumerate() {
        before = before.max((p_values.len() - rank) as f64 * p_values[index]).min(1.0);
        corrected[index] = before;
    }
    corrected
}

/// The probability that a score of the first method is greater than one of the second, ties half, averaged over tasks
/// (Agarwal et al. 2021). A task weighs as many as the first method has scores in it: one that a resample holds twice
/// counts twice. `None` where a task lacks scores.
pub fn probability_of_improvement(tasks: &[(&[f64], &[f64])]) -> Option<f64> {
    let better = |x: f64, y: f64| {
        if x > y {
            1.0
        } else if x == y {
            0.5
        } else {
            0.0
        }
    };
    let (mut won, mut scores) = (0.0, 0);
    for (first, second) in tasks {
        if first.is_empty() || second.is_empty() {
            return None;
        }
        let sum: f64 = first.iter().flat_map(|x| second.iter().map(move |y| better(*x, *y))).sum();
        won += sum / second.len() as f64;
        scores += first.len();
    }
    (scores > 0).then(|| won / scores as f64)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// All sums of the differences with signs, by recursion: an oracle without bits.
    fn sums(differences: &[f64]) -> Vec<f64> {
        match differences {
            [] => vec![0.0],
            [first, rest @ ..] => sums(rest).into_iter().flat_map(|sum| [sum + first, sum - first]).collect(),
        }
    }

    #[test]
    fn the_least_p_is_what_the_number_of_units_can_give() {
        for (n, least) in [(3, 0.25), (10, 0.002)] {
            let test = sign_flip(&vec![0.4; n], 1).unwrap();
            assert_eq!(test.p, test.least);
            assert!((test.least - least).abs() < 5e-5, "{n} units: {}", test.least);
        }
        assert_eq!(sign_flip(&[0.0; 5], 1), Some(SignFlip { p: 1.0, least: 1.0 }));
        assert_eq!(sign_flip(&[0.3, 0.0, -0.1, 0.0], 1).map(|test| test.least), Some(0.5), "two of them differ");
        assert_eq!(sign_flip(&[], 1), None);
    }

    /// `p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")` of R.
    #[test]
    fn holm_is_what_r_says() {
        let corrected = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (found, expected) in corrected.iter().zip([0.03, 0.06, 0.06, 0.02]) {
            assert!((found - expected).abs() < 1e-12, "{corrected:?}");
        }
        assert_eq!(holm(&[0.9, 0.8]), vec![1.0, 1.0]);
    }

    /// The value of the benchmark's reference (`metrics`).
    #[test]
    fn improvement_by_the_reference() {
        let tasks: [(&[f64], &[f64]); 2] =
            [(&[1.0, 2.0, 1.0, 2.0], &[1.0, 2.0, 3.0]), (&[2.0, 2.0, 1.0, 1.0], &[1.0, 2.0, 3.0])];
        assert!((probability_of_improvement(&tasks).unwrap() - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(probability_of_improvement(&[(&[], &[1.0])]), None);
        let [won, lost]: [[&[f64]; 2]; 2] = [[&[1.0, 1.0], &[0.0, 0.0]], [&[0.0], &[1.0]]];
        let twice = probability_of_improvement(&[(won[0], won[1]), (lost[0], lost[1])]).unwrap();
        assert!((twice - 2.0 / 3.0).abs() < 1e-12, "a task that is drawn twice counts twice");
    }

    /// Where the differences are many, the drawn p-value is near that of the normal limit.
    #[test]
    fn drawn_vectors_agree_with_the_normal_limit() {
        let differences: Vec<f64> = (0..200).map(|k| f64::from(k * 37 % 101) / 50.0 - 0.85).collect();
        let square: f64 = differences.iter().map(|difference| difference * difference).sum();
        let z = differences.iter().sum::<f64>().abs() / square.sqrt();
        let normal = statrs::function::erf::erfc(z / std::f64::consts::SQRT_2);
        let p = sign_flip(&differences, 5).unwrap().p;
        assert!((p - normal).abs() < 0.01, "{p} against {normal}");
    }

    proptest! {
        /// The exact test counts the sign vectors whose sum is as far from 0. It does not care which method comes
        /// first.
        #[test]
        fn the_exact_test_counts_sums(differences in prop::collection::vec(-1.0..1.0_f64, 1..9)) {
            let all = sums(&differences);
            let observed: f64 = differences.iter().sum::<f64>().abs();
            let as_far = all.iter().filter(|sum| sum.abs() >= observed - 1e-9).count();
            let test = sign_flip(&differences, 1).unwrap();
            prop_assert!((test.p - as_far as f64 / all.len() as f64).abs() < 1e-12);
            let turned: Vec<f64> = differences.iter().map(|difference| -difference).collect();
            prop_assert_eq!(sign_flip(&turned, 1).unwrap(), test);
            prop_assert!(test.p >= test.least);
        }

        /// A corrected p-value is no less than it was, and the order stays.
        #[test]
        fn holm_keeps_the_order(p in prop::collection::vec(0.0..1.0_f64, 1..12)) {
            let corrected = holm(&p);
            for (a, left) in p.iter().enumerate() {
                prop_assert!(corrected[a] >= *left && corrected[a] <= 1.0);
                for (b, right) in p.iter().enumerate() {
                    prop_assert!(left > right || corrected[a] <= corrected[b]);
                }
            }
        }
    }
}
