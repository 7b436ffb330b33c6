//! `cost_weights`: a primitive as the minimiser of a cost, whose weights are moved by corrections (Jain et al. 2013;
//! Bajcsy et al. 2018).
//!
//! The executed keyframes minimise the distance to the demonstrated ones plus weighted features ([`features()`]). A
//! correction moves the weights by the rule of the paper ([`Rule`]); then the plan is solved anew. The demonstrated
//! keyframes are the means of the original policy, and all weights begin at 0, so the uncorrected primitive is the
//! original one.
//!
//! What is shown is aligned with the plan ([`super::alignment`]). A planned keyframe with a partner is *deformed* to
//! it; one without a partner stays as planned. The result is `ȳ` (Jain) or `ξ_D` (Bajcsy); the plan itself is `y` or
//! `ξ_R`. Shown keyframes without a partner have no effect, because no feature can express them. Grip commands and
//! rests are those of the original.
//!
//! # The features of a plan, and the plan of least cost
//!
//! A plan of K keyframes is written as displacements `u_k` from the demonstrated keyframes. A displacement has three
//! positions in the frame of the reference object (along x, along y, and height; metres). Then it has three turns about
//! the gripper's own axes (two tilts, and the turn about the approach axis; radians). The keyframes form two groups
//! `g`: the *contacts*, where the hand closes or opens, and the *free* ones. There is one feature per group and axis,
//! the mean displacement of the group along the axis:
//!
//! `φ_{g,c}(u) = (1/n_g) Σ_{k ∈ g} u_{k,c}`.
//!
//! These are twelve features. The cost of a plan with weights `w` is
//!
//! `J(u) = Σ_g (1/2n_g) Σ_{k ∈ g} |u_k|² + wᵀ φ(u)`:
//!
//! its distance from what was demonstrated, plus the weighted features. A square metre and a square radian cost the
//! same; no plan depends on that. The gradient vanishes at `u_{k,c} = −w_{g,c}`. As J is strictly convex, that is the
//! only minimum. So the features of the best plan are its weights with the other sign.
//!
//! **These features can express**: move the contacts elsewhere, or hold them at another height, tilt or turn; and the
//! same for the free keyframes, as one body. **They cannot express**: move one free keyframe relative to another (a
//! bend, a way around something), have one keyframe more or fewer, another grip command, another rest. Nor can they
//! express what depends on another object, because the frame is that of the reference object.

use std::array;

use nalgebra::Matrix6;
use serde::Serialize;

use super::alignment::{Stop, align, contacts};
use super::refine::{Refine, RefinedKeyframe};
use crate::error::SituError;
use crate::keyframe::policy::KeyframePolicy;
use crate::keyframe::pose::{Tangent, exp, log};
use crate::segment::{RelativeKeyframe, Segment};
use crate::trace::Counters;

/// The axes of a displacement.
const AXES: usize = 6;
/// The groups of keyframes: free, contact.
const GROUPS: usize = 2;
/// The features of a plan.
pub const FEATURES: usize = GROUPS * AXES;
/// One number per feature: six of the free keyframes, then six of the contacts; three in metres, then three in radians.
pub type Features = [f64; FEATURES];

/// The range of a position, metres, and of a turn, radians: the scales at which a difference matters (decision D16:
/// offsets 0.2 m, tilt 0.5 rad). Features are compared with each other in ranges.
const RANGE: [f64; 2] = [0.2, 0.5];
/// The range of each feature.
pub const RANGES: Features = {
    let mut ranges = [0.0; FEATURES];
    let mut feature = 0;
    while feature < FEATURES {
        ranges[feature] = RANGE[feature % AXES / 3];
        feature += 1;
    }
    ranges
};

/// φ(u). `contacts` has one entry per displacement. The features of a group without keyframes are 0.
pub fn features(contacts: &[bool], displacements: &[Tangent]) -> Features {
    let contact = contacts.iter().filter(|contact| **contact).count();
    let sizes = [contacts.len() - contact, contact].map(|count| count.max(1) as f64);
    array::from_fn(|feature| {
        let (group, axis) = (feature / AXES, feature % AXES);
        let own = contacts.iter().zip(displacements).filter(|(contact, _)| usize::from(**contact) == group);
        own.map(|(_, moved)| moved[axis]).sum::<f64>() / sizes[group]
    })
}

/// The displacements of least cost, one per keyframe.
pub fn plan(contacts: &[bool], weights: &Features) -> Vec<Tangent> {
    let moved = |contact: &bool| Tangent::from_fn(|axis, _| -weights[usize::from(*contact) * AXES + axis]);
    contacts.iter().map(moved).collect()
}

/// The published rule that moves the weights.
///
/// With a step of 1 and no weight at its limit, [`Rule::All`] and [`Rule::Coactive`] are one rule: Bajcsy et al. follow
/// the same gradient of the same linear cost as Jain et al., in steps of their choice, and clip. Both have a name here
/// because they were published separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Jain et al. 2013, the preference perceptron: [`coactive`].
    Coactive,
    /// Bajcsy et al. 2018, moving every weight: [`Physical`].
    All,
    /// Bajcsy et al. 2018, moving the one weight that the correction changes most: [`Physical`].
    OneAtATime,
}

/// Jain et al. 2013: `w ← w + φ(ȳ) − φ(y)`. These are the weights of a *utility* `wᵀφ`; `ȳ` is what was shown and `y`
/// what was planned.
///
/// If what is shown is optimal under true weights `w*`, and `‖φ‖ ≤ R`, the average regret of T plans is at most
/// `2R‖w*‖/√T`.
pub fn coactive<const N: usize>(weights: &mut [f64; N], shown: &[f64; N], planned: &[f64; N]) {
    for feature in 0..N {
        weights[feature] += shown[feature] - planned[feature];
    }
}

