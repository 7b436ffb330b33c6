//! e^x by additions, products and shifts alone: the same bits everywhere, and several at once.

use core::f64::consts::LOG2_E;

use super::four::{Four, Wide, polynomial};

/// Below this the exponential is less than the least normal number, and 0 is returned.
const LEAST: f64 = -708.0;
/// Above this ∞ is returned, slightly early.
const GREATEST: f64 = 709.4;
/// Adding this leaves an integer in the last bits: 1.5 · 2⁵².
const SHIFT: f64 = 6_755_399_441_055_744.0;
/// log 2 in two parts. The first part has so few digits that its products with exponents are exact.
const LOG_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// The stored exponent of 1, and the number of bits below the exponent.
const BIAS: u64 = 1023;
const MANTISSA_BITS: i32 = 52;
/// e^r for |r| ≤ ½ log 2, as a polynomial. By Chebyshev interpolation (mpmath 1.4.1, `chebyfit` with 12 terms); the
/// error is at most 3·10⁻¹⁸.
const EXPONENTIAL: [[f64; 4]; 3] = [
    [1.0, 1.0, 0.500_000_000_000_001_9, 0.166_666_666_666_666_8],
    [0.041_666_666_666_488_09, 0.008_333_333_333_319_601, 0.001_388_888_895_231_513_7, 0.000_198_412_698_900_473_92],
    [2.480_148_548_193_976_3e-5, 2.755_724_091_828_004_7e-6, 2.763_263_978_288_121e-7, 2.511_003_771_657_357_8e-8],
];

/// e^x to two units in the last place. It is 0 below −708 and infinite above 709.4.
#[inline(always)]
pub(crate) fn exp<S: Wide>(simd: S, x: Four<S>) -> Four<S> {
    let within = x.max(Four::splat(simd, LEAST)).min(Four::splat(simd, GREATEST));
    // e^x = 2^n e^r.
    let shifted = within * LOG2_E + SHIFT;
    let n = shifted - SHIFT;
    let r = (within - n * LOG_2[0]) - n * LOG_2[1];
    let value = polynomial(r, &EXPONENTIAL) * shifted.shifted_bits::<MANTISSA_BITS>(BIAS);
    let value = x.below(Four::splat(simd, LEAST), Four::splat(simd, 0.0), value);
    Four::splat(simd, GREATEST).below(x, Four::splat(simd, f64::INFINITY), value)
}

#[cfg(test)]
mod tests {
    use pulp::Scalar256b;

    use super::*;

    fn one(x: f64) -> f64 {
        exp(Scalar256b, Four::splat(Scalar256b, x)).numbers()[0]
    }

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
            worst = worst.max((one(x) - expected).abs() / (expected * f64::EPSILON));
        }
        assert!(worst <= 2.0, "{worst} units");
    }

    #[test]
    fn the_ends() {
        assert_eq!(one(0.0), 1.0);
        assert_eq!(one(-0.0), 1.0);
        assert_eq!(one(f64::NEG_INFINITY), 0.0);
        assert_eq!(one(-708.1), 0.0);
        assert_eq!(one(f64::INFINITY), f64::INFINITY);
        assert_eq!(one(1000.0), f64::INFINITY);
    }
}
