//! `keyframe_model`: a primitive as keyframe clusters in order (Akgun et al. 2012; Akgun and Thomaz 2016).
//!
//! The original learns *sequential pose distributions*: clusters of aligned keyframes, with a spline through their
//! means. A teacher steps through them and modifies, adds or deletes one at a time. Reconstructed here:
//!
//! - The clusters are the hidden states of the original policy. Each is a Gaussian over poses with a gripper command
//!   and a rest, so the uncorrected primitive is the original one. There is no spline: a rollout joins the means, as it
//!   does for every method.
//! - A correction contains no commands to modify, add or delete. They are read from the alignment of its keyframes with
//!   the clusters ([`super::alignment`]). If a keyframe has a cluster as its partner, it is *modify*; if a keyframe has
//!   no partner, *add*; if a cluster has no partner, *delete*.
//! - **Modify**: a keyframe within the 95th percentile of the cluster's distribution is averaged in as one more
//!   instance. Any other keyframe becomes the cluster's mean, because the teacher wants it instead; then instances are
//!   counted anew. With three careful originals the border is between 5 and 6 cm, or at 24°: a smaller correction
//!   counts as noise.
//! - **Add**: the keyframe is added between the clusters where it was shown. It is not added if it lies on the way
//!   between those clusters anyway, because people give needless keyframes.
//! - **Delete**: the cluster must lie off the way that was shown there, as forgetting a keyframe on the way means
//!   nothing. A cluster at which the hand closes or opens is deleted only if another keyframe of the correction closes
//!   or opens the hand there. Where a correction begins late or stops early it shows no way, so nothing is deleted
//!   there.

use nalgebra::Matrix6;
use serde::Serialize;

use super::alignment::{Stop, align, contacts, off_path};
use super::refine::{Refine, RefinedKeyframe};
use crate::demonstration::{Gripper, Pose};
use crate::error::SituError;
use crate::keyframe::hmm::{Emission, Observation};
use crate::keyframe::policy::{CHI_SQUARED_6_95, KeyframePolicy};
use crate::keyframe::pose::{exp, log};
use crate::segment::{RelativeKeyframe, Segment};
use crate::trace::Counters;

/// A keyframe that is at most this far from a way is on the way, metres (a radian counts a tenth of a metre). It is
/// more than a novice's noise of 1 cm and 4° amounts to, and less than the 8 cm of a small variation.
const ON_THE_WAY: f64 = 0.05;

/// Refines by moving, adding and deleting keyframe clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyframeModel;

/// A cluster: a distribution of poses, and what the hand does there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cluster {
    /// The Gaussian over poses, in the frame of the reference object.
    pub emission: Emission,
    /// The gripper command from here on.
    pub gripper: Gripper,
    /// Seconds of rest.
    pub hold: f64,
    /// The number of keyframes that it is the mean of.
    pub instances: u64,
}

impl Cluster {
    fn stop(&self) -> Stop {
        Stop { pose: self.emission.mean, gripper: self.gripper }
    }

    /// *Modify*: averages a keyframe in if it is an instance; else the cluster moves to it.
    fn modify(&mut self, shown: &RelativeKeyframe) {
        let apart = log(&self.emission.mean, &shown.pose);
        if self.emission.mahalanobis_squared(&apart) > CHI_SQUARED_6_95 {
            // The emission keeps a factor of its covariance, and the covariance stays.
            self.emission.mean = shown.pose;
            (self.gripper, self.hold, self.instances) = (shown.gripper, shown.hold, 1);
            return;
        }
        self.instances += 1;
        let share = 1.0 / self.instances as f64;
        let mean = |before: f64, now: f64| before + share * (now - before);
        self.emission.mean = exp(&self.emission.mean, &(apart * share));
        self.hold = mean(self.hold, shown.hold);
        self.gripper = match (self.gripper, shown.gripper) {
            (Gripper::Opening(before), Gripper::Opening(now)) => Gripper::Opening(mean(before, now)),
            (Gripper::Open(before), Gripper::Open(now)) => Gripper::Open(mean(before, now)),
            (Gripper::Close(before), Gripper::Close(now)) => Gripper::Close(mean(before, now)),
            (before, _) => before,
        };
    }
}

/// The clusters in order, at least one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyframeClusters(pub Vec<Cluster>);

