//! `cost_weights`: a primitive as the minimiser of a cost, whose weights are moved by corrections (Jain et al. 2013;
//! Bajcsy et al. 2018).
//!
//! The executed keyframes minimise the distance to the demonstrated ones plus weighted features ([`features`]). A
//! correction moves the weights by the rule of the paper ([`Rule`]); then the plan is solved anew. The demonstrated
//! keyframes are the means of the original policy, and all weights begin at 0, so the uncorrected primitive is the
//! original one.
//!
//! What is shown is aligned with the plan ([`super::alignment`]). A planned keyframe with a partner is *deformed* to
//! it; one without a partner stays as planned. The result is `ȳ` (Jain) or `ξ_D` (Bajcsy); the plan itself is `y` or
//! `ξ_R`. Shown keyframes without a partner have no effect, because no feature can express them. Grip commands and
//! rests are those of the original.

pub mod features;
mod rule;

use nalgebra::Matrix6;
use serde::Serialize;

pub use features::{FEATURES, Features};
pub use rule::{Physical, Rule, coactive};

use super::alignment::{Stop, align, contacts};
use super::refine::{Refine, RefinedKeyframe};
use crate::error::SituError;
use crate::keyframe::policy::KeyframePolicy;
use crate::keyframe::pose::{exp, log};
use crate::segment::{RelativeKeyframe, Segment};
use crate::trace::Counters;

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
        let displacements = features::plan(&contacts(&stops(&self.demonstrated)), &self.weights);
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
        let planned = features::features(&contacts, &moved(&plan));
        let shown = features::features(&contacts, &moved(&deformed));
        match self.rule {
            Rule::Coactive => {
                // A utility is a cost with the other sign.
                let mut utility = primitive.weights.map(|weight| -weight);
                coactive(&mut utility, &shown, &planned);
                primitive.weights = utility.map(|weight| -weight);
            }
            Rule::All | Rule::OneAtATime => {
                let one_at_a_time = self.rule == Rule::OneAtATime;
                let physical = Physical { ranges: &features::RANGES, gain: GAIN, limit: LIMIT, one_at_a_time };
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
