//! What the benches of the kernels work on, the timed ones and the counted ones: a kernel, its input, and the check of
//! its result.
//!
//! Everything is drawn from seeds, of the size that an update meets. `checked` makes a kernel, runs it once and checks
//! its result, because the cost of a wrong result is worth nothing.

use std::collections::BTreeSet;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::demonstration::Pose;
use situ::keyframe::divergence::cross_likelihood;
use situ::keyframe::hmm::{Hmm, HmmFit, HmmParameters, Observation};
use situ::keyframe::interpolate::resample;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::logistic::{self, LogisticFit, LogisticParameters, Path};
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::pose::{Tangent, exp};
use situ::place::{NodeId, SampleId, Samples};
use situ::primitive::Learner;
use situ::random::{standard_normal, stream};
use situ::segmentation::by_reference_object;
use situ::state::State;
use situ::task_model::{History, TaskModel};
use situ::trace::Counters;
use situ_bench::synthetic::{Automaton, Parameters};

/// Sequences that a model is fitted to.
const SEQUENCES: usize = 20;
/// The keyframes of the demonstrated path: position, metres, and turn about the vertical, radians.
const KEYFRAMES: [([f64; 3], f64); 5] = [
    ([0.0, 0.0, 0.25], 0.0),
    ([0.0, 0.0, 0.05], 0.1),
    ([0.1, 0.0, 0.15], 0.4),
    ([0.2, 0.1, 0.15], 0.8),
    ([0.2, 0.2, 0.05], 0.9),
];
/// Standard deviation of a demonstrated position, metres, and rotation, radians: a careful teacher.
const NOISE: (f64, f64) = (0.004, 0.02);
/// How far the path of the second policy is from that of the first, metres: a near-variant.
const APART: f64 = 0.08;
/// Standard deviation of the noise of a sample's log odds.
const LABEL_NOISE: f64 = 0.5;
/// Share of the samples whose label a regression must find again.
const LEARNED: f64 = 0.9;
/// The relative difference of two numbers that differ by rounding alone.
const ROUNDING: f64 = 1e-9;
/// The greatest difference of the weights that two paths of a regression find. Each path stops at its tolerance.
const SAME_MINIMUM: f64 = 1e-6;
/// Classifiers that are screened.
const CLASSIFIERS: usize = 1000;
/// Negatives of each, and how many nodes they are apart. That is no multiple of the number of cells, whose nodes look
/// alike.
const NEGATIVES: (usize, usize) = (8, 97);
/// The most classifiers that apply in one state. The automaton's cells hold two nodes each.
const APPLICABLE: usize = 4;
/// The seed of everything drawn.
const SEED: u64 = 1;

/// Interpolated demonstrations of one path that is moved by so many metres. A signature is fitted to such sequences.
fn trajectories(name: &str, moved: f64) -> Vec<Vec<Observation>> {
    let parameters = KeyframeParameters::default();
    let mut rng = ChaCha8Rng::seed_from_u64(stream(SEED, name));
    let mut keyframe = |(position, turn): ([f64; 3], f64)| {
        let place = Translation3::from(Vector3::from(position) + Vector3::new(0.0, moved, 0.0));
        let mean = Pose::from_parts(place, UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, turn)));
        let deviation = |axis: usize| if axis < 3 { NOISE.0 } else { NOISE.1 };
        exp(&mean, &Tangent::from_fn(|axis, _| deviation(axis) * standard_normal(&mut rng)))
    };
    let mut sequence = || {
        let keyframes = KEYFRAMES.map(&mut keyframe);
        let poses = resample(&keyframes, parameters.signature_points, parameters.metres_per_radian);
        poses.into_iter().map(|pose| Observation { pose, gripper: None }).collect()
    };
    (0..SEQUENCES).map(|_| sequence()).collect()
}

/// A hidden Markov model to be fitted: 6 states, 20 sequences of 20 poses, 20 iterations.
pub(crate) struct Fitting {
    sequences: Vec<Vec<Observation>>,
    states: usize,
    parameters: HmmParameters,
}

