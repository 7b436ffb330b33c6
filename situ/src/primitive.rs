//! Primitives, and what a learner of primitives must be able to do.

use std::fmt::Debug;
use std::sync::Arc;

use crate::demonstration::Pose;
use crate::error::SituError;
use crate::keyframe::frechet::frechet;
use crate::segment::Segment;
use crate::state::State;
use crate::trace::Counters;

/// An initiation classifier `c`, with the confidence that the paper asks of it.
pub trait Initiation {
    /// The probability that the primitive can begin in `state`, 0 to 1: chooses among children.
    fn probability(&self, state: &State) -> f64;

    /// Whether `c(state) = 1`: indexes the model (A1.6).
    fn is_applicable(&self, state: &State) -> bool;

    /// A ball of states, where there is one: outside of it the classifier is never activated. The scan of A1.6 asks all
    /// balls first, many at once. The scales are the same for all classifiers of a model.
    fn ball(&self) -> Option<Ball<'_>> {
        None
    }
}

/// The states whose scaled features are near a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<'a> {
    /// What each feature is divided by.
    pub scales: &'a [f64],
    /// The centre, scaled.
    pub centre: &'a [f64],
    /// The greatest sum of squared differences to the centre.
    pub greatest: f64,
}

/// What Cluster and Find-Policy say together (A2.2 to A2.4; the keyframe instantiation merges them).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clustering {
    /// Candidates, by index, that share the segment's cluster; empty where the segment is alone (`∅`).
    pub matched: Vec<usize>,
    /// Other clusters of two or more candidates: redundant primitives to be merged.
    pub redundant: Vec<Vec<usize>>,
}

/// How far one execution is from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// In position, metres.
    pub metres: f64,
    /// In units of the teacher's own scatter (decision D21).
    pub scatters: f64,
}

/// A learner whose policies, classifiers and calibration can be written and read again. What follows from the data is
/// not written; here it is found again, and what no fit gives is refused in words.
pub trait Restore: Learner {
    /// The number of features of a state.
    fn features(&self) -> usize;

    /// The policy that was fitted to these segments, whole.
    ///
    /// # Errors
    /// What is wrong with it.
    fn restored_policy(&self, read: Self::Policy, segments: &[&Segment]) -> Result<Self::Policy, String>;

    /// The classifier, whole.
    ///
    /// # Errors
    /// What is wrong with it.
    fn restored_classifier(&self, read: Self::Classifier) -> Result<Self::Classifier, String>;

    /// Whether a calibration can be one.
    fn is_calibration(&self, read: &Self::Calibration) -> bool;
}

/// Fits policies and initiation classifiers, and decides which segments belong together.
///
/// The algorithm needs nothing else of a representation: the paper's Find-Policy operator is
/// [`Learner::cluster_and_find`].
pub trait Learner {
    /// A policy `π`.
    type Policy: Clone + Debug + PartialEq;
    /// An initiation classifier `c`.
    type Classifier: Clone + Debug + PartialEq + Initiation;
    /// What is calibrated once, when the originals are taught, and kept in the model (decision D8).
    type Calibration: Clone + Debug + PartialEq;

    /// Fit-Policy (A2.8), and Update-Policy (A2.18) as an exact refit: `segments` share a reference object.
    ///
    /// # Errors
    /// Where no policy can be fitted to these segments.
    fn fit_policy(
        &self,
        segments: &[&Segment],
        calibration: &Self::Calibration,
        counters: &mut Counters,
    ) -> Result<Self::Policy, SituError>;

    /// Fit-Classifier (A2.9) and Update-Classifier (A2.19). Fits to all samples anew.
    ///
    /// # Errors
    /// Where there is no positive sample.
    fn fit_classifier(
        &self,
        positives: &[&State],
        negatives: &[&State],
        counters: &mut Counters,
    ) -> Result<Self::Classifier, SituError>;

    /// Cluster and Find-Policy (A2.2, A2.4): clusters a segment's own policy with those of the candidates, whose
    /// distances `among` them are known: (0,1), (0,2), …, (1,2), … A candidate has a policy for each of its ways; the
    /// nearest counts (decision D20).
    fn cluster_and_find(
        &self,
        own: &Self::Policy,
        candidates: &[Vec<&Self::Policy>],
        among: &[f64],
        calibration: &Self::Calibration,
        counters: &mut Counters,
    ) -> Clustering;

    /// The distance between two policies, in the unit of the calibration's cut; infinite where they cannot be compared.
    /// Where a calibration is given, the value may be rough as long as it is on the right side of the cut.
    fn distance(
        &self,
        left: &Self::Policy,
        right: &Self::Policy,
        calibration: Option<&Self::Calibration>,
        counters: &mut Counters,
    ) -> f64;

    /// Calibrates the cut on the segments of the original demonstrations, one slice for each demonstration.
    ///
    /// # Errors
    /// Where a segment's own model cannot be fitted.
    fn calibrate(&self, originals: &[&[Arc<Segment>]], counters: &mut Counters)
    -> Result<Self::Calibration, SituError>;

    /// Clusters all segments at once, as a full retraining does. Returns one label for each segment: 0, 1, 2, … in
    /// order of first appearance.
    ///
    /// # Errors
    /// Where a segment's own model cannot be fitted.
    fn cluster(
        &self,
        segments: &[&Segment],
        calibration: &Self::Calibration,
        counters: &mut Counters,
    ) -> Result<Vec<usize>, SituError>;

    /// [`Learner::calibrate`] on whole demonstrations, then [`Learner::cluster`] of all their segments. A learner that
    /// compares the same segments for both can compare them once.
    ///
    /// # Errors
    /// Where a segment's own model cannot be fitted.
    fn calibrate_and_cluster(
        &self,
        originals: &[&[Arc<Segment>]],
        counters: &mut Counters,
    ) -> Result<(Self::Calibration, Vec<usize>), SituError> {
        let calibration = self.calibrate(originals, counters)?;
        let pooled: Vec<&Segment> = originals.iter().copied().flatten().map(|segment| &**segment).collect();
        let labels = self.cluster(&pooled, &calibration, counters)?;
        Ok((calibration, labels))
    }

    /// The path of the policy's mean execution, relative to its reference object: always the same number of poses.
    fn path(&self, policy: &Self::Policy) -> Vec<Pose>;

    /// How far the mean execution of one policy is from another's, whatever the noise of either (decisions D18, D21).
    /// The default compares the paths, and knows no scatter: a metre is a metre.
    /// A demonstration that need not be about the difference, but is `beside` it, may have a needless keyframe and lack
    /// another.
    fn displacement(
        &self,
        left: &Self::Policy,
        right: &Self::Policy,
        _: &Self::Calibration,
        _beside: bool,
    ) -> Displacement {
        let metres = frechet(&self.path(left), &self.path(right));
        Displacement { metres, scatters: metres }
    }

    /// The scale of each feature of a state (decision D16): what two worlds are told apart in (decision D20).
    fn scales(&self) -> &[f64];
}
