//! Policies and classifiers of keyframes that were written and read, made whole.

use super::classifier::KeyframeClassifier;
use super::hmm::{Emission, Hmm};
use super::learner::{Calibration, KeyframeLearner};
use super::parameters::Lift;
use super::policy::KeyframePolicy;
use crate::primitive::Restore;
use crate::segment::Segment;

/// Whether a model has the shape of one, and probabilities.
fn is_hmm(hmm: &Hmm<Emission>, has_gripper: bool) -> bool {
    let states = hmm.states();
    let shares = hmm.initial.iter().chain(&hmm.transition).chain(&hmm.end);
    states > 0
        && [hmm.initial.len(), hmm.end.len()] == [states; 2]
        && hmm.transition.len() == states * states
        && shares.copied().all(|share| (0.0..=1.0).contains(&share))
        && hmm.emissions.iter().all(|emission| emission.gripper.is_some() == has_gripper)
}

impl Restore for KeyframeLearner {
    fn features(&self) -> usize {
        self.features()
    }

    fn restored_policy(&self, read: KeyframePolicy, segments: &[&Segment]) -> Result<KeyframePolicy, String> {
        if segments.iter().any(|segment| segment.reference != read.reference) {
            return Err(format!("it is on `{}`, expected the object of its segments", read.reference));
        }
        if !is_hmm(&read.hmm, true) || !is_hmm(&read.signature, false) {
            return Err("expected two models of a state or more, with probabilities from 0 to 1; one has gripper \
                        commands, the signature has none"
                .to_owned());
        }
        let are_holds = read.holds.iter().all(|hold| hold.is_finite() && *hold >= 0.0);
        if read.holds.len() != read.hmm.states() || !are_holds || !read.log_likelihood.is_finite() {
            return Err("expected seconds of rest, one for each hidden state, and a finite likelihood".to_owned());
        }
        Ok(KeyframePolicy { trajectories: self.trajectories(segments), ..read })
    }

    fn restored_classifier(&self, read: KeyframeClassifier) -> Result<KeyframeClassifier, String> {
        let features = self.features();
        let weights = match read.lift {
            Lift::QuadraticDiagonal => 2 * features,
            Lift::Linear => features,
            Lift::Distance => 1,
        };
        let units = read.units.iter().flat_map(|(origin, unit)| [origin, unit]);
        let numbers = read.fit.weights.iter().chain([&read.fit.intercept]).chain(&read.centre).chain(units);
        let shape = [read.fit.weights.len(), read.centre.len(), read.units.len()];
        if shape != [weights, features, features] || !numbers.copied().all(f64::is_finite) {
            return Err(format!(
                "expected finite numbers: {weights} weights, a centre and units of {features} features"
            ));
        }
        let least = read.units.iter().map(|(_, unit)| *unit).fold(f64::INFINITY, f64::min);
        if least <= 0.0 || read.radius.is_nan() || read.radius < 0.0 || read.most.is_nan() || read.most < 0.0 {
            return Err("expected units above 0, and bounds of 0 or more".to_owned());
        }
        Ok(KeyframeClassifier { scales: self.shared_scales(), ..read })
    }

    fn is_calibration(&self, read: &Calibration) -> bool {
        let is_scatter = |value: f64| value.is_finite() && value > 0.0;
        let deviations = [read.scatter.contact, read.scatter.free];
        read.cut.is_finite()
            && deviations
                .iter()
                .all(|deviation| is_scatter(deviation.position) && deviation.rotation.iter().copied().all(is_scatter))
    }
}
