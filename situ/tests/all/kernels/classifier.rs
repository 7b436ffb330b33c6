//! Where an initiation classifier is applicable (decision D10b).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::{Activation, KeyframeParameters};
use situ::primitive::{Initiation, Learner};
use situ::state::{Feature, Schema, State};
use situ::trace::Counters;

const SCALES: [f64; 2] = [0.1, 2.0];

/// A state is applicable where it is probable and within the radius, and the radius is measured in root mean squares.
#[test]
fn what_is_far_from_every_positive_is_not_applicable() {
    let features = SCALES.iter().map(|scale| Feature { name: format!("of {scale}"), scale: *scale }).collect();
    let schema = Schema::new(features).unwrap();
    for (factor, least, radius) in [(2.0, 0.3, 0.4), (1.0, 0.7, 0.7), (10.0, 0.3, 2.0)] {
        let activation = Activation::Bounded { factor, least };
        let learner = KeyframeLearner::new(&schema, KeyframeParameters { activation, ..KeyframeParameters::default() });
        let at = |x: f64, y: f64| State::new([x * SCALES[0], y * SCALES[1]]);
        // Both positives are 0.2 from their centre, which is the origin.
        let positives = [at(0.2, 0.2), at(-0.2, -0.2)];
        let negatives = [at(40.0, 40.0), at(-40.0, 40.0), at(40.0, -40.0), at(-40.0, -40.0)];
        let slices = (positives.iter().collect::<Vec<_>>(), negatives.iter().collect::<Vec<_>>());
        let classifier = learner.fit_classifier(&slices.0, &slices.1, &mut Counters::default()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut within, mut beyond) = (0, 0);
        for _ in 0..2000 {
            let (x, y) = (rng.random_range(-4.0..4.0), rng.random_range(-4.0..4.0));
            let probable = classifier.probability(&at(x, y)) >= 0.5;
            let near = f64::sqrt((x * x + y * y) / 2.0) <= radius;
            assert_eq!(classifier.is_applicable(&at(x, y)), probable && near, "{x} {y} of {radius}");
            within += usize::from(probable && near);
            beyond += usize::from(probable && !near);
        }
        assert!(within > 20 && beyond > 20, "{within} within, {beyond} beyond {radius}");
    }
}
