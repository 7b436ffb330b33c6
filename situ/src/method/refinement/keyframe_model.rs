//! `keyframe_model`: a primitive as keyframe clusters in order (Akgun et al. 2012; Akgun and Thomaz 2016).
//!
//! The original learns *sequential pose distributions*, clusters of aligned keyframes, through whose means it lays a
//! spline, and lets a teacher step through them and modify, add or delete one at a time. Reconstructed here:
//!
//! - The clusters are the hidden states of the original policy, each a Gaussian over poses with a gripper command and a
//!   rest: so the uncorrected primitive is the original one. The spline is whoever executes the keyframes: a rollout
//!   joins the means as it does for every method.
//! - A correction states no commands. They are read from the alignment of its keyframes with the clusters
//!   ([`super::alignment`]): *modify* where a keyframe has a cluster as partner, *add* where it has none, *delete*
//!   where a cluster has none.
//! - **Modify**: a keyframe that the cluster's distribution holds to be one of its own, within the 95th percentile, is
//!   averaged in as one more instance; another becomes the cluster's mean, for it is what the teacher wants instead.
//!   Instances are counted anew then. With three careful originals the border is between 5 and 6 cm, or at 24°: a
//!   correction by less is taken for noise.
//! - **Add**, between the clusters where it was shown, unless it lies on the way that the clusters beside it make
//!   anyway: people give needless keyframes.
//! - **Delete**, where that is warranted: the cluster must lie off the way that was shown there (a keyframe that is
//!   forgotten on the way costs nothing), and it must not be the one at which the hand closes or opens, unless the
//!   correction closes or opens it there by another keyframe. Where a correction begins late or stops early it shows no
//!   way, so nothing is deleted there.

use nalgebra::Matrix6;
use serde::Serialize;

use super::alignment::{Stop, align, contacts, off_path};
use super::refine::{Refine, Refined};
use crate::demonstration::{Gripper, Pose, RelativeKeyframe, Segment};
use crate::error::SituError;
use crate::keyframe::hmm::{Emission, Observation};
use crate::keyframe::policy::{CHI_SQUARED_6_95, KeyframePolicy};
use crate::keyframe::pose::{exp, log};
use crate::trace::Counters;

/// A keyframe no further from a way than this is on the way, metres (a radian counts a tenth): more than a novice's
/// noise of 1 cm and 4° makes of it, less than the 8 cm of a near-variant.
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
    /// Keyframes whose mean it is.
    pub instances: u64,
}

impl Cluster {
    fn stop(&self) -> Stop {
        Stop { pose: self.emission.mean, gripper: self.gripper }
    }

    /// *Modify*: averages a keyframe in where it is an instance, else moves there.
    fn modify(&mut self, shown: &RelativeKeyframe) {
        let apart = log(&self.emission.mean, &shown.pose);
        if self.emission.mahalanobis_squared(&apart) > CHI_SQUARED_6_95 {
            // The factor that an emission keeps is its covariance's, which stays.
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

/// The clusters in order; at least one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clusters(pub Vec<Cluster>);

impl Clusters {
    /// What to do with the clusters `from.0..to.0` and the keyframes `from.1..to.1`, none of which has a partner; the
    /// two stops around them, where there are any, are partners.
    fn between(&self, from: (usize, usize), to: (usize, usize), shown: &[RelativeKeyframe]) -> Vec<Cluster> {
        let clusters = &self.0;
        let stops: Vec<Stop> = clusters.iter().map(Cluster::stop).collect();
        let contacts = contacts(&stops);
        // The two ways from partner to partner.
        let (first, last) = (from.0.saturating_sub(1), (to.0 + 1).min(clusters.len()));
        let own: Vec<Pose> = stops[first..last].iter().map(|stop| stop.pose).collect();
        let first_shown = from.1.saturating_sub(1);
        let other: Vec<Pose> =
            shown[first_shown..(to.1 + 1).min(shown.len())].iter().map(|keyframe| keyframe.pose).collect();
        // Where it stands on the way that was shown, and the cluster.
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

    /// A cluster of one keyframe. It has the first one's covariance, for a single keyframe has none, and no scatter.
    fn cluster(&self, shown: &RelativeKeyframe) -> Cluster {
        let mut emission = self.0[0].emission.clone();
        emission.mean = shown.pose;
        emission.scatter = Matrix6::zeros();
        Cluster { emission, gripper: shown.gripper, hold: shown.hold, instances: 1 }
    }
}

impl Refine for KeyframeModel {
    type Primitive = Clusters;

    fn fit(
        &self,
        original: &KeyframePolicy,
        segments: &[&Segment],
        counters: &mut Counters,
    ) -> Result<Clusters, SituError> {
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
        Ok(Clusters(clusters.collect()))
    }

    fn correct(&self, primitive: &mut Clusters, shown: &Segment, counters: &mut Counters) -> Result<(), SituError> {
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
        // A primitive does something: where everything would be deleted, nothing is.
        if !clusters.is_empty() {
            primitive.0 = clusters;
        }
        Ok(())
    }

    fn keyframes(&self, primitive: &Clusters) -> Vec<Refined> {
        let keyframe = |cluster: &Cluster| Refined {
            mean: RelativeKeyframe { pose: cluster.emission.mean, gripper: cluster.gripper, hold: cluster.hold },
            scatter: cluster.emission.scatter,
        };
        primitive.0.iter().map(keyframe).collect()
    }
}
