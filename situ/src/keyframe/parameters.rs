//! The kernels' decisions, each a named parameter with its default and its ablation.

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::hmm::HmmParameters;
use super::logistic::LogisticParameters;

/// Decision D5: what a policy is compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Compared {
    /// Signature against signature: both are models over interpolated keyframes.
    Signatures,
    /// The literal reading: the policy's model over keyframes against the segment's model over its interpolation.
    PolicyAgainstSignature,
}

/// Decision D7: the estimator of the divergence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Divergence {
    /// The likelihood of each other's training trajectories: deterministic, no sampling.
    CrossLikelihood,
    /// Monte Carlo with this many sequences a direction, every pair with the same random numbers.
    MonteCarlo(usize),
    /// The transient upper bound.
    TransientBound,
}

/// Decision D8: the height at which the dendrogram is cut.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cut {
    /// Calibrated when the originals are taught: `factor` × the 95th percentile of the distances between role-matched
    /// segments, pooled with `prior_copies` of `prior`, clamped; `single` where there is a single original.
    Calibrated {
        /// Multiplies the percentile.
        factor: f64,
        /// The pooled prior distance.
        prior: f64,
        /// How often the prior is pooled.
        prior_copies: usize,
        /// The least cut.
        least: f64,
        /// The greatest cut.
        greatest: f64,
        /// The cut with a single original demonstration.
        single: f64,
    },
    /// Fixed: for sweeps.
    Fixed(f64),
}

/// Decision D2b: what the initiation classifier is linear in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lift {
    /// The scaled features and their squares.
    QuadraticDiagonal,
    /// The scaled features.
    Linear,
    /// The mean squared scaled distance to the centre of the positives, alone.
    Distance,
}

/// Decision D16: the unit in which a classifier measures each feature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Standardisation {
    /// The schema's fixed scales, for every classifier.
    Fixed,
    /// The fixed scales, shrunk where the primitive's own start states vary less: the standard deviation about the
    /// centre of the positives (of positives and negatives about theirs, where there is one positive), the fixed scale
    /// counting as so many samples. Features are measured from that centre. It reads the primitive's own samples alone,
    /// so an update stays local.
    Within {
        /// Samples that the fixed scale counts.
        prior: f64,
    },
}

/// Decision D10b: when a classifier is activated, for indexing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Activation {
    /// Probability at least 0.5, as printed.
    Probability,
    /// Probability at least 0.5 and, in root mean square scaled distance, no further from the centre of the positives
    /// than `factor` × their own 95th percentile, and never less than `least`.
    Bounded {
        /// Multiplies the percentile.
        factor: f64,
        /// The least radius, in scaled units; a node with one positive has a percentile of 0.
        least: f64,
    },
}

/// Decision D14: how many hidden states a policy has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum States {
    /// The median number of keyframes of its segments.
    Median,
    /// The number between the fewest and the most keyframes with the lowest Bayesian information criterion.
    Bic,
}

/// The parameters of [`super::learner::KeyframeLearner`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeyframeParameters {
    /// Kernel of the policies (D12 to D14).
    pub policy: HmmParameters,
    /// Hidden states of a policy (D14).
    pub states: States,
    /// Kernel of the signatures (D12, D13).
    pub signature: HmmParameters,
    /// Points of a signature's interpolation (D5).
    pub signature_points: usize,
    /// Hidden states of a signature (D5).
    pub signature_states: usize,
    /// Length that a radian counts, metres (D5).
    pub metres_per_radian: f64,
    /// What is compared (D5).
    pub compared: Compared,
    /// Whether policies of different reference objects can be compared (D6).
    pub across_references: bool,
    /// Whether policies that leave the gripper in different states, open and closed, can be compared (D6b): a pick and
    /// a place on one object lead along much the same poses.
    pub across_grips: bool,
    /// The estimator (D7).
    pub divergence: Divergence,
    /// The cut (D8).
    pub cut: Cut,
    /// What the classifiers are linear in (D2b).
    pub lift: Lift,
    /// Units of the features (D16).
    pub standardisation: Standardisation,
    /// Kernel of the classifiers (D2c).
    pub logistic: LogisticParameters,
    /// Activation of a classifier (D10b).
    pub activation: Activation,
    /// Seed of the Monte Carlo divergences (D7). Common random numbers: pairs differ by their models alone, and a
    /// distance does not depend on which pairs were compared before.
    pub seed: u64,
}

impl Default for KeyframeParameters {
    /// The parameters of `situ`.
    fn default() -> Self {
        // D12: a smaller rotation scale lets noise dominate the divergence.
        let signature =
            HmmParameters { position_floor: 0.02, rotation_floor: 9.0 * PI / 180.0, ..HmmParameters::default() };
        Self {
            policy: HmmParameters::default(),
            states: States::Median,
            signature,
            signature_points: 20,
            signature_states: 6,
            metres_per_radian: 0.1,
            compared: Compared::Signatures,
            across_references: false,
            across_grips: false,
            divergence: Divergence::CrossLikelihood,
            cut: Cut::Calibrated { factor: 1.5, prior: 5.0, prior_copies: 3, least: 2.0, greatest: 10.0, single: 8.0 },
            lift: Lift::QuadraticDiagonal,
            standardisation: Standardisation::Within { prior: 0.1 },
            logistic: LogisticParameters::default(),
            activation: Activation::Bounded { factor: 2.0, least: 0.3 },
            seed: 0,
        }
    }
}

impl KeyframeParameters {
    /// The kernels as the paper prints them: D2b linear, D16 fixed, D5 literal, D6 across objects and grips, D7 by
    /// sampling, D10b p ≥ 0.5.
    pub fn literal() -> Self {
        Self {
            compared: Compared::PolicyAgainstSignature,
            across_references: true,
            across_grips: true,
            // The paper names no number. With 1000, updates of the literal reading took up to 23 s on ten primitives.
            divergence: Divergence::MonteCarlo(30),
            lift: Lift::Linear,
            standardisation: Standardisation::Fixed,
            activation: Activation::Probability,
            ..Self::default()
        }
    }
}