impl Fitting {
    fn of(sequences: Vec<Vec<Observation>>) -> Self {
        let KeyframeParameters { signature_states: states, signature, .. } = KeyframeParameters::default();
        // Without a tolerance the fit makes exactly as many iterations as it may.
        Self { sequences, states, parameters: HmmParameters { tolerance: 0.0, ..signature } }
    }

    /// The fit, with so many iterations more.
    pub(crate) fn checked(more_iterations: usize) -> Self {
        let mut fitting = Self::of(trajectories("policy", 0.0));
        fitting.parameters.max_iterations += more_iterations;
        let HmmFit { iterations, log_likelihoods, .. } = fitting.run();
        assert_eq!(iterations, fitting.parameters.max_iterations, "all iterations are made");
        let (first, last) = (log_likelihoods[0], log_likelihoods[iterations]);
        assert!(last.is_finite() && last > first, "the fit explains its data better than its start: {first}, {last}");
        fitting
    }

    /// Fits.
    pub(crate) fn run(&self) -> HmmFit {
        let sequences: Vec<&[Observation]> = self.sequences.iter().map(Vec::as_slice).collect();
        Hmm::fit(&sequences, self.states, &self.parameters).expect("the sequences are sound")
    }
}

/// The sequences of the fit to be scored by the model that was fitted to them.
pub(crate) struct Scoring {
    hmm: Hmm,
    sequences: Vec<Vec<Observation>>,
}

impl Scoring {
    /// The scoring.
    pub(crate) fn checked() -> Self {
        let fitting = Fitting::checked(0);
        let HmmFit { hmm, log_likelihoods, .. } = fitting.run();
        let scoring = Self { hmm, sequences: fitting.sequences };
        let (found, expected) = (scoring.run(), log_likelihoods[log_likelihoods.len() - 1]);
        assert!(
            (found - expected).abs() <= ROUNDING * expected.abs(),
            "the fit scored its data {expected}, not {found}"
        );
        scoring
    }

    /// The log likelihood of all of them.
    pub(crate) fn run(&self) -> f64 {
        self.hmm.total_log_likelihood(&self.sequences)
    }
}

/// The divergence of two policies, a path and its near-variant.
pub(crate) struct Divergence {
    left: (Hmm, Vec<Vec<Observation>>),
    right: (Hmm, Vec<Vec<Observation>>),
}

impl Divergence {
    /// The divergence.
    pub(crate) fn checked() -> Self {
        let [left, right] = [("policy", 0.0), ("variant", APART)].map(|(name, moved)| {
            let fitting = Fitting::of(trajectories(name, moved));
            (fitting.run().hmm, fitting.sequences)
        });
        let divergence = Self { left, right };
        let (left, right) = (&divergence.left, &divergence.right);
        let between = divergence.run();
        let swapped = cross_likelihood(&right.0, &right.1, &left.0, &left.1);
        assert!(between > 1.0 && (between - swapped).abs() <= ROUNDING * between, "{between} and {swapped}");
        assert_eq!(cross_likelihood(&left.0, &left.1, &left.0, &left.1), 0.0, "a policy is no distance from itself");
        divergence
    }

    /// The cross-likelihood divergence, nats for each frame.
    pub(crate) fn run(&self) -> f64 {
        let (left, right) = (&self.left, &self.right);
        cross_likelihood(&left.0, &left.1, &right.0, &right.1)
    }
}

/// A logistic regression to be fitted.
pub(crate) struct Regression {
    rows: Vec<Vec<f64>>,
    labels: Vec<bool>,
    parameters: LogisticParameters,
}

