//! The worlds in which two ways of doing a thing are right, told apart by what is observed (decisions D20 and D23).
//!
//! A classifier that is fitted to a handful of states learns whatever differs between them, and most of that is where
//! things happen to lie. This rule is blunt on purpose: one feature tells two ways apart only where the states of the
//! one lie clearly beyond all states of the other, on one side. So a feature that told by accident drops out with the
//! first state that contradicts it.

use crate::state::State;

/// A state that lies beyond others by this share of the feature's scale or less is among them.
pub const MARGIN: f64 = 0.15;

/// The interval that a feature takes in some states.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// The range of a feature in these states, of which there is at least one; in units of its scale.
    fn of(states: &[&State], feature: usize, scale: f64) -> Self {
        let values = states.iter().map(|state| state.values()[feature] / scale);
        values.fold(Self { low: f64::INFINITY, high: f64::NEG_INFINITY }, |range, value| Self {
            low: range.low.min(value),
            high: range.high.max(value),
        })
    }

    /// The edges that two ranges turn to each other, this one's first; `None` where they overlap.
    fn gap(self, other: Self) -> Option<(f64, f64)> {
        if other.low > self.high {
            Some((self.high, other.low))
        } else if self.low > other.high {
            Some((self.low, other.high))
        } else {
            None
        }
    }

    /// By how many times as much as it must the other range lies beyond this one, on one side: the gap over this one's
    /// own width, or over [`MARGIN`] where that is more. It tells where that is above 1.
    fn clearness(self, other: Self) -> f64 {
        let gap = self.gap(other).map_or(0.0, |(own, other)| (other - own).abs());
        gap / (self.high - self.low).max(MARGIN)
    }
}

/// Whether `state` belongs to the world of `own` rather than to that of `other`: some feature tells the two apart, and
/// by those that do the state is on the side of `own`. Each has a vote, from the one edge of the gap to the other, that
/// counts by the square of how clearly it tells: what tells by accident does so barely. `scales` has one entry for each
/// feature. False where nothing tells them apart, or where one of the two has no state.
pub fn is_in_own_world(state: &State, own: &[&State], other: &[&State], scales: &[f64]) -> bool {
    if own.is_empty() || other.is_empty() {
        return false;
    }
    let mut votes = 0.0;
    for (feature, scale) in scales.iter().enumerate() {
        let (here, there) = (Range::of(own, feature, *scale), Range::of(other, feature, *scale));
        let clearness = here.clearness(there);
        if clearness > 1.0
            && let Some((here, there)) = here.gap(there)
        {
            let share = (state.values()[feature] / scale - here) / (there - here);
            votes += clearness * clearness * (1.0 - 2.0 * share.clamp(0.0, 1.0));
        }
    }
    votes > 0.0
}

/// Whether some feature tells the states of `own` from those of `other`. False where one of the two has no state.
pub fn are_told_apart(own: &[&State], other: &[&State], scales: &[f64]) -> bool {
    let tells = |(feature, scale): (usize, &f64)| {
        Range::of(own, feature, *scale).clearness(Range::of(other, feature, *scale)) > 1.0
    };
    !own.is_empty() && !other.is_empty() && scales.iter().enumerate().any(tells)
}

