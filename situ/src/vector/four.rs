//! Four numbers at once.

use core::ops::{Add, AddAssign, Div, Mul, Sub};

use pulp::{Simd, cast, f64x4, m64x4, u64x4};

/// The numbers of a [`Four`].
pub(crate) const LANES: usize = 4;

/// The instructions for four numbers at once.
pub(crate) trait Wide: Simd<f64s = f64x4, m64s = m64x4, u64s = u64x4> {}

impl<S: Simd<f64s = f64x4, m64s = m64x4, u64s = u64x4>> Wide for S {}

/// Four numbers, and the instructions for them.
#[derive(Clone, Copy)]
pub(crate) struct Four<S>(S, f64x4);

impl<S: Wide> Four<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, numbers: [f64; LANES]) -> Self {
        Self(simd, cast(numbers))
    }

    /// Several fours.
    #[inline(always)]
    pub(crate) fn all<const N: usize>(simd: S, numbers: &[[f64; LANES]; N]) -> [Self; N] {
        // This is no closure, because a closure would not be inlined.
        let mut fours = [Self::splat(simd, 0.0); N];
        for (four, numbers) in fours.iter_mut().zip(numbers) {
            *four = Self::new(simd, *numbers);
        }
        fours
    }

    #[inline(always)]
    pub(crate) fn splat(simd: S, number: f64) -> Self {
        Self(simd, simd.splat_f64s(number))
    }

    #[inline(always)]
    pub(crate) fn numbers(self) -> [f64; LANES] {
        cast(self.1)
    }

    /// The sum of the four.
    #[inline(always)]
    pub(crate) fn joined(self) -> f64 {
        let [a, b, c, d] = self.numbers();
        (a + c) + (b + d)
    }

    /// The sums of several fours.
    #[inline(always)]
    pub(crate) fn all_joined<const N: usize>(fours: [Self; N]) -> [f64; N] {
        let mut sums = [0.0; N];
        for (sum, four) in sums.iter_mut().zip(fours) {
            *sum = four.joined();
        }
        sums
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0, self.0.abs_f64s(self.1))
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f64s(self.1, other.1))
    }

    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0, self.0.min_f64s(self.1, other.1))
    }

    /// These magnitudes, which are not negative, with the signs of others.
    #[inline(always)]
    pub(crate) fn with_signs_of(self, signs: Self) -> Self {
        let simd = self.0;
        let sign = simd.and_f64s(signs.1, simd.splat_f64s(-0.0));
        Self(simd, simd.or_f64s(self.1, sign))
    }

    /// For each number: `first` if it is below `bound`, else `second`.
    #[inline(always)]
    pub(crate) fn below(self, bound: Self, first: Self, second: Self) -> Self {
        let mask = self.0.less_than_f64s(self.1, bound.1);
        Self(self.0, self.0.select_f64s(mask, first.1, second.1))
    }

    /// Whether one of them is 0.
    #[inline(always)]
    pub(crate) fn has_zero(self) -> bool {
        let simd = self.0;
        simd.first_true_m64s(simd.equal_f64s(self.1, simd.splat_f64s(0.0))) < LANES
    }

    /// Adds `added` to the bits, taken as integers, shifts them up by `BITS`, and takes them as numbers again.
    #[inline(always)]
    pub(crate) fn shifted_bits<const BITS: i32>(self, added: u64) -> Self {
        let mut bits: [u64; LANES] = cast(self.1);
        for bits in &mut bits {
            *bits = bits.wrapping_add(added) << BITS;
        }
        Self(self.0, cast(bits))
    }
}

/// c₀ + c₁ x + …, with the coefficients in fours. No step waits for the one before it, as in Horner's rule.
#[inline(always)]
pub(crate) fn polynomial<S: Wide, const N: usize>(x: Four<S>, coefficients: &[[f64; LANES]; N]) -> Four<S> {
    let squared = x * x;
    let to_the_fourth = squared * squared;
    let mut sum = four_terms(x, squared, &coefficients[N - 1]);
    for coefficients in coefficients[..N - 1].iter().rev() {
        sum = four_terms(x, squared, coefficients) + sum * to_the_fourth;
    }
    sum
}

#[inline(always)]
fn four_terms<S: Wide>(x: Four<S>, squared: Four<S>, [a, b, c, d]: &[f64; LANES]) -> Four<S> {
    (x * *b + *a) + (x * *d + *c) * squared
}

/// An operator on two fours, and on a four and a number.
macro_rules! operator {
    ($Operator:ident, $method:ident, $instruction:ident) => {
        impl<S: Wide> $Operator for Four<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$instruction(self.1, other.1))
            }
        }

        impl<S: Wide> $Operator<f64> for Four<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::splat(self.0, other))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Wide> AddAssign for Four<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
