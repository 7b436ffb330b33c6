//! The crate `hmmlearn-rs` as a peer of `bench/peers/peers.py`, asked and answering as `bench/examples/peers` is.
//!
//! `peer-hmmlearn-rs QUESTION.json SECONDS` fits the model of the question: once without timing it, and then at least
//! three times, until the timed runs took that many seconds together. It writes the values and the nanoseconds of each
//! timed run to standard output as JSON. Reading the numbers and setting the start are not timed.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;
use std::time::Instant;

use hmmlearn::core::{Fitted, Implementation};
use hmmlearn::covariance::{CovarStore, CovarianceType};
use hmmlearn::models::GaussianHmm;
use hmmlearn::models::gaussian::GaussianEm;
use hmmlearn::ndarray::{Array1, Array2, Array3};
use serde::{Deserialize, Serialize};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Timed runs at least.
const LEAST_RUNS: usize = 3;
/// Dimensions of a frame.
const D: usize = 6;

/// Expectation maximisation from a given model of K states: all the iterations, full covariances.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Question {
    initial: Vec<f64>,
    /// Shape (K, K).
    transition: Vec<Vec<f64>>,
    means: Vec<[f64; D]>,
    covariances: Vec<[[f64; D]; D]>,
    /// Of all sequences, one after the other.
    frames: Vec<[f64; D]>,
    /// Frames of each sequence.
    lengths: Vec<usize>,
    iterations: usize,
    /// Added to every element of a state's scatter.
    covariance_prior: f64,
    /// Added, less D, to a state's frames.
    covariance_weight: f64,
    implementation: String,
}

#[derive(Serialize)]
struct Answer {
    values: BTreeMap<&'static str, Vec<f64>>,
    nanoseconds: Vec<f64>,
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, seconds] = arguments.as_slice() else { return Err("expected QUESTION.json SECONDS".into()) };
    let seconds = seconds.parse::<f64>().map_err(|error| format!("SECONDS is `{seconds}`: {error}"))?;
    let file = File::open(path).map_err(|error| format!("{path}: {error}"))?;
    let question: Question =
        serde_json::from_reader(BufReader::new(file)).map_err(|error| format!("{path}: {error}"))?;
    serde_json::to_writer(std::io::stdout().lock(), &answer(&question, seconds)?)?;
    Ok(())
}

fn answer(question: &Question, seconds: f64) -> Outcome<Answer> {
    let frames = Array2::from_shape_vec((question.frames.len(), D), question.frames.concat())?;
    let start = start(question)?;
    let fit = |start: GaussianHmm| start.fit(frames.view(), Some(&question.lengths));
    let fitted = fit(start.clone())?;
    let (mut nanoseconds, mut spent) = (Vec::new(), 0.0);
    while nanoseconds.len() < LEAST_RUNS || spent < seconds {
        let start = black_box(start.clone());
        let before = Instant::now();
        let again = black_box(fit(start));
        let taken = before.elapsed().as_secs_f64();
        again?;
        nanoseconds.push(1e9 * taken);
        spent += taken;
    }
    let score = fitted.score(frames.view(), Some(&question.lengths))?;
    Ok(Answer { values: values(&fitted, score), nanoseconds })
}

fn start(question: &Question) -> Outcome<GaussianHmm> {
    let states = question.means.len();
    Ok(GaussianHmm::new(states)
        .covariance_type(CovarianceType::Full)
        .implementation(question.implementation.parse::<Implementation>()?)
        .init_params("")
        .n_iter(question.iterations)
        .tol(f64::NEG_INFINITY)
        .covars_prior(question.covariance_prior)
        .covars_weight(question.covariance_weight)
        .start_prob(Array1::from_vec(question.initial.clone()))
        .trans_mat(Array2::from_shape_vec((states, states), question.transition.concat())?)
        .means(Array2::from_shape_vec((states, D), question.means.concat())?)
        .covars(CovarStore::Full(Array3::from_shape_vec((states, D, D), question.covariances.concat().concat())?)))
}

/// `score` is the log likelihood of the last model: the monitor has those of the models before it.
fn values(fitted: &Fitted<GaussianEm>, score: f64) -> BTreeMap<&'static str, Vec<f64>> {
    let mut log_likelihoods = fitted.monitor().history.clone();
    log_likelihoods.push(score);
    BTreeMap::from([
        ("log_likelihoods", log_likelihoods),
        ("initial", fitted.start_prob().to_vec()),
        ("transition", fitted.trans_mat().iter().copied().collect()),
        ("means", fitted.emission().means().iter().copied().collect()),
        ("covariances", fitted.emission().covars_full().iter().copied().collect()),
    ])
}
