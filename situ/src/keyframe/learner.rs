//! The learner of keyframe policies: what Algorithm 2 calls Fit-Policy, Fit-Classifier, Cluster and Find-Policy.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::alignment::displacement;
use super::classifier::{KeyframeClassifier, lifted, scaled, squared_distance, standardised};
use super::cluster::average_linkage;
use super::divergence::{cross_likelihood, monte_carlo, monte_carlo_against, transient_bound};
use super::hmm::Observation;
use super::interpolate::resample;
use super::logistic;
use super::parameters::{Activation, Compared, Divergence, KeyframeParameters, Spurious, Standardisation};
use super::policy::{KeyframePolicy, observations};
use super::roles::{grouped, in_order, lead, pooled};
use super::scatter::Scatter;
use super::true_keyframes::{Fitting, paths};
use crate::demonstration::Pose;
use crate::error::SituError;
use crate::primitive::{Clustering, Displacement, Learner};
use crate::segment::Segment;
use crate::state::{Axis, Schema, State};
use crate::trace::Counters;

/// The percentile of decisions D8 and D10b.
const PERCENTILE: f64 = 0.95;

/// Learns keyframe policies and logistic initiation classifiers.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeLearner {
    pub(super) parameters: KeyframeParameters,
    scales: Arc<[f64]>,
    /// The symmetry of the hand (decision D24).
    pub(super) half_turn: Option<Axis>,
}

/// The height at which the dendrogram is cut (decision D8). The task model keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The height of the cut, nats per frame.
    pub cut: f64,
    /// The teacher's own scatter (decision D21).
    pub scatter: Scatter,
}

impl KeyframeLearner {
    /// A learner for states of this schema.
    pub fn new(schema: &Schema, parameters: KeyframeParameters) -> Self {
        let half_turn = schema.half_turn().filter(|_| parameters.symmetry);
        Self { parameters, scales: schema.features().iter().map(|feature| feature.scale).collect(), half_turn }
    }

    /// The parameters.
    pub fn parameters(&self) -> &KeyframeParameters {
        &self.parameters
    }

    /// What the features of a state are divided by.
    pub(super) fn shared_scales(&self) -> Arc<[f64]> {
        self.scales.clone()
    }

    /// The number of features of a state.
    pub fn features(&self) -> usize {
        self.scales.len()
    }

    pub(super) fn trajectories(&self, segments: &[&Segment]) -> Vec<Vec<Observation>> {
        let interpolate = |segment: &&Segment| {
            self.path_of(segment).into_iter().map(|pose| Observation { pose, gripper: None }).collect()
        };
        segments.iter().map(interpolate).collect()
    }

    /// The rests of a segment that count, with the hidden states they are at, from those at all its keyframes. Of the
    /// keyframes in one state the longest rest counts, because one of them is true (decision D25).
    fn rests(&self, all: impl Iterator<Item = (f64, usize)>) -> Vec<(f64, usize)> {
        let mut rests: Vec<(f64, usize)> = Vec::new();
        for (hold, state) in all {
            match rests.last_mut() {
                Some((longest, last)) if *last == state && self.parameters.spurious == Spurious::LeftOut => {
                    *longest = longest.max(hold);
                }
                _ => rests.push((hold, state)),
            }
        }
        rests
    }

