//! How a correction moves weights.

/// Which published rule moves the weights.
///
/// With a step of 1 and no weight at its limit, [`Rule::All`] and [`Rule::Coactive`] are one rule: Bajcsy et al. follow
/// the same gradient of the same linear cost as Jain et al., in steps of their choice, and clip. The names keep apart
/// what was published apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Jain et al. 2013, the preference perceptron: [`coactive`].
    Coactive,
    /// Bajcsy et al. 2018, every weight: [`physical`].
    All,
    /// Bajcsy et al. 2018, the one weight that the correction is most about: [`physical`].
    OneAtATime,
}

/// Jain et al. 2013: `w ← w + φ(ȳ) − φ(y)`, the weights of a *utility* `wᵀφ`, `ȳ` what was shown and `y` what was
/// planned.
///
/// Where what is shown is optimal under true weights `w*` and `‖φ‖ ≤ R`, the average regret of T plans is at most
/// `2R‖w*‖/√T`.
pub fn coactive<const N: usize>(weights: &mut [f64; N], shown: &[f64; N], planned: &[f64; N]) {
    for feature in 0..N {
        weights[feature] += shown[feature] - planned[feature];
    }
}

/// Bajcsy et al. 2018: `θ ← θ − g ΔΦ` with `ΔΦ = Φ(ξ_D) − Φ(ξ_R)`, the weights of a *cost* `θᵀΦ`, clipped at `limit`
/// ranges to either side.
///
/// With [`Rule::OneAtATime`] only `i* = argmax |ΔΦ_i / range_i|` moves, the first of those that tie; with the other
/// rules all move.
pub fn physical<const N: usize>(
    weights: &mut [f64; N],
    shown: &[f64; N],
    planned: &[f64; N],
    ranges: &[f64; N],
    gain: f64,
    limit: f64,
    rule: Rule,
) {
    let difference = |feature: usize| shown[feature] - planned[feature];
    let mut most = 0;
    for feature in 1..N {
        if (difference(feature) / ranges[feature]).abs() > (difference(most) / ranges[most]).abs() {
            most = feature;
        }
    }
    for feature in 0..N {
        if rule != Rule::OneAtATime || feature == most {
            let bound = limit * ranges[feature];
            weights[feature] = (weights[feature] - gain * difference(feature)).max(-bound).min(bound);
        }
    }
}
