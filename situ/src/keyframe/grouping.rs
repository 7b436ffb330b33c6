//! Policies of many segments compared with one another, for the calibration of the cut and for a clustering of all.

use std::collections::BTreeMap;

use super::divergence::among;
use super::learner::{Calibration, KeyframeLearner, percentile};
use super::parameters::{Compared, Cut, Divergence, KeyframeParameters};
use super::policy::KeyframePolicy;
use super::roles::grouped;
use super::scatter::Scatter;
use crate::error::SituError;
use crate::segment::Segment;
use crate::trace::Counters;

impl KeyframeLearner {
    /// What two policies must share to be compared: the reference object (D6) and the grip (D6b, D7), unless the
    /// parameters compare across them.
    pub(super) fn kind<'a>(&self, policy: &'a KeyframePolicy) -> (Option<&'a str>, Option<bool>) {
        let KeyframeParameters { across_references, across_grips, .. } = self.parameters;
        ((!across_references).then_some(&*policy.reference), (!across_grips).then(|| policy.ends_closed()))
    }

    /// The condensed distances: (0,1), (0,2), …, (1,2), …
    pub(super) fn distances(
        &self,
        policies: &[&KeyframePolicy],
        cut: Option<f64>,
        counters: &mut Counters,
    ) -> Vec<f64> {
        let n = policies.len();
        let KeyframeParameters { compared, divergence, .. } = self.parameters;
        if (compared, divergence) != (Compared::Signatures, Divergence::CrossLikelihood) {
            let pairs = (0..n).flat_map(|left| (left + 1..n).map(move |right| (left, right)));
            return pairs.map(|(l, r)| self.divergence(policies[l], policies[r], cut, counters)).collect();
        }
        let mut kinds: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for (index, policy) in policies.iter().enumerate() {
            kinds.entry(self.kind(policy)).or_default().push(index);
        }
        let mut distances = vec![f64::INFINITY; n * n.saturating_sub(1) / 2];
        for members in kinds.values() {
            let explained: Vec<_> = members.iter().map(|index| policies[*index].explained()).collect();
            let mut apart = among(&explained).into_iter();
            for (index, left) in members.iter().enumerate() {
                // The pairs of the left one begin behind those of all before it.
                let row = left * (2 * n - left - 1) / 2;
                for (right, distance) in members[index + 1..].iter().zip(apart.by_ref()) {
                    distances[row + right - left - 1] = distance;
                    counters.divergences += 1;
                }
            }
        }
        distances
    }

    /// A policy for each segment alone.
    ///
    /// # Errors
    /// If a segment cannot be fitted.
    pub(super) fn singles(
        &self,
        segments: &[&Segment],
        scatter: &Scatter,
        counters: &mut Counters,
    ) -> Result<Vec<KeyframePolicy>, SituError> {
        segments.iter().map(|segment| self.policy_of(&[segment], scatter, counters)).collect()
    }

    /// The groups of segments that can be in one cluster, by index. Segments of different objects never are, so each
    /// object has its own dendrogram.
    pub(super) fn comparable(&self, segments: &[&Segment]) -> Vec<Vec<usize>> {
        let object =
            |segment: &&Segment| if self.parameters.across_references { None } else { Some(segment.reference.clone()) };
        let objects: Vec<_> = segments.iter().map(object).collect();
        grouped(&objects.iter().collect::<Vec<_>>()).into_values().collect()
    }

    /// Decision D8, from the distances between segments of the same role in so many originals. An infinite distance
    /// says nothing about the height of the cut: one of the two ends with a closed hand and the other does not, so no
    /// cut joins them.
    pub(super) fn calibration(&self, originals: usize, scatter: Scatter, of_roles: Vec<f64>) -> Calibration {
        let Cut { factor, prior, prior_copies, least, greatest, single } = self.parameters.cut;
        if originals < 2 {
            return Calibration { cut: single, scatter };
        }
        let mut distances = vec![prior; prior_copies];
        distances.extend(of_roles.into_iter().filter(|distance| distance.is_finite()));
        distances.sort_by(f64::total_cmp);
        Calibration { cut: (factor * percentile(&distances)).clamp(least, greatest), scatter }
    }
}
