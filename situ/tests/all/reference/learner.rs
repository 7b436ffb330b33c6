//! A learner of keyframe policies that is written as plainly as possible. It makes the decisions of the crate's own
//! learner without its code.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::{Gripper, Pose};
use situ::error::SituError;
use situ::keyframe::parameters::{Cut, KeyframeParameters, Spurious};
use situ::primitive::{Clustering, Displacement, Learner};
use situ::segment::Segment;
use situ::state::{Schema, State};
use situ::trace::Counters;

use crate::reference::classifier::Classifier;
use crate::reference::commands::Commands;
use crate::reference::hmm::{Frame, Hmm};
use crate::reference::linkage::labels;
use crate::reference::pose::resampled;
use crate::reference::scatter::{Laid, Scattered, metres, ways, with_contacts};
use crate::reference::true_keyframes::true_keyframes;

/// The reference. It counts no work.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    rule: KeyframeParameters,
    scales: Vec<f64>,
}

/// What is known of the teacher of the originals.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Calibrated {
    pub(crate) cut: f64,
    pub(crate) scatter: Scattered,
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

    fn distances_of_segments(&self, segments: &[&Segment], scatter: &Scattered) -> Vec<Vec<f64>> {
        let policies: Vec<Policy> = segments.iter().map(|segment| self.policy_of(&[segment], scatter)).collect();
        self.distances(&policies.iter().collect::<Vec<_>>())
    }

    fn policy_of(&self, segments: &[&Segment], scatter: &Scattered) -> Policy {
        let sequence = |segment: &&Segment| segment.keyframes.iter().map(|at| (at.pose, Some(at.gripper))).collect();
        let sequences: Vec<Vec<Frame>> = segments.iter().map(sequence).collect();
        let mut lengths: Vec<usize> = sequences.iter().map(Vec::len).collect();
        lengths.sort_unstable();
        let states = lengths[(lengths.len() - 1) / 2];
        let hmm = match self.rule.spurious {
            Spurious::LeftOut => true_keyframes(&sequences, states, &self.rule.policy),
            Spurious::Averaged => Hmm::fit(&sequences, states, &self.rule.policy),
        };
        let trajectory = |sequence: &Vec<Frame>| {
            let poses: Vec<Pose> = sequence.iter().map(|(pose, _)| *pose).collect();
            let points = resampled(&poses, self.rule.signature_points, self.rule.metres_per_radian);
            points.into_iter().map(|pose| (pose, None)).collect()
        };
        let trajectories: Vec<Vec<Frame>> = sequences.iter().map(trajectory).collect();
        Policy {
            reference: segments[0].reference.clone(),
            poses: hmm.emissions.iter().map(|emission| emission.mean).collect(),
            commands: hmm.emissions.iter().flat_map(|of| of.commands.as_ref().map(Commands::most_probable)).collect(),
            signature: Hmm::fit(&trajectories, self.rule.signature_states, &scatter.floor(&self.rule.signature)),
            trajectories,
        }
    }
}

/// The 95th percentile, linear between ranks.
pub(crate) fn percentile(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = 0.95 * (values.len() - 1) as f64;
    let (below, above) = (values[rank.floor() as usize], values[rank.ceil() as usize]);
    below + rank.fract() * (above - below)
}

/// Of all ways to lay the shorter list into the longer one in order, the best one's farthest pair, in the units of a
/// pair of contacts and of any other pair. Beside what is shown, one keyframe of the shorter list that is no contact
/// may be left out, if another is left.
fn farthest(left: &[Laid], right: &[Laid], units: (f64, f64), beside: bool) -> f64 {
    let whole = farthest_of_all(left, right, units);
    let short = if left.len() <= right.len() { left } else { right };
    let long = if left.len() <= right.len() { right } else { left };
    let without = (0..short.len()).filter(|index| beside && short.len() > 1 && !short[*index].1).map(|index| {
        let rest: Vec<Laid> = [&short[..index], &short[index + 1..]].concat();
        farthest_of_all(&rest, long, units)
    });
    without.fold(whole, f64::min)
}

