//! Statistics over runs of many tasks, with an interval by units and one by variations.
//!
//! Runs of one family and seed share the originals, so they are one *unit*; runs of one variation share the task. An
//! interval over runs, or over their rollouts, would take them for independent. The interval by units draws units
//! within each family; where a family has one unit alone, units of all families are drawn together. The one by
//! variations draws variations. Where there is one unit alone, or one variation, there is no such interval.

use std::collections::BTreeMap;

use situ::random::stream;

use crate::record::RunRecord;
use crate::stats;

/// A statistic over runs, and its two 95 % intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pooled {
    pub(super) value: f64,
    /// By units: low and high.
    pub(super) units: Option<(f64, f64)>,
    /// By variations: low and high.
    pub(super) variations: Option<(f64, f64)>,
}

/// Things of runs, each with its run.
pub(super) type OfRuns<'a, T> = [(&'a RunRecord, T)];

/// The seed of all draws. The same things have the same interval, in whatever table they stand.
pub(super) fn draws() -> u64 {
    stream(0, "tables")
}

/// The runs that are drawn together, by their places in a list.
fn clusters<'a, K: Ord, T>(of: &OfRuns<'a, T>, key: impl Fn(&'a RunRecord) -> K) -> BTreeMap<K, Vec<usize>> {
    let mut clusters: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (place, (run, _)) in of.iter().enumerate() {
        clusters.entry(key(run)).or_default().push(place);
    }
    clusters
}

/// The unit of a run.
pub(super) fn unit(run: &RunRecord) -> (&str, u64) {
    (&run.key.task, run.key.seed)
}

/// The variation of a run.
pub(super) fn variation(run: &RunRecord) -> (&str, &str) {
    (&run.key.task, &run.key.variation)
}

/// A statistic of things of runs. `None` where it is `None` of all of them; a resample of which it is `None` is left
/// out.
pub(super) fn pooled_by<T>(
    of: &OfRuns<'_, T>,
    statistic: impl Fn(&mut dyn Iterator<Item = &T>) -> Option<f64>,
) -> Option<Pooled> {
    let value = statistic(&mut of.iter().map(|(_, thing)| thing))?;
    let interval = |strata: &[usize], clusters: Vec<Vec<usize>>| {
        if clusters.len() < 2 {
            return None;
        }
        let of = |drawn: &[usize]| {
            let places = drawn.iter().flat_map(|cluster| &clusters[*cluster]);
            statistic(&mut places.map(|place| &of[*place].1))
        };
        stats::bootstrap_within(strata, draws(), of).map(|estimate| (estimate.low, estimate.high))
    };
    let units = clusters(of, unit);
    let mut families: BTreeMap<&str, usize> = BTreeMap::new();
    for (task, _) in units.keys() {
        *families.entry(task).or_default() += 1;
    }
    let mut strata: Vec<usize> = families.into_values().collect();
    if strata.contains(&1) {
        strata = vec![units.len()];
    }
    let variations = clusters(of, variation);
    let count = variations.len();
    Some(Pooled {
        value,
        units: interval(&strata, units.into_values().collect()),
        variations: interval(&[count], variations.into_values().collect()),
    })
}

/// The sum of the first numbers over that of the second; each run has one of each. `None` where there is no run, or the
/// second numbers sum to 0.
pub(super) fn pooled_ratio(of: &OfRuns<'_, (f64, f64)>) -> Option<Pooled> {
    pooled_by(of, |pairs| {
        let (above, below) = pairs.fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        (below > 0.0).then(|| above / below)
    })
}

/// The same of shares. Where all agree, a bootstrap collapses at 0 or 1; then the interval is Wilson's of as many
/// units, or variations, that agree.
pub(super) fn pooled_share(of: &OfRuns<'_, (f64, f64)>) -> Option<Pooled> {
    let pooled = pooled_ratio(of)?;
    if pooled.value > 0.0 && pooled.value < 1.0 {
        return Some(pooled);
    }
    let agreeing = |count: usize| {
        let count = count as u32;
        stats::wilson(if pooled.value > 0.0 { count } else { 0 }, count)
    };
    let units = clusters(of, unit).len();
    let variations = clusters(of, variation).len();
    Some(Pooled {
        value: pooled.value,
        units: pooled.units.map(|_| agreeing(units)),
        variations: pooled.variations.map(|_| agreeing(variations)),
    })
}

