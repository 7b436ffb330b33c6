//! The decisions about the kernels. Each is a named parameter with its default and its ablation.

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::hmm::HmmParameters;
use super::logistic::LogisticParameters;
use super::pose::METRES_PER_RADIAN;
use super::scatter::ScatterParameters;

/// Decision D5: what a policy is compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// The two signatures: both are models over interpolated keyframes.
    Signatures,
    /// The literal reading: the policy's model over keyframes, and the segment's model over its interpolation.
    PolicyAgainstSignature,
}

/// Decision D7: the estimator of the divergence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Divergence {
    /// The likelihood of each other's training trajectories. Deterministic: nothing is sampled.
    CrossLikelihood,
    /// Monte Carlo with this many sequences in each direction. Every pair uses the same random numbers.
    MonteCarlo(usize),
    /// The transient upper bound.
    TransientBound,
}

/// Decision D8: the height at which the dendrogram is cut, calibrated when the originals are taught.
///
/// It is `factor` × the 95th percentile of the distances between segments of the same role, pooled with `prior_copies`
/// of `prior`, and then clamped. With a single original it is `single`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The factor of the percentile.
    pub factor: f64,
    /// The prior distance that is pooled.
    pub prior: f64,
    /// How many copies of the prior are pooled.
    pub prior_copies: usize,
    /// The least cut.
    pub least: f64,
    /// The greatest cut.
    pub greatest: f64,
    /// The cut with a single original demonstration.
    pub single: f64,
}

/// Decision D25: what becomes of a keyframe that is no keyframe of the skill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spurious {
    /// A hidden state explains one keyframe of a segment; its others are left out.
    LeftOut,
    /// It is averaged with the others, as printed.
    Averaged,
}

/// Decision D2b: what the initiation classifier is linear in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lift {
    /// The scaled features and their squares.
    QuadraticDiagonal,
    /// The scaled features.
    Linear,
    /// Only the mean squared scaled distance to the centre of the positives.
    Distance,
}

/// Decision D16: the unit in which a classifier measures each feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standardisation {
    /// The schema's fixed scales, for every classifier.
    Fixed,
    /// The fixed scales, made smaller if the primitive's own start states vary less. The unit is then the standard
    /// deviation of the positives about their centre, where the fixed scale counts as so many samples. With a single
    /// positive, it is that of the negatives about their own centre. Features are measured from the centre of the
    /// positives. Only the primitive's own samples are read, so an update stays local.
    Within {
        /// The number of samples that the fixed scale counts as.
        prior: f64,
        /// A feature counts so many units at the most. Something that has nothing to do with a primitive, and that
        /// stands where it never stood before, would else outweigh all the others.
        most: f64,
    },
}

impl Standardisation {
    /// The greatest number of units that a feature counts.
    pub const fn most(self) -> f64 {
        match self {
            Self::Fixed => f64::INFINITY,
            Self::Within { most, .. } => most,
        }
    }
}

/// Decision D10b: when a classifier is activated in the index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Activation {
    /// The probability is at least 0.5, as printed.
    Probability,
    /// The probability is at least 0.5, and the state is near the centre of the positives. Near means: the root mean
    /// square scaled distance is at most `factor` × the 95th percentile of the positives' own distances, or at most
    /// `least`.
    Bounded {
        /// The factor of the percentile.
        factor: f64,
        /// The least radius, in scaled units. With one positive the percentile is 0.
        least: f64,
    },
}

/// The parameters of [`super::learner::KeyframeLearner`].
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeParameters {
    /// The kernel of the policies (D12 to D14).
    pub policy: HmmParameters,
    /// The kernel of the signatures (D12, D13).
    pub signature: HmmParameters,
    /// The points of a signature's interpolation (D5).
    pub signature_points: usize,
    /// The hidden states of a signature (D5).
    pub signature_states: usize,
    /// The length that a radian counts, metres (D5).
    pub metres_per_radian: f64,
    /// What is compared (D5).
    pub compared: Compared,
    /// Whether policies of different reference objects can be compared (D6).
    pub across_references: bool,
    /// Whether a policy that ends with an open gripper can be compared with one that ends with a closed gripper (D6b).
    /// A pick and a place on one object lead along much the same poses.
    pub across_grips: bool,
    /// The estimator (D7).
    pub divergence: Divergence,
    /// The cut (D8).
    pub cut: Cut,
    /// Whether the symmetry of the hand is heeded, where the schema has one (D24).
    pub symmetry: bool,
    /// What becomes of spurious keyframes (D25).
    pub spurious: Spurious,
    /// The teacher's own scatter (D21).
    pub scatter: ScatterParameters,
    /// What the classifiers are linear in (D2b).
    pub lift: Lift,
    /// The units of the features (D16).
    pub standardisation: Standardisation,
    /// The kernel of the classifiers (D2c).
    pub logistic: LogisticParameters,
    /// When a classifier is activated (D10b).
    pub activation: Activation,
    /// The seed of the Monte Carlo divergences (D7). All pairs share the random numbers, so they differ only by their
    /// models, and a distance does not depend on earlier comparisons.
    pub seed: u64,
}

impl Default for KeyframeParameters {
    /// The parameters of `situ`.
    fn default() -> Self {
        // D12: with a smaller rotation scale, noise dominates the divergence.
        let signature =
            HmmParameters { position_floor: 0.02, rotation_floor: [9.0 * PI / 180.0; 3], ..HmmParameters::default() };
        Self {
            policy: HmmParameters::default(),
            signature,
            signature_points: 20,
            signature_states: 6,
            metres_per_radian: METRES_PER_RADIAN,
            compared: Compared::Signatures,
            across_references: false,
            across_grips: false,
            divergence: Divergence::CrossLikelihood,
            cut: Cut { factor: 1.5, prior: 5.0, prior_copies: 3, least: 2.0, greatest: 20.0, single: 8.0 },
            symmetry: true,
            spurious: Spurious::LeftOut,
            scatter: ScatterParameters::default(),
            lift: Lift::QuadraticDiagonal,
            standardisation: Standardisation::Within { prior: 0.1, most: 3.0 },
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
            spurious: Spurious::Averaged,
            // The paper gives no number. With 1000, updates of the literal reading took up to 23 s on ten primitives.
            divergence: Divergence::MonteCarlo(30),
            lift: Lift::Linear,
            standardisation: Standardisation::Fixed,
            activation: Activation::Probability,
            ..Self::default()
        }
    }
}