/// Whether some feature of `state` lies clearly beyond all of `own`. False where `own` has no state.
pub fn is_unlike(state: &State, own: &[&State], scales: &[f64]) -> bool {
    are_told_apart(own, &[state], scales)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn states(values: &[[f64; 2]]) -> Vec<State> {
        values.iter().map(|values| State::new(values.to_vec())).collect()
    }

    /// Whether a state is in the world of the first states rather than in that of the second; scales of 1 and 10.
    fn own(state: [f64; 2], own: &[[f64; 2]], other: &[[f64; 2]]) -> bool {
        let (own, other) = (states(own), states(other));
        let (own, other): (Vec<&State>, Vec<&State>) = (own.iter().collect(), other.iter().collect());
        is_in_own_world(&State::new(state.to_vec()), &own, &other, &[1.0, 10.0])
    }

    #[test]
    fn a_feature_tells_where_all_states_of_one_lie_clearly_beyond_those_of_the_other() {
        // The first feature: 0 to 0.2 here, 0.5 there. The second is the same everywhere.
        let here = [[0.0, 0.0], [0.2, 1.0]];
        assert!(own([0.1, 0.5], &here, &[[0.5, 0.5]]));
        assert!(own([0.3, 9.0], &here, &[[0.5, 0.5]]), "the second feature does not tell, however far it is");
        assert!(!own([0.45, 0.5], &here, &[[0.5, 0.5]]), "nearer to the other");
        assert!(!own([0.1, 0.5], &here, &[[0.39, 0.5]]), "beyond, but not by more than the range");
        assert!(!own([0.1, 0.5], &here, &[[0.5, 0.5], [-0.5, 0.5]]), "on both sides");
        assert!(!own([0.0, 0.5], &[[0.0, 0.0]], &[[0.14, 0.0]]), "one state has no range, and the margin holds");
        assert!(own([0.0, 0.5], &[[0.0, 0.0]], &[[0.16, 0.0]]));
        assert!(!own([0.0, 0.0], &[], &[[1.0, 1.0]]) && !own([0.0, 0.0], &[[0.0, 0.0]], &[]), "nothing is known");
    }

    #[test]
    fn what_tells_by_accident_does_not_outvote_what_matters() {
        // The first feature is 0 here and 1 there. The second happens to lie a little apart, 0 to 2 here and 5 there.
        let (here, there) = ([[0.0, 0.0], [0.0, 2.0]], [[1.0, 5.0]]);
        assert!(own([0.0, 1.0], &here, &there));
        assert!(own([0.0, 9.0], &here, &there), "the second says there, and barely tells");
        assert!(!own([1.0, 1.0], &here, &there), "the first says there");
        assert!(!own([0.0, 9.0], &[[0.0, 0.0]], &[[0.1, 5.0]]), "where the second alone tells, it decides");
    }

    #[test]
    fn a_scale_is_the_unit_of_its_feature() {
        assert!(own([0.0, 0.0], &[[0.0, 0.0]], &[[0.0, 1.6]]), "1.6 of 10 is beyond the margin");
        assert!(!own([0.0, 0.0], &[[0.0, 0.0]], &[[0.0, 1.4]]));
    }

    #[test]
    fn states_are_told_apart_by_one_feature() {
        let told = |own: &[[f64; 2]], other: &[[f64; 2]]| {
            let (own, other) = (states(own), states(other));
            let (own, other): (Vec<&State>, Vec<&State>) = (own.iter().collect(), other.iter().collect());
            are_told_apart(&own, &other, &[1.0, 10.0])
        };
        let here = [[0.0, 0.0], [0.2, 1.0]];
        assert!(told(&here, &[[0.5, 0.5]]) && told(&here, &[[0.5, 0.5], [0.9, -9.0]]));
        assert!(!told(&here, &[[0.5, 0.5], [-0.5, 0.5]]), "on both sides");
        assert!(!told(&here, &[[0.3, 0.5]]), "not clearly");
        assert!(!told(&[], &[[0.5, 0.5]]) && !told(&here, &[]), "nothing is known");
    }

    #[test]
    fn what_lies_beyond_all_is_unlike_them() {
        let own = states(&[[0.0, 0.0], [0.2, 0.0]]);
        let own: Vec<&State> = own.iter().collect();
        let is = |state: [f64; 2]| is_unlike(&State::new(state.to_vec()), &own, &[1.0, 10.0]);
        assert!(is([0.41, 0.0]) && is([-0.21, 0.0]) && is([0.1, 1.6]));
        assert!(!is([0.39, 0.0]) && !is([0.1, 1.4]));
        assert!(!is_unlike(own[0], &[], &[1.0, 10.0]), "nothing is known");
    }
}