impl KeyframeClusters {
    /// What becomes of the clusters `from.0..to.0` and the keyframes `from.1..to.1`, none of which has a partner. The
    /// stops before and after them are partners, if there are any.
    fn between(&self, from: (usize, usize), to: (usize, usize), shown: &[RelativeKeyframe]) -> Vec<Cluster> {
        let clusters = &self.0;
        let stops: Vec<Stop> = clusters.iter().map(Cluster::stop).collect();
        let contacts = contacts(&stops);
        // The two ways from partner to partner: the clusters', and the one that was shown.
        let (first, last) = (from.0.saturating_sub(1), (to.0 + 1).min(clusters.len()));
        let own: Vec<Pose> = stops[first..last].iter().map(|stop| stop.pose).collect();
        let first_shown = from.1.saturating_sub(1);
        let other: Vec<Pose> =
            shown[first_shown..(to.1 + 1).min(shown.len())].iter().map(|keyframe| keyframe.pose).collect();
        // The clusters that stay or are added, each with its place on the way that was shown.
        let mut kept: Vec<(f64, Cluster)> = Vec::new();
        for (index, cluster) in clusters.iter().enumerate().take(to.0).skip(from.0) {
            let (off, at) = off_path(&cluster.emission.mean, &other).unwrap_or((0.0, 0.0));
            let replaced = || {
                let closed = stops[index].is_closed();
                shown[from.1..to.1].iter().any(|keyframe| Stop::from(keyframe).is_closed() == closed)
            };
            let may_go = !contacts[index] || replaced();
            if off <= ON_THE_WAY || !may_go {
                kept.push((at, cluster.clone()));
            }
        }
        for (index, keyframe) in shown.iter().enumerate().take(to.1).skip(from.1) {
            let is_contact = index > 0 && Stop::from(keyframe).is_closed() != Stop::from(&shown[index - 1]).is_closed();
            let off = off_path(&keyframe.pose, &own).map_or(f64::INFINITY, |(off, _)| off);
            if off > ON_THE_WAY || is_contact {
                kept.push(((index - first_shown) as f64, self.cluster(keyframe)));
            }
        }
        kept.sort_by(|left, right| left.0.total_cmp(&right.0));
        kept.into_iter().map(|(_, cluster)| cluster).collect()
    }

    /// A cluster of one keyframe. A single keyframe has no covariance, so it takes that of the first cluster, and no
    /// scatter.
    fn cluster(&self, shown: &RelativeKeyframe) -> Cluster {
        let mut emission = self.0[0].emission.clone();
        emission.mean = shown.pose;
        emission.scatter = Matrix6::zeros();
        Cluster { emission, gripper: shown.gripper, hold: shown.hold, instances: 1 }
    }
}

impl Refine for KeyframeModel {
    type Primitive = KeyframeClusters;

    fn fit(
        &self,
        original: &KeyframePolicy,
        segments: &[&Segment],
        counters: &mut Counters,
    ) -> Result<KeyframeClusters, SituError> {
        let mut instances = vec![0; original.hmm().states()];
        for segment in segments {
            counters.segments_touched += 1;
            let observe =
                |keyframe: &RelativeKeyframe| Observation { pose: keyframe.pose, gripper: Some(keyframe.gripper) };
            let frames: Vec<Observation> = segment.keyframes.iter().map(observe).collect();
            for state in original.hmm().viterbi(&frames).0 {
                instances[state] += 1;
            }
        }
        let states = original.hmm().emissions.iter().zip(original.mean_keyframes()).zip(instances);
        let clusters = states.map(|((emission, RelativeKeyframe { gripper, hold, .. }), instances)| Cluster {
            emission: emission.clone(),
            gripper,
            hold,
            instances: instances.max(1),
        });
        Ok(KeyframeClusters(clusters.collect()))
    }

    fn correct(
        &self,
        primitive: &mut KeyframeClusters,
        shown: &Segment,
        counters: &mut Counters,
    ) -> Result<(), SituError> {
        counters.segments_touched += 1;
        let stops: Vec<Stop> = primitive.0.iter().map(Cluster::stop).collect();
        let shown = &shown.keyframes;
        let pairs = align(&stops, &shown.iter().map(Stop::from).collect::<Vec<_>>());
        let mut clusters = Vec::with_capacity(stops.len());
        let mut from = (0, 0);
        for (i, j) in pairs {
            clusters.extend(primitive.between(from, (i, j), shown));
            let mut cluster = primitive.0[i].clone();
            cluster.modify(&shown[j]);
            clusters.push(cluster);
            from = (i + 1, j + 1);
        }
        clusters.extend(primitive.between(from, (stops.len(), shown.len()), shown));
        // A primitive does something: if everything would be deleted, nothing is.
        if !clusters.is_empty() {
            primitive.0 = clusters;
        }
        Ok(())
    }

    fn keyframes(&self, primitive: &KeyframeClusters) -> Vec<RefinedKeyframe> {
        let keyframe = |cluster: &Cluster| RefinedKeyframe {
            mean: RelativeKeyframe { pose: cluster.emission.mean, gripper: cluster.gripper, hold: cluster.hold },
            scatter: cluster.emission.scatter,
        };
        primitive.0.iter().map(keyframe).collect()
    }
}
