//! How well a number tells two groups apart: the area under the receiver operating characteristic.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// The feature that tells two groups apart best, whichever way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestFeature {
    /// Which one, from 0. The first of several that do equally well.
    pub feature: usize,
    /// Its area under the curve, 0.5 to 1.
    pub area: f64,
    /// The greatest area of the best feature when the groups are drawn anew, over all relabellings.
    pub relabelled: f64,
}

/// Half points of `one` against `other`: 2 where it is greater, 0 where it is less, 1 where they are within the
/// resolution of each other.
fn half_points(one: f64, other: f64, resolution: f64) -> u8 {
    let difference = one - other;
    if difference > resolution {
        2
    } else if difference < -resolution {
        0
    } else {
        1
    }
}

/// The probability that a number of the second group is greater than one of the first. Numbers within the resolution of
/// each other are ties, and count half: at a resolution of 0 this is the statistic of Mann and Whitney (1947). `None`
/// where a group is empty.
pub fn area_under_curve(first: &[f64], second: &[f64], resolution: f64) -> Option<f64> {
    let pairs = first.iter().flat_map(|other| second.iter().map(move |one| (*one, *other)));
    let points: u64 = pairs.map(|(one, other)| u64::from(half_points(one, other, resolution))).sum();
    (!first.is_empty() && !second.is_empty()).then(|| share(points, first.len(), second.len()))
}

fn share(half_points: u64, first: usize, second: usize) -> f64 {
    half_points as f64 / (2 * first * second) as f64
}

/// All states against each other in one feature, in half points, row by row.
struct Tournament {
    states: usize,
    half_points: Vec<u8>,
}

impl Tournament {
    fn new(column: &[f64], resolution: f64) -> Self {
        let row = |one: f64| column.iter().map(move |other| half_points(one, *other, resolution));
        Self { states: column.len(), half_points: column.iter().flat_map(|one| row(*one)).collect() }
    }

    /// The area under the curve of these states against the others, whichever way round.
    fn area(&self, first: &[usize], second: &[usize]) -> f64 {
        let against = |one: &usize| {
            let row = &self.half_points[one * self.states..][..self.states];
            first.iter().map(|other| u64::from(row[*other])).sum::<u64>()
        };
        let area = share(second.iter().map(against).sum(), first.len(), second.len());
        area.max(1.0 - area)
    }
}

/// The feature that tells two groups of states apart best; each feature has its resolution. `relabellings` times the
/// same number of states is drawn at random to be the second group, and the best feature is chosen anew. `None` where a
/// group is empty, and where there is no feature.
pub fn best_feature(
    [first, second]: [&[Vec<f64>]; 2],
    resolutions: &[f64],
    relabellings: usize,
    seed: u64,
) -> Option<BestFeature> {
    if first.is_empty() || second.is_empty() {
        return None;
    }
    let states: Vec<&Vec<f64>> = first.iter().chain(second).collect();
    let features = resolutions.iter().enumerate();
    let tournaments: Vec<Tournament> = features
        .map(|(feature, resolution)| {
            Tournament::new(&states.iter().map(|state| state[feature]).collect::<Vec<f64>>(), *resolution)
        })
        .collect();
    let best = |labels: &[usize]| {
        let (first, second) = labels.split_at(first.len());
        let areas = tournaments.iter().map(|tournament| tournament.area(first, second)).enumerate();
        areas.reduce(|best, next| if next.1 > best.1 { next } else { best })
    };
    let mut labels: Vec<usize> = (0..states.len()).collect();
    let (feature, area) = best(&labels)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut relabelled: f64 = 0.0;
    for _ in 0..relabellings {
        labels.shuffle(&mut rng);
        relabelled = relabelled.max(best(&labels)?.1);
    }
    Some(BestFeature { feature, area, relabelled })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Numbers with many ties.
    fn group() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec((-6_i32..6).prop_map(|value| f64::from(value) / 2.0), 1..20)
    }

    /// The area by ranks: the rank sum of the second group, where equal numbers share the mean of their ranks.
    fn by_ranks(first: &[f64], second: &[f64]) -> f64 {
        let all = || first.iter().chain(second);
        let rank = |value: &f64| {
            let count = |is_so: &dyn Fn(&f64) -> bool| all().filter(|other| is_so(other)).count() as f64;
            count(&|other| other < value) + 0.5 * (count(&|other| other == value) + 1.0)
        };
        let n = second.len() as f64;
        (second.iter().map(rank).sum::<f64>() - 0.5 * n * (n + 1.0)) / (n * first.len() as f64)
    }

    proptest! {
        #[test]
        fn the_area_is_that_of_the_rank_sum(first in group(), second in group()) {
            let area = area_under_curve(&first, &second, 0.0).unwrap();
            prop_assert!((area - by_ranks(&first, &second)).abs() < 1e-12);
            prop_assert!((area_under_curve(&second, &first, 0.0).unwrap() - (1.0 - area)).abs() < 1e-12);
            // What is within the resolution is one and the same.
            prop_assert_eq!(area_under_curve(&first, &second, 10.0), Some(0.5));
            let blurred = |group: &[f64]| group.iter().map(|value| value + 0.01 * value.sin()).collect::<Vec<f64>>();
            prop_assert_eq!(area_under_curve(&blurred(&first), &blurred(&second), 0.1), Some(area));
        }

        #[test]
        fn the_area_knows_the_order_alone(first in group(), second in group()) {
            let bent = |group: &[f64]| group.iter().map(|value| (0.3 * value).exp() - 2.0).collect::<Vec<f64>>();
            let area = |first: &[f64], second: &[f64]| area_under_curve(first, second, 0.0);
            prop_assert_eq!(area(&first, &second), area(&bent(&first), &bent(&second)));
            prop_assert_eq!(area(&first, &first), Some(0.5));
        }

        #[test]
        fn the_best_feature_is_the_best(first in group(), second in group(), seed in 0_u64..9) {
            let states = |group: &[f64]| group.iter().map(|value| vec![1.0, value % 1.0, *value]).collect::<Vec<_>>();
            let found = best_feature([&states(&first), &states(&second)], &[0.0; 3], 20, seed).unwrap();
            let of = |feature: usize| {
                let column = |group: &[f64]| states(group).iter().map(|state| state[feature]).collect::<Vec<f64>>();
                let area = area_under_curve(&column(&first), &column(&second), 0.0).unwrap();
                area.max(1.0 - area)
            };
            prop_assert!((0..3).all(|feature| of(feature) <= found.area));
            prop_assert!((of(found.feature) - found.area).abs() < 1e-12);
            prop_assert!((0.5..=1.0).contains(&found.relabelled));
        }
    }

    #[test]
    fn what_is_apart_is_told_and_what_is_not_is_not() {
        let states = |from: i32| (from..from + 50).map(|value| vec![f64::from(value % 7), f64::from(value)]).collect();
        let (low, high): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (states(0), states(50));
        let found = best_feature([&low, &high], &[0.0, 0.0], 1000, 1).unwrap();
        assert!(found.feature == 1 && found.area == 1.0 && found.relabelled < 0.8, "{found:?}");
        let same = best_feature([&low, &low], &[0.0, 0.0], 1000, 1).unwrap();
        assert!(same.area == 0.5 && same.relabelled > 0.6, "{same:?}");
        assert_eq!(best_feature([&low, &[]], &[0.0, 0.0], 9, 1), None);
        assert_eq!(area_under_curve(&[], &[1.0], 0.0), None);
    }
}