fn farthest_of_all(left: &[Laid], right: &[Laid], units: (f64, f64)) -> f64 {
    let (short, long) = if left.len() <= right.len() { (left, right) } else { (right, left) };
    let apart = |one: &Laid, other: &Laid| metres(one, other) / if one.1 && other.1 { units.0 } else { units.1 };
    let of = |way: Vec<usize>| short.iter().zip(way).map(|(one, other)| apart(one, &long[other])).fold(0.0, f64::max);
    ways(short.len(), long.len()).into_iter().map(of).fold(f64::INFINITY, f64::min)
}

impl Learner for Reference {
    type Policy = Policy;
    type Classifier = Classifier;
    type Calibration = Calibrated;

    fn fit_policy(&self, segments: &[&Segment], known: &Calibrated, _: &mut Counters) -> Result<Policy, SituError> {
        Ok(self.policy_of(segments, &known.scatter))
    }

    fn fit_classifier(&self, own: &[&State], others: &[&State], _: &mut Counters) -> Result<Classifier, SituError> {
        Ok(Classifier::fit(own, others, &self.scales, &self.rule))
    }

    /// The nearest ways of two candidates count, and of the segment's own policy and a candidate the nearest way.
    fn cluster_and_find(
        &self,
        own: &Policy,
        candidates: &[Vec<&Policy>],
        _: &[f64],
        known: &Calibrated,
        _: &mut Counters,
    ) -> Clustering {
        let all: Vec<Vec<&Policy>> = candidates.iter().cloned().chain([vec![own]]).collect();
        let nearest = |left: &Vec<&Policy>, right: &Vec<&Policy>| {
            let pooled: Vec<&Policy> = left.iter().chain(right).copied().collect();
            let distances = self.distances(&pooled);
            let across = distances[..left.len()].iter().flat_map(|row| &row[left.len()..]);
            across.copied().fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<Vec<f64>> =
            all.iter().map(|left| all.iter().map(|right| nearest(left, right)).collect()).collect();
        let labels = labels(&distances, known.cut);
        let of = |label: usize| (0..candidates.len()).filter(|index| labels[*index] == label).collect::<Vec<_>>();
        let own = labels[candidates.len()];
        let others = (0..all.len()).filter(|label| *label != own).map(of);
        Clustering { matched: of(own), redundant: others.filter(|group| group.len() > 1).collect() }
    }

    /// Decisions D6, D6b and D7.
    fn distance(&self, left: &Policy, right: &Policy, _: Option<&Calibrated>, _: &mut Counters) -> f64 {
        if left.reference != right.reference || left.ends_closed() != right.ends_closed() {
            return f64::INFINITY;
        }
        0.5 * (left.excess(right) + right.excess(left))
    }

    fn calibrate(&self, originals: &[&[Arc<Segment>]], _: &mut Counters) -> Result<Calibrated, SituError> {
        let Cut { factor, prior, prior_copies, least, greatest, .. } = self.rule.cut;
        let scatter = Scattered::of(originals, &self.rule.scatter);
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
            let distances = self.distances_of_segments(segments, &scatter);
            let pairs = (0..segments.len()).flat_map(|index| &distances[index][index + 1..]);
            pooled.extend(pairs.filter(|distance| distance.is_finite()));
        }
        Ok(Calibrated { cut: (factor * percentile(pooled)).clamp(least, greatest), scatter })
    }

    fn cluster(&self, segments: &[&Segment], known: &Calibrated, _: &mut Counters) -> Result<Vec<usize>, SituError> {
        Ok(labels(&self.distances_of_segments(segments, &known.scatter), known.cut))
    }

    fn path(&self, policy: &Policy) -> Vec<Pose> {
        resampled(&policy.poses, self.rule.signature_points, self.rule.metres_per_radian)
    }

    fn displacement(&self, left: &Policy, right: &Policy, known: &Calibrated, beside: bool) -> Displacement {
        let laid = |policy: &Policy| {
            with_contacts(&policy.poses.iter().copied().zip(policy.commands.iter().copied()).collect::<Vec<_>>())
        };
        let (left, right) = (laid(left), laid(right));
        Displacement {
            metres: farthest(&left, &right, (1.0, 1.0), beside),
            scatters: farthest(&left, &right, (known.scatter.contact.0, known.scatter.free.0), beside),
        }
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }
}