/// The sums of a quantity over the units of these runs, in order: what a paired test is over. A test of sums is one of
/// the mean over runs.
pub(super) fn unit_sums(of: &OfRuns<'_, f64>) -> Vec<f64> {
    let sum = |places: Vec<usize>| places.iter().map(|place| of[*place].1).sum();
    clusters(of, unit).into_values().map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Record;
    use crate::sample;

    fn run(task: &str, variation: &str, seed: u64) -> RunRecord {
        let Record::Run(mut run) = sample::records().remove(0) else { unreachable!() };
        (run.key.task, run.key.variation, run.key.seed) = (task.to_owned(), variation.to_owned(), seed);
        run
    }

    /// Runs of one unit are drawn together: ten that agree say no more than one.
    #[test]
    fn runs_of_a_unit_are_no_evidence_of_their_own() {
        let runs: Vec<RunRecord> =
            (0..2).flat_map(|seed| (0..10).map(move |k| run("pour", &format!("v{k}"), seed))).collect();
        let of: Vec<_> = runs.iter().map(|run| (run, (run.key.seed as f64, 1.0))).collect();
        let found = pooled_ratio(&of).unwrap();
        assert_eq!((found.value, found.units), (0.5, Some((0.0, 1.0))), "two units that differ");
        assert_eq!(found.variations, Some((0.5, 0.5)), "variations that do not");
        assert_eq!(pooled_ratio(&[]), None);
        let alone = pooled_ratio(&of[..1]).unwrap();
        assert_eq!((alone.value, alone.units, alone.variations), (0.0, None, None), "one unit has no spread");
    }

    /// Families are strata: that one is harder than another is no spread, as soon as each has two units.
    #[test]
    fn what_differs_between_families_is_no_spread() {
        let runs: Vec<RunRecord> =
            ["pour", "stack"].iter().flat_map(|task| (0..3).map(move |seed| run(task, "v", seed))).collect();
        let of = |runs: &[RunRecord]| {
            let of: Vec<_> = runs.iter().map(|run| (run, (f64::from(run.key.task == "pour"), 1.0))).collect();
            pooled_ratio(&of).unwrap()
        };
        assert_eq!(of(&runs).units, Some((0.5, 0.5)));
        let one_each = of(&[run("pour", "v", 0), run("stack", "v", 0)]);
        assert_eq!(one_each.units, Some((0.0, 1.0)), "with one unit each, all are drawn together");
    }

    #[test]
    fn a_unit_has_one_sum() {
        let runs = [run("pour", "a", 0), run("pour", "b", 0), run("pour", "a", 1)];
        let of: Vec<(&RunRecord, f64)> = runs.iter().zip([1.0, 3.0, 7.0]).collect();
        assert_eq!(unit_sums(&of), [4.0, 7.0]);
    }

    /// Twenty units that agree are 20 of 20; the bootstrap says nothing of how far the truth may be.
    #[test]
    fn what_agrees_has_the_interval_of_wilson() {
        let runs: Vec<RunRecord> = (0..20).map(|seed| run("pour", &format!("v{}", seed % 4), seed)).collect();
        let of = |share: f64| runs.iter().map(|run| (run, (5.0 * share, 5.0))).collect::<Vec<_>>();
        let all = pooled_share(&of(1.0)).unwrap();
        assert_eq!(
            (all.value, all.units, all.variations),
            (1.0, Some(stats::wilson(20, 20)), Some(stats::wilson(4, 4)))
        );
        assert_eq!(pooled_share(&of(0.0)).unwrap().units, Some(stats::wilson(0, 20)));
        assert_eq!(pooled_share(&of(0.4)), pooled_ratio(&of(0.4)));
        assert_eq!(pooled_share(&of(1.0)[..1]).unwrap().units, None, "one unit has no interval");
    }
}
