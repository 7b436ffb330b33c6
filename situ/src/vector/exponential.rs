//! e to the x by additions, products and shifts alone: the same bits everywhere, and many at once.

use core::f64::consts::LOG2_E;

/// Where the exponential is less than the least normal number, it is taken for 0.
const LEAST: f64 = -708.0;
/// And beyond this for ∞, a hair early.
const GREATEST: f64 = 709.4;
/// Added, it leaves an integer in the last bits: 1.5 · 2⁵².
const SHIFT: f64 = 6_755_399_441_055_744.0;
/// log 2 in two parts: the first has so few digits that its products with exponents are exact.
const LOG_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// The exponent of 1 as it is stored, and the bits below an exponent.
const BIAS: u64 = 1023;
const MANTISSA_BITS: u32 = 52;
/// Terms of the series of e^r, |r| ≤ ½ log 2: the next is under the rounding error.
const TERMS: usize = 14;
/// 1/n!.
const INVERSE_FACTORIALS: [f64; TERMS] = inverse_factorials();

const fn inverse_factorials() -> [f64; TERMS] {
    let mut terms = [1.0; TERMS];
    let (mut n, mut factorial) = (1, 1.0);
    while n < TERMS {
        factorial *= n as f64;
        terms[n] = 1.0 / factorial;
        n += 1;
    }
    terms
}

/// e^`x` to two units in the last place; 0 below −708, where that is next to nothing. Infinite above 709.4.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    let within = x.clamp(LEAST, GREATEST);
    // e^x = 2^n e^r.
    let shifted = within * LOG2_E + SHIFT;
    let n = shifted - SHIFT;
    let r = (within - n * LOG_2[0]) - n * LOG_2[1];
    let mut series = INVERSE_FACTORIALS[TERMS - 1];
    for coefficient in INVERSE_FACTORIALS[..TERMS - 1].iter().rev() {
        series = series * r + coefficient;
    }
    let power = f64::from_bits(shifted.to_bits().wrapping_add(BIAS) << MANTISSA_BITS);
    let value = series * power;
    let value = if x < LEAST { 0.0 } else { value };
    if x > GREATEST { f64::INFINITY } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::widest;

    /// Against `libm`, over all magnitudes.
    #[test]
    fn two_units_in_the_last_place() {
        let mut arguments: Vec<f64> = (-70_800..70_930).map(|step| f64::from(step) * 0.01 + 1.0 / 3000.0).collect();
        arguments.extend((0..4000).flat_map(|step| {
            let small = libm::exp(-0.1 * f64::from(step));
            [small, -small].map(|x| x.clamp(LEAST, GREATEST))
        }));
        let mut worst: f64 = 0.0;
        for x in arguments {
            let expected = libm::exp(x);
            worst = worst.max((exp(x) - expected).abs() / (expected * f64::EPSILON));
        }
        assert!(worst <= 2.0, "{worst} units");
    }

    #[test]
    fn the_ends() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-0.0), 1.0);
        assert_eq!(exp(f64::NEG_INFINITY), 0.0);
        assert_eq!(exp(-708.1), 0.0);
        assert_eq!(exp(f64::INFINITY), f64::INFINITY);
        assert_eq!(exp(1000.0), f64::INFINITY);
        assert!(exp(f64::NAN).is_nan());
    }

    /// One at a time and many at once are the same bits.
    #[test]
    fn the_same_bits_on_the_widest_vectors() {
        #[inline(always)]
        fn all(numbers: &mut [f64]) {
            numbers.iter_mut().for_each(|x| *x = exp(*x));
        }
        let one_by_one: Vec<f64> = (0..5000).map(|step| 0.3 * f64::from(step) - 750.0).collect();
        let mut together = one_by_one.clone();
        widest(all, &mut together[..]);
        for (x, found) in one_by_one.iter().zip(&together) {
            assert_eq!(exp(*x).to_bits(), found.to_bits(), "{x}");
        }
    }
}
