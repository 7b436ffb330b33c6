//! How a correction moves weights.

/// The published rule that moves the weights.
///
/// With a step of 1 and no weight at its limit, [`Rule::All`] and [`Rule::Coactive`] are one rule: Bajcsy et al. follow
/// the same gradient of the same linear cost as Jain et al., in steps of their choice, and clip. Both have a name here
/// because they were published separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Jain et al. 2013, the preference perceptron: [`coactive`].
    Coactive,
    /// Bajcsy et al. 2018, moving every weight: [`Physical`].
    All,
    /// Bajcsy et al. 2018, moving the one weight that the correction changes most: [`Physical`].
    OneAtATime,
}

/// Jain et al. 2013: `w ← w + φ(ȳ) − φ(y)`. These are the weights of a *utility* `wᵀφ`; `ȳ` is what was shown and `y`
/// what was planned.
///
/// If what is shown is optimal under true weights `w*`, and `‖φ‖ ≤ R`, the average regret of T plans is at most
/// `2R‖w*‖/√T`.
pub fn coactive<const N: usize>(weights: &mut [f64; N], shown: &[f64; N], planned: &[f64; N]) {
    for feature in 0..N {
        weights[feature] += shown[feature] - planned[feature];
    }
}

/// Bajcsy et al. 2018: `θ ← θ − g ΔΦ` with `ΔΦ = Φ(ξ_D) − Φ(ξ_R)`. These are the weights of a *cost* `θᵀΦ`, clipped at
/// `limit` ranges to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physical<'a, const N: usize> {
    /// The range of each feature, in its unit.
    pub ranges: &'a [f64; N],
    /// The step g.
    pub gain: f64,
    /// Where a weight is clipped, in ranges.
    pub limit: f64,
    /// Whether only `i* = argmax |ΔΦ_i / range_i|` moves, the first of those that tie. Otherwise all weights move.
    pub one_at_a_time: bool,
}

impl<const N: usize> Physical<'_, N> {
    /// Moves the weights by a correction: `shown` is Φ(ξ_D), `planned` is Φ(ξ_R).
    pub fn correct(&self, weights: &mut [f64; N], shown: &[f64; N], planned: &[f64; N]) {
        let difference = |feature: usize| shown[feature] - planned[feature];
        let share = |feature: usize| (difference(feature) / self.ranges[feature]).abs();
        let mut most = 0;
        for feature in 1..N {
            if share(feature) > share(most) {
                most = feature;
            }
        }
        for (feature, weight) in weights.iter_mut().enumerate() {
            if !self.one_at_a_time || feature == most {
                let bound = self.limit * self.ranges[feature];
                *weight = (*weight - self.gain * difference(feature)).max(-bound).min(bound);
            }
        }
    }
}
