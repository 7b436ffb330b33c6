//! Our side of `bench/peers/peers.py`, which times other libraries beside these kernels on the same numbers.
//!
//! `peers QUESTION.json SECONDS` runs the kernel that the question names: once without timing it, and then at least
//! three times, until the timed runs took that many seconds together. It writes the result and the nanoseconds of each
//! timed run to standard output as JSON. Reading the numbers and making poses of them is not timed.

mod peak;
mod physics;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;

use nalgebra::Matrix6;
use serde::{Deserialize, Serialize};
use situ::demonstration::Pose;
use situ::keyframe::hmm::{Emission, Hmm, HmmParameters, Observation};
use situ::keyframe::logistic::{self, LogisticParameters};
use situ::keyframe::pose::{Tangent, exp, log};
use situ::place::NodeId;
use situ::primitive::Ball;
use situ::state::State;
use situ::task_model::screen::Screen;
use situ_bench::cost::timed;

use peak::Peak;
use physics::Scene;

/// A pose as the script has it: metres, then the rotation vector in radians.
type Frame = [f64; 6];
type Values = BTreeMap<&'static str, Vec<f64>>;
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Timed runs at least.
const LEAST_RUNS: usize = 3;

/// A model of K states.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    initial: Vec<f64>,
    /// Shape (K, K).
    transition: Vec<Vec<f64>>,
    end: Vec<f64>,
    means: Vec<Frame>,
    covariances: Vec<[[f64; 6]; 6]>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Question {
    /// Expectation maximisation from a given model, with all iterations and no floor under the chain's probabilities.
    Fit {
        start: Model,
        sequences: Vec<Vec<Frame>>,
        iterations: usize,
        prior_weight: f64,
        position_floor: f64,
        rotation_floor: f64,
    },
    /// The log likelihood of every set of sequences under every model.
    Score { models: Vec<Model>, sets: Vec<Vec<Vec<Frame>>> },
    /// A logistic regression on hard labels, all samples alike.
    Regress { rows: Vec<Vec<f64>>, labels: Vec<bool>, ridge: f64, tolerance: f64 },
    /// The nodes whose ball holds a row: the sum of squared differences to the row is at most `greatest`.
    Screen { centres: Vec<Vec<f64>>, greatest: f64, row: Vec<f64> },
    /// The additions and multiplications that the core does in a run that does nothing else.
    Peak { fused: bool },
    /// What moves where in a scene of rigid bodies.
    Physics(Scene),
}

#[derive(Serialize)]
struct Answer {
    values: Values,
    nanoseconds: Vec<f64>,
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, seconds] = arguments.as_slice() else { return Err("expected QUESTION.json SECONDS".into()) };
    let seconds = seconds.parse::<f64>().map_err(|error| format!("SECONDS is `{seconds}`: {error}"))?;
    let file = File::open(path).map_err(|error| format!("{path}: {error}"))?;
    let question = serde_json::from_reader(BufReader::new(file)).map_err(|error| format!("{path}: {error}"))?;
    let (values, nanoseconds) = answer(question, seconds)?;
    serde_json::to_writer(std::io::stdout().lock(), &Answer { values, nanoseconds })?;
    Ok(())
}

fn answer(question: Question, seconds: f64) -> Outcome<(Values, Vec<f64>)> {
    match question {
        Question::Fit { start, sequences, iterations, prior_weight, position_floor, rotation_floor } => {
            let start = start.hmm()?;
            let sequences: Vec<Vec<Observation>> = sequences.iter().map(|sequence| observed(sequence)).collect();
            let sequences: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
            let parameters = HmmParameters {
                position_floor,
                rotation_floor: [rotation_floor; 3],
                prior_weight,
                transition_floor: 0.0,
                skip: true,
                max_iterations: iterations,
                tolerance: 0.0,
                ..HmmParameters::default()
            };
            let (fit, nanoseconds) = measured(seconds, || start.refit(&sequences, &parameters))?;
            let mut values = values_of(&fit.hmm);
            values.insert("log_likelihoods", fit.log_likelihoods);
            Ok((values, nanoseconds))
        }
        Question::Score { models, sets } => {
            let models: Vec<Hmm> = models.into_iter().map(Model::hmm).collect::<Outcome<_>>()?;
            let sets: Vec<Vec<Vec<Observation>>> =
                sets.iter().map(|set| set.iter().map(|sequence| observed(sequence)).collect()).collect();
            let (log_likelihoods, nanoseconds) = measured(seconds, || {
                let pairs = sets.iter().flat_map(|set| models.iter().map(move |model| (set, model)));
                Ok::<_, Box<dyn Error>>(pairs.map(|(set, model)| model.total_log_likelihood(set)).collect())
            })?;
            Ok((Values::from([("log_likelihoods", log_likelihoods)]), nanoseconds))
        }
        Question::Regress { rows, labels, ridge, tolerance } => {
            let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
            // Targets must be inside (0, 1). These differ from its ends by the last bit, so the objective is that of
            // hard labels.
            let (positive, negative) = (1.0 - 0.5 * f64::EPSILON, f64::MIN_POSITIVE);
            let default = LogisticParameters::default();
            let parameters = LogisticParameters { ridge, balanced: false, positive, negative, tolerance, ..default };
            let (fit, nanoseconds) = measured(seconds, || logistic::fit(&rows, &labels, &parameters))?;
            Ok((Values::from([("weights", fit.weights), ("intercept", vec![fit.intercept])]), nanoseconds))
        }
        Question::Screen { centres, greatest, row } => screened(&centres, greatest, row, seconds),
        Question::Peak { fused } => {
            let (operations, nanoseconds) = measured(seconds, || Ok::<_, Box<dyn Error>>(Peak { fused }.run()))?;
            Ok((Values::from([("operations", vec![operations])]), nanoseconds))
        }
        Question::Physics(scene) => scene.answer(seconds),
    }
}

