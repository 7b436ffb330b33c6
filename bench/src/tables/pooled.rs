//! Means over runs of many tasks, with an interval by units and one by variations.
//!
//! Runs of one family and seed share the originals, so they are one *unit*; runs of one variation share the task. An
//! interval over runs would take them for independent. The interval by units draws units within each family; where a
//! family has one unit alone, units of all families are drawn together. The one by variations draws variations.

use std::collections::BTreeMap;

use crate::record::RunRecord;
use crate::stats;

/// A ratio of sums over runs, and its two 95 % intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pooled {
    pub(super) value: f64,
    /// By units: low and high.
    pub(super) units: (f64, f64),
    /// By variations: low and high.
    pub(super) variations: (f64, f64),
}

/// The runs that are drawn together, by their places in a list.
fn clusters<K: Ord>(of: &[(&RunRecord, (f64, f64))], key: impl Fn(&RunRecord) -> K) -> BTreeMap<K, Vec<usize>> {
    let mut clusters: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (place, (run, _)) in of.iter().enumerate() {
        clusters.entry(key(run)).or_default().push(place);
    }
    clusters
}

/// The sum of the first numbers over that of the second; each run has one of each. `None` where there is no run, or the
/// second numbers sum to 0.
pub(super) fn pooled(of: &[(&RunRecord, (f64, f64))], seed: u64) -> Option<Pooled> {
    let ratio = |clusters: &[Vec<usize>], drawn: &[usize]| {
        let places = || drawn.iter().flat_map(|cluster| &clusters[*cluster]);
        let below: f64 = places().map(|place| of[*place].1.1).sum();
        (below > 0.0).then(|| places().map(|place| of[*place].1.0).sum::<f64>() / below)
    };
    let units = clusters(of, |run| (run.key.task.clone(), run.key.seed));
    let mut families: BTreeMap<&str, usize> = BTreeMap::new();
    for (task, _) in units.keys() {
        *families.entry(task).or_default() += 1;
    }
    let mut strata: Vec<usize> = families.into_values().collect();
    if strata.contains(&1) {
        strata = vec![units.len()];
    }
    let units: Vec<Vec<usize>> = units.into_values().collect();
    let by_units = stats::bootstrap_within(&strata, seed, |drawn| ratio(&units, drawn))?;
    let variations = clusters(of, |run| (run.key.task.clone(), run.key.variation.clone()));
    let variations: Vec<Vec<usize>> = variations.into_values().collect();
    let by_variations = stats::bootstrap(variations.len(), seed, |drawn| ratio(&variations, drawn))?;
    Some(Pooled {
        value: by_units.value,
        units: (by_units.low, by_units.high),
        variations: (by_variations.low, by_variations.high),
    })
}

/// The means of a quantity over the units of these runs, in order: what a paired test is over.
pub(super) fn unit_means(of: &[(&RunRecord, f64)]) -> Vec<f64> {
    let numbers: Vec<(&RunRecord, (f64, f64))> = of.iter().map(|(run, value)| (*run, (*value, 1.0))).collect();
    let units = clusters(&numbers, |run| (run.key.task.clone(), run.key.seed));
    let mean = |places: Vec<usize>| stats::mean(&places.iter().map(|place| of[*place].1).collect::<Vec<_>>());
    units.into_values().filter_map(mean).collect()
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
        let found = pooled(&of, 1).unwrap();
        assert_eq!((found.value, found.units), (0.5, (0.0, 1.0)), "two units that differ");
        assert_eq!(found.variations, (0.5, 0.5), "variations that do not");
        assert_eq!(pooled(&[], 1), None);
    }

    /// Families are strata: that one is harder than another is no spread, as soon as each has two units.
    #[test]
    fn what_differs_between_families_is_no_spread() {
        let runs: Vec<RunRecord> =
            ["pour", "stack"].iter().flat_map(|task| (0..3).map(move |seed| run(task, "v", seed))).collect();
        let of = |runs: &[RunRecord]| {
            let of: Vec<_> = runs.iter().map(|run| (run, (f64::from(run.key.task == "pour"), 1.0))).collect();
            pooled(&of, 1).unwrap()
        };
        assert_eq!(of(&runs).units, (0.5, 0.5));
        let one_each = of(&[run("pour", "v", 0), run("stack", "v", 0)]);
        assert_eq!(one_each.units, (0.0, 1.0), "with one unit each, all are drawn together");
    }

    #[test]
    fn a_unit_has_one_mean() {
        let runs = [run("pour", "a", 0), run("pour", "b", 0), run("pour", "a", 1)];
        let of: Vec<(&RunRecord, f64)> = runs.iter().zip([1.0, 3.0, 7.0]).collect();
        assert_eq!(unit_means(&of), [2.0, 7.0]);
    }
}
