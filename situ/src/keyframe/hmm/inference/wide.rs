//! Numbers of any magnitude, for the recursions over whole sequences. A probability of e^−10000 is common there, and a
//! recursion in logarithms would spend its time in `exp` and `log`.

/// The mantissa ranges over ± this many doublings. That leaves room for the product of two mantissas.
const HALF_RANGE: i32 = 256;
/// 2⁻²⁵⁶, the least mantissa.
const LEAST: f64 = power_of_two(-HALF_RANGE);
/// 2²⁵⁶, which every mantissa is below.
const GREATEST: f64 = power_of_two(HALF_RANGE);
/// 2⁵¹², one step of the exponent, and its inverse.
const STEP: f64 = power_of_two(2 * HALF_RANGE);
const STEP_DOWN: f64 = power_of_two(-2 * HALF_RANGE);
/// log 2⁵¹² in two parts. The first part has so few digits that its products with exponents up to 2²⁰ are exact.
const LOG_STEP: f64 = 512.0 * 6.931_471_803_691_238e-1;
const LOG_STEP_REST: f64 = 512.0 * 1.908_214_929_270_587_7e-10;

const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// A number that is not negative: `mantissa` · 2^(512 · `exponent`), with the mantissa in [2⁻²⁵⁶, 2²⁵⁶) and an integer
/// as the exponent.
///
/// Its relative error is that of an `f64`, for numbers of any size. A sum ignores a term below 2⁻²⁵⁶ of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wide {
    mantissa: f64,
    /// −∞ for 0.
    exponent: f64,
}

impl Wide {
    pub(super) const ZERO: Self = Self { mantissa: 0.0, exponent: f64::NEG_INFINITY };

    /// The number `value`, which is at least 0 and finite.
    pub(super) fn new(value: f64) -> Self {
        Self { mantissa: value, exponent: 0.0 }.normalised()
    }

    /// e^`log`.
    pub(super) fn exp(log: f64) -> Self {
        if log == f64::NEG_INFINITY {
            return Self::ZERO;
        }
        let exponent = libm::rint(log / LOG_STEP);
        let mantissa = libm::exp((log - exponent * LOG_STEP) - exponent * LOG_STEP_REST);
        Self { mantissa, exponent }
    }

    /// The natural logarithm; −∞ of 0.
    pub(super) fn log(self) -> f64 {
        if self.mantissa == 0.0 {
            return f64::NEG_INFINITY;
        }
        libm::log(self.mantissa) + self.exponent * LOG_STEP_REST + self.exponent * LOG_STEP
    }

    /// The product with another.
    #[inline]
    pub(super) fn times(self, other: Self) -> Self {
        self.times_unnormalised(other).normalised()
    }

    /// The product with another, whose mantissa may be out of range: it can be added, or multiplied once more.
    #[inline]
    pub(super) fn times_unnormalised(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent }
    }

    /// The sum with another. Each may be a product of [`Wide::times_unnormalised`] with a probability.
    #[inline]
    pub(super) fn plus(self, other: Self) -> Self {
        if self.exponent == other.exponent {
            Self { mantissa: self.mantissa + other.mantissa, ..self }
        } else if self.exponent > other.exponent {
            Self { mantissa: self.mantissa + shifted(other.mantissa, self.exponent - other.exponent), ..self }
        } else {
            Self { mantissa: other.mantissa + shifted(self.mantissa, other.exponent - self.exponent), ..other }
        }
    }

    /// The same number, with its mantissa in range.
    #[inline]
    pub(super) fn normalised(self) -> Self {
        let Self { mut mantissa, mut exponent } = self;
        if mantissa >= GREATEST {
            mantissa *= STEP_DOWN;
            exponent += 1.0;
        }
        while mantissa < LEAST {
            if mantissa == 0.0 {
                return Self::ZERO;
            }
            mantissa *= STEP;
            exponent -= 1.0;
        }
        Self { mantissa, exponent }
    }

    /// The inverse of this, which must not be 0.
    pub(super) fn inverse(self) -> Self {
        Self { mantissa: 1.0 / self.mantissa, exponent: -self.exponent }.normalised()
    }

    /// As a plain float: 0 if it is below about 2⁻²⁵⁶, infinite if it is above 2⁷⁶⁸.
    #[inline]
    pub(super) fn value(self) -> f64 {
        if self.exponent == 0.0 {
            self.mantissa
        } else if self.exponent < 0.0 {
            shifted(self.mantissa, -self.exponent)
        } else if self.exponent == 1.0 {
            self.mantissa * STEP
        } else {
            f64::INFINITY
        }
    }
}

/// A mantissa, so many steps of the exponent lower. After more than one step nothing is left that counts.
#[inline]
fn shifted(mantissa: f64, steps: f64) -> f64 {
    if steps == 1.0 { mantissa * STEP_DOWN } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 1e-13 * expected.abs().max(1.0)
    }

    #[test]
    fn a_number_is_what_its_logarithm_says() {
        for log in [0.0, 1.0, -1.0, 177.3, 177.5, -177.5, -354.9, 700.0, -745.0, -1e4, 1e4, -3e7] {
            assert!(close(Wide::exp(log).log(), log), "{log}: {}", Wide::exp(log).log());
        }
        assert_eq!(Wide::exp(f64::NEG_INFINITY), Wide::ZERO);
        assert_eq!(Wide::ZERO.log(), f64::NEG_INFINITY);
    }

    #[test]
    fn products_and_sums_are_those_of_the_logarithms() {
        let logs = [0.0, -0.3, -100.0, 176.0, -177.0, -300.0, -354.0, -360.0, -2000.0, 900.0];
        for left in logs {
            for right in logs {
                let product = Wide::exp(left).times(Wide::exp(right));
                assert!(close(product.log(), left + right), "{left} · {right}");
                let sum = Wide::exp(left).plus(Wide::exp(right).times_unnormalised(Wide::new(0.25))).normalised();
                let (high, low) = (left.max(right - libm::log(4.0)), left.min(right - libm::log(4.0)));
                let expected = high + libm::log1p(libm::exp(low - high));
                assert!(close(sum.log(), expected), "{left} + {right}/4: {} for {expected}", sum.log());
            }
        }
    }

    #[test]
    fn plain_numbers_come_back() {
        for value in [0.0, 1.0, 0.3, 1e-60, 1e-80, 1e100, 1e-300, f64::MIN_POSITIVE / 1024.0] {
            let wide = Wide::new(value);
            let expected = if value < 1e-230 { 0.0 } else { value };
            assert!(close(wide.value(), expected) && (wide.value() > 0.0) == (expected > 0.0), "{value}");
            assert!(value == 0.0 || close(wide.log(), libm::log(value)), "{value}");
            if value > 0.0 {
                assert!(close(wide.times_unnormalised(wide.inverse()).value(), 1.0));
            }
        }
    }
}