/// The nodes whose ball of this greatest distance holds the row.
fn screened(centres: &[Vec<f64>], greatest: f64, row: Vec<f64>, seconds: f64) -> Outcome<(Values, Vec<f64>)> {
    if centres.iter().any(|centre| centre.len() != row.len()) {
        return Err("the centres and the row are not of one shape".into());
    }
    let (scales, state) = (vec![1.0; row.len()], State::new(row));
    let mut screen = Screen::default();
    for (node, centre) in centres.iter().enumerate() {
        screen.set(NodeId(u32::try_from(node)?), Some(Ball { scales: &scales, centre, greatest }));
    }
    let (passing, nanoseconds) =
        measured(seconds, || Ok::<_, Box<dyn Error>>(black_box(&screen).passing(black_box(&state))))?;
    let passing = passing.into_iter().map(|node| f64::from(node.0)).collect();
    Ok((Values::from([("passing", passing)]), nanoseconds))
}

/// The result of a kernel, and the nanoseconds of each timed run.
fn measured<T, E>(seconds: f64, mut kernel: impl FnMut() -> Result<T, E>) -> Result<(T, Vec<f64>), E> {
    measured_from(seconds, || (), |()| kernel())
}

/// The same for a kernel that uses up what it starts from. That is made for each run, and its making is not timed.
fn measured_from<S, T, E>(
    seconds: f64,
    mut start: impl FnMut() -> S,
    mut kernel: impl FnMut(S) -> Result<T, E>,
) -> Result<(T, Vec<f64>), E> {
    let value = kernel(start())?;
    let (mut nanoseconds, mut spent) = (Vec::new(), 0.0);
    while nanoseconds.len() < LEAST_RUNS || spent < seconds {
        let from = start();
        let (again, taken) = timed(|| black_box(kernel(from)));
        again?;
        nanoseconds.push(1e9 * taken);
        spent += taken;
    }
    Ok((value, nanoseconds))
}

fn pose(frame: &Frame) -> Pose {
    exp(&Pose::identity(), &Tangent::from(*frame))
}

fn observed(sequence: &[Frame]) -> Vec<Observation> {
    sequence.iter().map(|frame| Observation { pose: pose(frame), gripper: None }).collect()
}

impl Model {
    fn hmm(self) -> Outcome<Hmm> {
        let Self { initial, transition, end, means, covariances } = self;
        let states = means.len();
        let square = transition.len() == states && transition.iter().all(|row| row.len() == states);
        if !square || [initial.len(), end.len(), covariances.len()] != [states; 3] {
            return Err("the parts of a model are not of one number of states".into());
        }
        let emission = |(mean, covariance): (&Frame, &[[f64; 6]; 6])| {
            let covariance = Matrix6::from_fn(|row, column| covariance[row][column]);
            Emission::new(pose(mean), covariance, Matrix6::zeros(), None)
        };
        let emissions = means.iter().zip(&covariances).map(emission).collect::<Result<_, _>>()?;
        Ok(Hmm { initial, transition: transition.concat(), end, emissions })
    }
}

fn values_of(hmm: &Hmm) -> Values {
    let means = hmm.emissions.iter().flat_map(|emission| log(&Pose::identity(), &emission.mean).data.0[0]);
    let covariances = hmm.emissions.iter().flat_map(|emission| emission.covariance.data.0.concat());
    Values::from([
        ("initial", hmm.initial.clone()),
        ("transition", hmm.transition.clone()),
        ("end", hmm.end.clone()),
        ("means", means.collect()),
        ("covariances", covariances.collect()),
    ])
}