/// Bajcsy et al. 2018: `θ ← θ − g ΔΦ` with `ΔΦ = Φ(ξ_D) − Φ(ξ_R)`. These are the weights of a *cost* `θᵀΦ`, clipped at
/// `limit` ranges to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physical<'a, const N: usize> {
    /// The range of each feature, in its unit.
    pub ranges: &'a [f64; N],
    /// The step g.
    pub gain: f64,
    /// Where a weight is clipped, in ranges.
    pub limit: f64,
    /// Whether only `i* = argmax |ΔΦ_i / range_i|` moves, the first of those that tie. Otherwise all weights move.
    pub one_at_a_time: bool,
}

impl<const N: usize> Physical<'_, N> {
    /// Moves the weights by a correction: `shown` is Φ(ξ_D), `planned` is Φ(ξ_R).
    pub fn correct(&self, weights: &mut [f64; N], shown: &[f64; N], planned: &[f64; N]) {
        let difference = |feature: usize| shown[feature] - planned[feature];
        let share = |feature: usize| (difference(feature) / self.ranges[feature]).abs();
        let mut most = 0;
        for feature in 1..N {
            if share(feature) > share(most) {
                most = feature;
            }
        }
        for (feature, weight) in weights.iter_mut().enumerate() {
            if !self.one_at_a_time || feature == most {
                let bound = self.limit * self.ranges[feature];
                *weight = (*weight - self.gain * difference(feature)).max(-bound).min(bound);
            }
        }
    }
}

/// The step of both rules of Bajcsy et al. The curvature of the plan's cost is 1 along every feature. So with a step of
/// 1, the features that are moved become exactly what was shown. Bajcsy et al. tune the step by hand for each feature.
const GAIN: f64 = 1.0;
/// Bajcsy et al. clip weights. Here they are clipped at so many ranges to either side: 40 cm and 1 rad. A modification
/// that moves a primitive by 12 cm is far from that.
const LIMIT: f64 = 2.0;

/// Refines by the weights of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CostWeights {
    /// How a correction moves the weights.
    pub rule: Rule,
}

/// A primitive: what was demonstrated, and the weights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostPrimitive {
    /// The demonstrated keyframes, which the plan stays near.
    demonstrated: Vec<RelativeKeyframe>,
    /// The scatter of each keyframe, for sampled executions.
    scatter: Vec<Matrix6<f64>>,
    /// The weights of the features in the cost, in the unit of each feature.
    weights: Features,
}

impl CostPrimitive {
    /// The minimiser of the cost.
    fn plan(&self) -> Vec<RelativeKeyframe> {
        let displacements = plan(&contacts(&stops(&self.demonstrated)), &self.weights);
        let keyframes = self.demonstrated.iter().zip(displacements);
        keyframes.map(|(mean, moved)| RelativeKeyframe { pose: exp(&mean.pose, &moved), ..*mean }).collect()
    }
}

fn stops(keyframes: &[RelativeKeyframe]) -> Vec<Stop> {
    keyframes.iter().map(Stop::from).collect()
}

impl Refine for CostWeights {
    type Primitive = CostPrimitive;

    /// Only reads the original policy.
    fn fit(&self, original: &KeyframePolicy, _: &[&Segment], _: &mut Counters) -> Result<CostPrimitive, SituError> {
        Ok(CostPrimitive {
            demonstrated: original.mean_keyframes(),
            scatter: original.hmm().emissions.iter().map(|emission| emission.scatter).collect(),
            weights: [0.0; FEATURES],
        })
    }

    fn correct(
        &self,
        primitive: &mut CostPrimitive,
        shown: &Segment,
        counters: &mut Counters,
    ) -> Result<(), SituError> {
        counters.segments_touched += 1;
        let plan = primitive.plan();
        let contacts = contacts(&stops(&primitive.demonstrated));
        let moved = |keyframes: &[RelativeKeyframe]| -> Vec<_> {
            let pairs = primitive.demonstrated.iter().zip(keyframes);
            pairs.map(|(mean, keyframe)| log(&mean.pose, &keyframe.pose)).collect()
        };
        let mut deformed = plan.clone();
        for (i, j) in align(&stops(&plan), &stops(&shown.keyframes)) {
            deformed[i].pose = shown.keyframes[j].pose;
        }
        let planned = features(&contacts, &moved(&plan));
        let shown = features(&contacts, &moved(&deformed));
        match self.rule {
            Rule::Coactive => {
                // A utility is a cost with the other sign.
                let mut utility = primitive.weights.map(|weight| -weight);
                coactive(&mut utility, &shown, &planned);
                primitive.weights = utility.map(|weight| -weight);
            }
            Rule::All | Rule::OneAtATime => {
                let one_at_a_time = self.rule == Rule::OneAtATime;
                let physical = Physical { ranges: &RANGES, gain: GAIN, limit: LIMIT, one_at_a_time };
                physical.correct(&mut primitive.weights, &shown, &planned);
            }
        }
        Ok(())
    }

    fn keyframes(&self, primitive: &CostPrimitive) -> Vec<RefinedKeyframe> {
        let keyframes = primitive.plan().into_iter().zip(&primitive.scatter);
        keyframes.map(|(mean, scatter)| RefinedKeyframe { mean, scatter: *scatter }).collect()
    }
}