    /// The policy of segments by a teacher of this scatter.
    pub(super) fn policy_of(
        &self,
        segments: &[&Segment],
        scatter: &Scatter,
        counters: &mut Counters,
    ) -> Result<KeyframePolicy, SituError> {
        let reference = segments[0].reference.clone();
        counters.segments_touched += segments.len() as u64;
        let sequences: Vec<Vec<Observation>> = segments.iter().map(|segment| observations(segment)).collect();
        // Decision D14: as many hidden states as the median number of keyframes.
        let mut lengths: Vec<usize> = sequences.iter().map(Vec::len).collect();
        lengths.sort_unstable();
        let median = lengths[(lengths.len() - 1) / 2];
        let mut keyframes = Fitting { reference: &reference, parameters: &self.parameters.policy, counters };
        let (hmm, paths) = match self.parameters.spurious {
            Spurious::LeftOut => keyframes.true_keyframes(&sequences, median)?,
            Spurious::Averaged => {
                let hmm = keyframes.fit(&sequences, median)?.hmm;
                let paths = paths(&hmm, &sequences);
                (hmm, paths)
            }
        };
        let rests = segments
            .iter()
            .zip(paths)
            .flat_map(|(segment, path)| self.rests(segment.keyframes.iter().map(|keyframe| keyframe.hold).zip(path)));
        let mut holds = vec![(0.0, 0.0); hmm.emissions.len()];
        for (hold, state) in rests {
            holds[state].0 += hold;
            holds[state].1 += 1.0;
        }
        let trajectories = self.trajectories(segments);
        let states = self.parameters.signature_states;
        let parameters = scatter.floor(&self.parameters.signature);
        let signature =
            Fitting { reference: &reference, parameters: &parameters, counters }.fit(&trajectories, states)?;
        Ok(KeyframePolicy {
            reference,
            hmm,
            holds: holds.into_iter().map(|(sum, count): (f64, f64)| sum / count.max(1.0)).collect(),
            log_likelihood: signature.log_likelihood(),
            signature: signature.hmm,
            trajectories,
        })
    }

    /// The divergence of two policies, symmetrised, nats per frame. Infinite for two reference objects (D6) or two
    /// grips (D6b, D7). With a `cut`, only the side of the cut is certain.
    pub(super) fn divergence(
        &self,
        left: &KeyframePolicy,
        right: &KeyframePolicy,
        cut: Option<f64>,
        counters: &mut Counters,
    ) -> f64 {
        if self.kind(left) != self.kind(right) {
            return f64::INFINITY;
        }
        counters.divergences += 1;
        let q = &right.signature;
        let poses_only;
        let (p, compares_signatures) = match self.parameters.compared {
            Compared::Signatures => (&left.signature, true),
            Compared::PolicyAgainstSignature => {
                poses_only = left.hmm.poses_only();
                (&poses_only, false)
            }
        };
        match self.parameters.divergence {
            Divergence::CrossLikelihood if compares_signatures => left.explained().divergence(&right.explained()),
            Divergence::CrossLikelihood => cross_likelihood(p, &left.trajectories, q, &right.trajectories),
            Divergence::MonteCarlo(samples) => {
                let seed = self.parameters.seed;
                match cut {
                    Some(cut) => monte_carlo_against(p, q, samples, seed, cut).0.mean,
                    None => 0.5 * (monte_carlo(p, q, samples, seed).mean + monte_carlo(q, p, samples, seed).mean),
                }
            }
            Divergence::TransientBound => 0.5 * (transient_bound(p, q) + transient_bound(q, p)),
        }
    }

    /// The origin and the unit of each feature in a regression (decision D16).
    fn units(&self, positives: &[Vec<f64>], negatives: &[Vec<f64>], centre: &[f64]) -> Vec<(f64, f64)> {
        let Standardisation::Within { prior, .. } = self.parameters.standardisation else {
            return vec![(0.0, 1.0); centre.len()];
        };
        let other = mean(negatives, centre.len());
        let spread = |points: &[Vec<f64>], feature: usize, centre: &[f64]| -> f64 {
            points.iter().map(|point| (point[feature] - centre[feature]) * (point[feature] - centre[feature])).sum()
        };
        let unit = |feature: usize| {
            let (sum, count) = if positives.len() > 1 {
                (spread(positives, feature, centre), positives.len())
            } else {
                (spread(negatives, feature, &other), 1 + negatives.len())
            };
            libm::sqrt((prior + sum) / (prior + count as f64)).min(1.0)
        };
        (0..centre.len()).map(|feature| (centre[feature], unit(feature))).collect()
    }
}

