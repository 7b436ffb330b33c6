//! How often a teacher erred in each way.

use std::ops::AddAssign;

use crate::profile::Way;

/// How often something happened, and how often it could have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// It happened.
    pub happened: u32,
    /// It could have.
    pub chances: u32,
}

impl Count {
    /// The two-sided exact binomial tail: the probability, at this rate, to be at least as far off as what happened.
    /// It is twice the smaller tail, at most 1. If it is below α, the observed rate is outside the 1 − α interval
    /// about the configured one.
    pub fn tails(&self, rate: f64) -> f64 {
        if rate <= 0.0 || rate >= 1.0 {
            let certain = if rate <= 0.0 { 0 } else { self.chances };
            return if self.happened == certain { 1.0 } else { 0.0 };
        }
        let n = f64::from(self.chances);
        let log_probability = |k: f64| {
            libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0)
                + k * libm::log(rate)
                + (n - k) * libm::log1p(-rate)
        };
        let sum = |from: u32, to: u32| (from..=to).map(|k| libm::exp(log_probability(f64::from(k)))).sum::<f64>();
        (2.0 * sum(0, self.happened).min(sum(self.happened, self.chances))).min(1.0)
    }
}

/// How often each way of erring was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally([Count; Way::ALL.len()]);

impl Tally {
    /// How often this way was taken.
    pub const fn of(&self, way: Way) -> Count {
        self.0[way as usize]
    }

    /// One more chance, taken or not. Returns whether it was taken.
    pub fn count(&mut self, way: Way, happened: bool) -> bool {
        let count = &mut self.0[way as usize];
        count.chances += 1;
        count.happened += u32::from(happened);
        happened
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            count.happened += more.happened;
            count.chances += more.chances;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_binomial_distribution() {
        let tails = |happened, chances, rate| Count { happened, chances }.tails(rate);
        // Ten tosses of a coin, counted by hand: one head or none, 11 of 1024; twice that.
        assert!((tails(1, 10, 0.5) - 22.0 / 1024.0).abs() < 1e-12);
        assert!((tails(9, 10, 0.5) - 22.0 / 1024.0).abs() < 1e-12);
        assert_eq!(tails(5, 10, 0.5), 1.0);
        // Three successes of four at 1/3: 8/81 + 1/81, twice.
        assert!((tails(3, 4, 1.0 / 3.0) - 18.0 / 81.0).abs() < 1e-12);
        assert_eq!([tails(0, 10, 0.0), tails(1, 10, 0.0), tails(10, 10, 1.0), tails(9, 10, 1.0)], [1.0, 0.0, 1.0, 0.0]);
        assert_eq!(tails(0, 0, 0.3), 1.0, "nothing was seen, and nothing speaks against it");
    }
}
