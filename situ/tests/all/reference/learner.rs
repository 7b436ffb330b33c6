//! A learner of keyframe policies that is written as plainly as possible. It makes the decisions of the crate's own
//! learner without its code.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::{Gripper, Pose};
use situ::error::SituError;
use situ::keyframe::parameters::{Cut, KeyframeParameters};
use situ::primitive::{Clustering, Learner};
use situ::segment::Segment;
use situ::state::{Schema, State};
use situ::trace::Counters;

use crate::reference::classifier::Classifier;
use crate::reference::commands::Commands;
use crate::reference::hmm::{Frame, Hmm};
use crate::reference::linkage::labels;
use crate::reference::pose::resampled;

/// The reference. It counts no work.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    rule: KeyframeParameters,
    scales: Vec<f64>,
}

/// A policy: one keyframe per hidden state, and the signature by which it is compared.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Policy {
    reference: Arc<str>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) commands: Vec<Gripper>,
    signature: Hmm,
    trajectories: Vec<Vec<Frame>>,
}

impl Policy {
    fn ends_closed(&self) -> bool {
        matches!(self.commands.last(), Some(Gripper::Close(_)))
    }

    /// (log p(X) − log q(X)) / |X|, where p was fitted to X.
    fn excess(&self, q: &Self) -> f64 {
        let total = |hmm: &Hmm| self.trajectories.iter().map(|frames| hmm.log_likelihood(frames)).sum::<f64>();
        (total(&self.signature) - total(&q.signature)) / self.trajectories.iter().flatten().count() as f64
    }
}

impl Reference {
    pub(crate) fn new(schema: &Schema, rule: KeyframeParameters) -> Self {
        Self { rule, scales: schema.features().iter().map(|feature| feature.scale).collect() }
    }

    /// The distance of each policy from each.
    fn distances(&self, policies: &[&Policy]) -> Vec<Vec<f64>> {
        let distance = |left: &Policy, right: &Policy| self.distance(left, right, None, &mut Counters::default());
        policies.iter().map(|left| policies.iter().map(|right| distance(left, right)).collect()).collect()
    }

    fn distances_of_segments(&self, segments: &[&Segment]) -> Result<Vec<Vec<f64>>, SituError> {
        let single = |segment| self.fit_policy(&[segment], &mut Counters::default());
        let policies: Vec<Policy> = segments.iter().copied().map(single).collect::<Result<_, _>>()?;
        Ok(self.distances(&policies.iter().collect::<Vec<_>>()))
    }
}

/// The 95th percentile, linear between ranks.
pub(crate) fn percentile(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = 0.95 * (values.len() - 1) as f64;
    let (below, above) = (values[rank.floor() as usize], values[rank.ceil() as usize]);
    below + rank.fract() * (above - below)
}

/// Of all ways to lay the shorter list into the longer one in order, the best one's farthest pair, metres.
fn laid(short: &[Pose], long: &[Pose]) -> f64 {
    if short.is_empty() {
        0.0
    } else if short.len() > long.len() {
        f64::INFINITY
    } else {
        let here = (short[0].translation.vector - long[0].translation.vector).norm();
        here.max(laid(&short[1..], &long[1..])).min(laid(short, &long[1..]))
    }
}

impl Learner for Reference {
    type Policy = Policy;
    type Classifier = Classifier;
    type Calibration = f64;

    fn fit_policy(&self, segments: &[&Segment], _: &mut Counters) -> Result<Policy, SituError> {
        let sequence = |segment: &&Segment| segment.keyframes.iter().map(|at| (at.pose, Some(at.gripper))).collect();
        let sequences: Vec<Vec<Frame>> = segments.iter().map(sequence).collect();
        let mut lengths: Vec<usize> = sequences.iter().map(Vec::len).collect();
        lengths.sort_unstable();
        let hmm = Hmm::fit(&sequences, lengths[(lengths.len() - 1) / 2], &self.rule.policy);
        let trajectory = |sequence: &Vec<Frame>| {
            let poses: Vec<Pose> = sequence.iter().map(|(pose, _)| *pose).collect();
            let points = resampled(&poses, self.rule.signature_points, self.rule.metres_per_radian);
            points.into_iter().map(|pose| (pose, None)).collect()
        };
        let trajectories: Vec<Vec<Frame>> = sequences.iter().map(trajectory).collect();
        Ok(Policy {
            reference: segments[0].reference.clone(),
            poses: hmm.emissions.iter().map(|emission| emission.mean).collect(),
            commands: hmm.emissions.iter().flat_map(|of| of.commands.as_ref().map(Commands::most_probable)).collect(),
            signature: Hmm::fit(&trajectories, self.rule.signature_states, &self.rule.signature),
            trajectories,
        })
    }

    fn fit_classifier(&self, own: &[&State], others: &[&State], _: &mut Counters) -> Result<Classifier, SituError> {
        Ok(Classifier::fit(own, others, &self.scales, &self.rule))
    }

    fn cluster_and_find(
        &self,
        own: &Policy,
        candidates: &[&Policy],
        _: &[f64],
        cut: &f64,
        _: &mut Counters,
    ) -> Clustering {
        let all: Vec<&Policy> = candidates.iter().copied().chain([own]).collect();
        let labels = labels(&self.distances(&all), *cut);
        let of = |label: usize| (0..candidates.len()).filter(|index| labels[*index] == label).collect::<Vec<_>>();
        let own = labels[candidates.len()];
        let others = (0..all.len()).filter(|label| *label != own).map(of);
        Clustering { matched: of(own), redundant: others.filter(|group| group.len() > 1).collect() }
    }

    /// Decisions D6, D6b and D7.
    fn distance(&self, left: &Policy, right: &Policy, _: Option<&f64>, _: &mut Counters) -> f64 {
        if left.reference != right.reference || left.ends_closed() != right.ends_closed() {
            return f64::INFINITY;
        }
        0.5 * (left.excess(right) + right.excess(left))
    }

    fn calibrate(&self, originals: &[&[Arc<Segment>]], _: &mut Counters) -> Result<f64, SituError> {
        let Cut { factor, prior, prior_copies, least, greatest, .. } = self.rule.cut;
        // A role is the k-th visit to an object.
        let mut roles: BTreeMap<(&str, usize), Vec<&Segment>> = BTreeMap::new();
        for segments in originals {
            for (index, segment) in segments.iter().enumerate() {
                let visit = segments[..index].iter().filter(|before| before.reference == segment.reference).count();
                roles.entry((&segment.reference, visit)).or_default().push(segment);
            }
        }
        let mut pooled = vec![prior; prior_copies];
        for segments in roles.values() {
            let distances = self.distances_of_segments(segments)?;
            let pairs = (0..segments.len()).flat_map(|index| &distances[index][index + 1..]);
            pooled.extend(pairs.filter(|distance| distance.is_finite()));
        }
        Ok((factor * percentile(pooled)).clamp(least, greatest))
    }

    fn cluster(&self, segments: &[&Segment], cut: &f64, _: &mut Counters) -> Result<Vec<usize>, SituError> {
        Ok(labels(&self.distances_of_segments(segments)?, *cut))
    }

    fn path(&self, policy: &Policy) -> Vec<Pose> {
        resampled(&policy.poses, self.rule.signature_points, self.rule.metres_per_radian)
    }

    fn displacement(&self, left: &Policy, right: &Policy) -> f64 {
        let (left, right) = (&left.poses, &right.poses);
        if left.len() <= right.len() { laid(left, right) } else { laid(right, left) }
    }
}