/// The mean of points of this dimension; zero if there is none.
fn mean(points: &[Vec<f64>], dimension: usize) -> Vec<f64> {
    let mut mean = vec![0.0; dimension];
    for point in points {
        for (sum, value) in mean.iter_mut().zip(point) {
            *sum += value / points.len() as f64;
        }
    }
    mean
}

/// The value at [`PERCENTILE`] of sorted finite values, linear between ranks; 0 if there is none.
pub(super) fn percentile(sorted: &[f64]) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let rank = PERCENTILE * last as f64;
    let below = rank as usize;
    let above = (below + 1).min(last);
    sorted[below] + (rank - below as f64) * (sorted[above] - sorted[below])
}

impl Learner for KeyframeLearner {
    type Policy = KeyframePolicy;
    type Classifier = KeyframeClassifier;
    type Calibration = Calibration;

    fn fit_policy(
        &self,
        segments: &[&Segment],
        calibration: &Calibration,
        counters: &mut Counters,
    ) -> Result<KeyframePolicy, SituError> {
        self.policy_of(segments, &calibration.scatter, counters)
    }

    fn fit_classifier(
        &self,
        positives: &[&State],
        negatives: &[&State],
        counters: &mut Counters,
    ) -> Result<KeyframeClassifier, SituError> {
        if positives.is_empty() {
            return Err(SituError::Classifier("no positive sample".to_owned()));
        }
        counters.classifier_fits += 1;
        let points: Vec<Vec<f64>> =
            positives.iter().chain(negatives).map(|state| scaled(state, &self.scales)).collect();
        let (own, others) = points.split_at(positives.len());
        let centre = mean(own, self.scales.len());
        let units = self.units(own, others, &centre);
        let radius = match self.parameters.activation {
            Activation::Probability => f64::INFINITY,
            Activation::Bounded { factor, least } => {
                let mut radii: Vec<f64> =
                    own.iter().map(|point| libm::sqrt(squared_distance(point, &centre))).collect();
                radii.sort_by(f64::total_cmp);
                (factor * percentile(&radii)).max(least)
            }
        };
        let lift = self.parameters.lift;
        let most = self.parameters.standardisation.most();
        let origin = standardised(&centre, &units, most);
        let rows: Vec<Vec<f64>> =
            points.iter().map(|point| lifted(lift, &standardised(point, &units, most), &origin)).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let labels: Vec<bool> = (0..rows.len()).map(|index| index < positives.len()).collect();
        let fit = logistic::fit(&rows, &labels, &self.parameters.logistic)
            .map_err(|error| SituError::Classifier(error.to_string()))?;
        Ok(KeyframeClassifier { lift, fit, centre, units, most, radius, scales: self.scales.clone() })
    }