impl Regression {
    /// A regression of so many samples on so many features, solved in the features' dimension or in the samples'.
    pub(crate) fn checked(samples: usize, features: usize, path: Path) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(stream(SEED, &format!("{samples} × {features}")));
        let mut normals = |count: usize| (0..count).map(|_| standard_normal(&mut rng)).collect::<Vec<f64>>();
        // Rows are divided by the root of their length, as the classifiers do it.
        let shrink = 1.0 / libm::sqrt(features as f64);
        let truth = normals(features);
        let rows: Vec<Vec<f64>> =
            (0..samples).map(|_| normals(features).into_iter().map(|value| shrink * value).collect()).collect();
        let noise = normals(samples);
        let odds = |row: &[f64]| row.iter().zip(&truth).map(|(value, weight)| value * weight).sum::<f64>();
        let labels = rows.iter().zip(&noise).map(|(row, noise)| odds(row) + LABEL_NOISE * noise > 0.0).collect();
        let parameters = LogisticParameters { path, ..LogisticParameters::default() };
        let regression = Self { rows, labels, parameters };
        let fit = regression.run();
        let rows = regression.rows();
        let (_, gradient) = logistic::objective(&rows, &regression.labels, &parameters, &fit.weights, fit.intercept);
        let steepest = gradient.iter().fold(0.0, |greatest: f64, component| greatest.max(component.abs()));
        // The fit's own gradient is another sum of the same terms.
        assert!(fit.converged && steepest <= 2.0 * parameters.tolerance, "a gradient of {steepest} is left");
        let right = rows.iter().zip(&regression.labels).filter(|(row, label)| (fit.log_odds(row) > 0.0) == **label);
        assert!(right.count() as f64 >= LEARNED * samples as f64, "the labels are learned");
        let path = if path == Path::Dual { Path::Primal } else { Path::Dual };
        let other = LogisticParameters { path, ..parameters };
        let other = logistic::fit(&rows, &regression.labels, &other).expect("the rows are sound");
        let apart = fit.weights.iter().zip(&other.weights).map(|(left, right)| (left - right).abs());
        assert!(apart.fold(0.0, f64::max) <= SAME_MINIMUM, "both paths find one minimum");
        regression
    }

    fn rows(&self) -> Vec<&[f64]> {
        self.rows.iter().map(Vec::as_slice).collect()
    }

    /// Fits.
    pub(crate) fn run(&self) -> LogisticFit {
        logistic::fit(&self.rows(), &self.labels, &self.parameters).expect("the rows are sound")
    }
}

/// A task model of 1000 nodes, each of whose classifiers is asked whether it applies in a state (A1.6).
pub(crate) struct Screening {
    model: TaskModel<KeyframeLearner>,
    state: State,
}

impl Screening {
    /// The screening. Each node of the model has a classifier of its own. All nodes have one policy, because policies
    /// are not screened.
    pub(crate) fn checked() -> Self {
        let automaton = Automaton::new(Parameters::of(CLASSIFIERS, SEED)).expect("the parameters are in range");
        let learner = KeyframeLearner::new(automaton.schema(), KeyframeParameters::default());
        let mut counters = Counters::default();
        let calibration = learner.calibrate(&[], &mut counters).expect("nothing to refuse");
        let mut model = TaskModel::new(calibration);
        // The originals that leave no optional node out visit the nodes in order.
        let whole = automaton.originals().iter().step_by(2);
        let starts: Vec<_> =
            whole.map(|original| model.begin(History::new(original, by_reference_object(original), None))).collect();
        let segment = &**model.segment(starts[0][0]);
        let policy = learner.fit_policy(&[segment], &calibration, &mut counters).expect("a segment");
        for node in 0..CLASSIFIERS {
            let segments: BTreeSet<_> = starts.iter().map(|ids| ids[node]).collect();
            let others = (1..=NEGATIVES.0).map(|step| starts[0][(node + step * NEGATIVES.1) % CLASSIFIERS]);
            let samples = Samples {
                positives: segments.iter().copied().map(SampleId::Start).collect(),
                negatives: others.map(SampleId::Start).collect(),
            };
            let classifier = model.fit_samples(&learner, &samples, &mut counters).expect("there are positives");
            let way = model.way(segments.clone(), policy.clone());
            let id = model.add_node(segments.clone(), vec![way], samples, classifier);
            segments.into_iter().for_each(|segment| model.place(segment, id));
        }
        let node = CLASSIFIERS / 2;
        let state = model.segment(starts[0][node]).start.clone();
        let screening = Self { model, state };
        let found = screening.run();
        let own = NodeId(node as u32);
        assert!(found.contains(&own) && found.len() <= APPLICABLE, "{own} applies, and few others do: {found:?}");
        screening
    }

    /// The nodes that apply.
    pub(crate) fn run(&self) -> Vec<NodeId> {
        self.model.applicable(&self.state, &mut Counters::default())
    }
}
