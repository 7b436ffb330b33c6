//! log(1 + x) by additions, products and one division: the same bits everywhere, and several at once.

use super::four::{Four, Wide, polynomial};

/// 2/(2n + 1): the coefficients of 2 artanh(s)/s in s², for s ≤ ⅓, down to the rounding error.
const COEFFICIENTS: [[f64; 4]; 4] = coefficients();

const fn coefficients() -> [[f64; 4]; 4] {
    let mut terms = [[0.0; 4]; 4];
    let mut n = 0;
    while n < 16 {
        terms[n / 4][n % 4] = 2.0 / (2 * n + 1) as f64;
        n += 1;
    }
    terms
}

/// log(1 + x) for x from 0 to 1, to three units in the last place.
#[inline(always)]
pub(crate) fn log_1p<S: Wide>(x: Four<S>) -> Four<S> {
    // log(1 + x) = 2 artanh s.
    let s = x / (x + 2.0);
    polynomial(s * s, &COEFFICIENTS) * s
}

#[cfg(test)]
mod tests {
    use pulp::Scalar256b;

    use super::*;

    fn one(x: f64) -> f64 {
        log_1p(Four::splat(Scalar256b, x)).numbers()[0]
    }

    /// Against `libm`, over all magnitudes.
    #[test]
    fn three_units_in_the_last_place() {
        let mut arguments: Vec<f64> = (0..=40_000).map(|step| f64::from(step) / 40_000.0).collect();
        arguments.extend((0..7000).map(|step| libm::exp(-0.1 * f64::from(step))));
        let mut worst: f64 = 0.0;
        for x in arguments.into_iter().filter(|x| *x > 0.0) {
            let expected = libm::log1p(x);
            worst = worst.max((one(x) - expected).abs() / (expected * f64::EPSILON));
        }
        assert!(worst <= 3.0, "{worst} units");
    }

    #[test]
    fn the_ends() {
        assert_eq!(one(0.0), 0.0);
        assert_eq!(one(f64::MIN_POSITIVE), f64::MIN_POSITIVE);
        assert!((one(1.0) - core::f64::consts::LN_2).abs() <= f64::EPSILON);
    }
}