    fn cluster_and_find(
        &self,
        own: &KeyframePolicy,
        candidates: &[Vec<&KeyframePolicy>],
        among: &[f64],
        calibration: &Calibration,
        counters: &mut Counters,
    ) -> Clustering {
        // The segment's own policy comes last of all, so it is the last in the row of each candidate.
        let mut distances = Vec::with_capacity(among.len() + candidates.len());
        let mut known = among.iter();
        for (index, candidate) in candidates.iter().enumerate() {
            distances.extend(known.by_ref().take(candidates.len() - 1 - index));
            let ways = candidate.iter().map(|way| self.divergence(way, own, Some(calibration.cut), counters));
            distances.push(ways.fold(f64::INFINITY, f64::min));
        }
        let labels = average_linkage(&distances, candidates.len() + 1).cut(calibration.cut);
        let mut clusters: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, label) in labels[..candidates.len()].iter().enumerate() {
            clusters.entry(*label).or_default().push(index);
        }
        let matched = clusters.remove(&labels[candidates.len()]).unwrap_or_default();
        let mut redundant: Vec<Vec<usize>> = clusters.into_values().filter(|group| group.len() > 1).collect();
        redundant.sort();
        Clustering { matched, redundant }
    }

    fn distance(
        &self,
        left: &KeyframePolicy,
        right: &KeyframePolicy,
        calibration: Option<&Calibration>,
        counters: &mut Counters,
    ) -> f64 {
        self.divergence(left, right, calibration.map(|calibration| calibration.cut), counters)
    }

    fn calibrate(&self, originals: &[&[Arc<Segment>]], counters: &mut Counters) -> Result<Calibration, SituError> {
        // A role is the k-th visit to a reference object.
        let mut distances = Vec::new();
        let scatter = self.parameters.scatter.of(originals);
        if originals.len() > 1 {
            let (segments, roles) = pooled(originals);
            for members in grouped(&roles).values() {
                let own = members.iter().map(|index| segments[*index]).collect::<Vec<_>>();
                let policies = self.singles(&own, &scatter, counters)?;
                distances.extend(self.distances(&policies.iter().collect::<Vec<_>>(), None, counters));
            }
        }
        Ok(self.calibration(originals.len(), scatter, distances))
    }

    fn cluster(
        &self,
        segments: &[&Segment],
        calibration: &Calibration,
        counters: &mut Counters,
    ) -> Result<Vec<usize>, SituError> {
        let policies = self.singles(segments, &calibration.scatter, counters)?;
        let mut first = vec![0; segments.len()];
        for members in self.comparable(segments) {
            let own: Vec<&KeyframePolicy> = members.iter().map(|index| &policies[*index]).collect();
            let distances = self.distances(&own, Some(calibration.cut), counters);
            lead(&members, &average_linkage(&distances, own.len()).cut(calibration.cut), &mut first);
        }
        Ok(in_order(&first))
    }

    fn calibrate_and_cluster(
        &self,
        originals: &[&[Arc<Segment>]],
        counters: &mut Counters,
    ) -> Result<(Calibration, Vec<usize>), SituError> {
        let (segments, roles) = pooled(originals);
        if matches!(self.parameters.divergence, Divergence::MonteCarlo(_)) {
            // These distances are as exact as the cut needs, so they wait for it.
            let calibration = self.calibrate(originals, counters)?;
            return Ok((calibration, self.cluster(&segments, &calibration, counters)?));
        }
        let scatter = self.parameters.scatter.of(originals);
        let policies = self.singles(&segments, &scatter, counters)?;
        let (mut compared, mut of_roles) = (Vec::new(), Vec::new());
        for members in self.comparable(&segments) {
            let own: Vec<&KeyframePolicy> = members.iter().map(|index| &policies[*index]).collect();
            let distances = self.distances(&own, None, counters);
            let pairs = members
                .iter()
                .enumerate()
                .flat_map(|(at, left)| members[at + 1..].iter().map(move |right| (left, right)));
            of_roles
                .extend(pairs.zip(&distances).filter(|((l, r), _)| roles[**l] == roles[**r]).map(|(_, apart)| *apart));
            compared.push((members, distances));
        }
        let calibration = self.calibration(originals.len(), scatter, of_roles);
        let mut first = vec![0; segments.len()];
        for (members, distances) in compared {
            lead(&members, &average_linkage(&distances, members.len()).cut(calibration.cut), &mut first);
        }
        Ok((calibration, in_order(&first)))
    }

    /// The greatest distance between a keyframe of one policy and the same keyframe of the other, in position:
    /// [`displacement`]. A distance of paths would be wrong here: a needless or a forgotten keyframe moves the path by
    /// as much as a small variation does. In units of the teacher's scatter a keyframe at which the hand closes or
    /// opens counts more than one on the way (decision D21).
    fn displacement(
        &self,
        left: &KeyframePolicy,
        right: &KeyframePolicy,
        calibration: &Calibration,
        beside: bool,
    ) -> Displacement {
        let (one, other, left_out) = (left.laid(), right.laid(), usize::from(beside));
        Displacement {
            metres: displacement(&one, &other, left_out, |_| 1.0),
            scatters: displacement(&one, &other, left_out, |is_contact| calibration.scatter.position(is_contact)),
        }
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn path(&self, policy: &KeyframePolicy) -> Vec<Pose> {
        resample(&policy.means(), self.parameters.signature_points, self.parameters.metres_per_radian)
    }
}
