//! The model: inference against the sum over all paths, and what expectation maximisation climbs and recovers.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::itmcd::starhmm::{
    END, FitParameters, LinearGaussian, Posterior, Starhmm, StarhmmError, StarhmmSequence,
};
use situ::random::stream;

use crate::itmcd::random_model::{INPUTS, OUTPUTS, draw, model};

fn generator(seed: u64, name: &str) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream(seed, name))
}

fn product(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

/// The density of a two-dimensional Gaussian, written out.
fn density(emission: &LinearGaussian, regressors: &[f64], target: &[f64]) -> f64 {
    let [a, b, _, c] = emission.covariance() else { unreachable!() };
    let mean: Vec<f64> = emission.weights().chunks(INPUTS).map(|row| product(row, regressors)).collect();
    let (x, y, determinant) = (target[0] - mean[0], target[1] - mean[1], a * c - b * b);
    let squared = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant;
    (-0.5 * squared).exp() / (2.0 * std::f64::consts::PI * determinant.sqrt())
}

/// p(path, sequence), from the definition of the model and without code of the crate.
fn joint(model: &Starhmm, index: usize, sequence: &StarhmmSequence, path: &[usize]) -> f64 {
    let enter = |from: Option<usize>, inside: bool, to: usize, features: &[f64]| {
        let children = from.map_or(&model.first, |from| &model.children[from]);
        let present = |to: &usize| *to == END || !model.phases[*to].absent.contains(&index);
        let odds = |to: usize| {
            let entry = if to == END { model.end_entry } else { model.phases[to].entry };
            product(&model.entries[entry], features).exp()
        };
        let options: Vec<usize> =
            children.iter().copied().filter(|to| present(to) && !(inside && from == Some(*to))).collect();
        if options.contains(&to) { odds(to) / options.iter().map(|to| odds(*to)).sum::<f64>() } else { 0.0 }
    };
    let make = |phase: usize, time: usize| {
        let (phase, step) = (&model.phases[phase], &sequence.steps[time]);
        if phase.context != step.context || phase.absent.contains(&index) {
            return 0.0;
        }
        density(&phase.emission, &step.regressors, &step.target)
    };
    let mut probability = enter(sequence.origin, false, path[0], &sequence.entry_features) * make(path[0], 0);
    let ends = |phase: usize, time: usize| {
        let odds = product(&model.exits[model.phases[phase].exit], &sequence.steps[time].exit_features);
        1.0 / (1.0 + (-odds).exp())
    };
    for (time, pair) in path.windows(2).enumerate() {
        let tau = if sequence.steps[time].can_end { ends(pair[0], time) } else { 0.0 };
        probability *= if pair[0] == pair[1] {
            1.0 - tau
        } else {
            tau * enter(Some(pair[0]), true, pair[1], &sequence.steps[time].entry_features)
        };
        probability *= make(pair[1], time + 1);
    }
    if sequence.ends {
        let (time, last) = (path.len() - 1, path[path.len() - 1]);
        if !sequence.steps[time].can_end {
            return 0.0;
        }
        probability *= ends(last, time) * enter(Some(last), true, END, &sequence.steps[time].entry_features);
    }
    probability
}

/// The index of the sequence that is examined.
const INDEX: usize = 5;

/// A model of up to 3 phases and a sequence of up to 6 steps. Some draws have an origin, steps after which no phase can
/// end, an absent phase, or a shared v.
fn small(seed: u64) -> (Starhmm, StarhmmSequence) {
    let mut rng = generator(seed, "paths");
    let phases = rng.random_range(1..4);
    let mut truth = model(phases, 2, &mut rng);
    for phase in &mut truth.phases {
        // The emissions are broad, so that no product of densities is too small for the oracle.
        let covariance = phase.emission.covariance().iter().map(|value| 40.0 * value).collect();
        phase.emission = LinearGaussian::new(phase.emission.weights().to_vec(), covariance, INPUTS).unwrap();
    }
    let (mut sequence, _) = draw(&truth, 6, &mut rng);
    if rng.random() {
        sequence.origin = Some(rng.random_range(0..phases));
    }
    if phases == 3 && rng.random() {
        truth.phases[2].absent.insert(INDEX);
        truth.phases[1].entry = 0;
    }
    if rng.random() {
        sequence.steps.iter_mut().for_each(|step| step.can_end = rng.random());
    }
    (truth, sequence)
}

/// The sums over every path of a sequence.
struct Enumerated {
    phases: usize,
    /// p(sequence).
    total: f64,
    /// The most probable path.
    best: Vec<usize>,
    /// p(phase at a step, sequence), shape (T, phases).
    gamma: Vec<Vec<f64>>,
    /// p(from at a step, to at the next, sequence), shape (T, phases × phases).
    moved: Vec<Vec<f64>>,
}

impl Enumerated {
    fn of(model: &Starhmm, sequence: &StarhmmSequence) -> Self {
        let (phases, length) = (model.phases.len(), sequence.steps.len());
        let (mut total, mut best) = (0.0, (0.0, Vec::new()));
        let mut gamma = vec![vec![0.0; phases]; length];
        let mut moved = vec![vec![0.0; phases * phases]; length];
        for code in 0..phases.pow(length as u32) {
            let path: Vec<usize> = (0..length).map(|time| code / phases.pow(time as u32) % phases).collect();
            let probability = joint(model, INDEX, sequence, &path);
            total += probability;
            if probability > best.0 {
                best = (probability, path.clone());
            }
            path.iter().zip(&mut gamma).for_each(|(phase, gamma)| gamma[*phase] += probability);
            path.windows(2).zip(&mut moved).for_each(|(pair, moved)| moved[pair[0] * phases + pair[1]] += probability);
        }
        Self { phases, total, best: best.1, gamma, moved }
    }

    fn check(&self, posterior: &Posterior, seed: u64) {
        let (phases, total) = (self.phases, self.total);
        assert!((posterior.log_likelihood - f64::ln(total)).abs() < 1e-9, "{seed}");
        for (found, expected) in posterior.gamma.iter().flatten().zip(self.gamma.iter().flatten()) {
            assert!((found - expected / total).abs() < 1e-9, "{seed}");
        }
        for transition in &posterior.transitions {
            let row = &self.moved[transition.step][transition.from * phases..(transition.from + 1) * phases];
            assert!((transition.stays - row[transition.from] / total).abs() < 1e-9, "{seed}");
            for (to, weight) in transition.ends.iter().filter(|(to, _)| *to != END) {
                assert!((weight - row[*to] / total).abs() < 1e-9, "{seed}");
            }
        }
        let weights = posterior.transitions.iter().flat_map(|transition| &transition.ends);
        let found: f64 = weights.filter(|(to, _)| *to != END).map(|(_, weight)| weight).sum();
        let others = |row: &Vec<f64>| -> f64 {
            (0..phases * phases).filter(|at| at / phases != at % phases).map(|at| row[at]).sum()
        };
        let moves: f64 = self.moved.iter().map(others).sum();
        assert!((found - moves / total).abs() < 1e-9, "{seed}: a transition is missing");
    }
}

#[test]
fn inference_is_the_sum_over_all_paths() {
    let (mut compared, mut impossible) = (0, 0);
    for seed in 0..300 {
        let (truth, sequence) = small(seed);
        let expected = Enumerated::of(&truth, &sequence);
        let (posterior, path) = (truth.posterior(INDEX, &sequence), truth.most_probable_path(INDEX, &sequence));
        if expected.total == 0.0 {
            impossible += 1;
            assert_eq!(posterior, Err(StarhmmError::Impossible { sequence: INDEX }));
            assert_eq!(path, Err(StarhmmError::Impossible { sequence: INDEX }));
        } else {
            compared += 1;
            expected.check(&posterior.unwrap(), seed);
            assert_eq!(path.unwrap(), expected.best, "{seed}");
        }
    }
    assert!(compared >= 200 && impossible >= 10, "{compared} compared, {impossible} impossible");
}

/// 1000 random starts, on sequences of another model. Some have steps after which no phase can end, phases that are
/// absent from a sequence, or phases that share w and v, as versions of a node do.
#[test]
fn no_iteration_lowers_the_log_likelihood() {
    let parameters = FitParameters {
        ridge: 1e-3,
        floor: 1e-3,
        switch_ridge: 1e-2,
        tolerance: f64::NEG_INFINITY,
        max_iterations: 12,
    };
    let (mut newton, mut special, mut fall, mut gain) = (0, 0, 0.0_f64, 0.0);
    let (mut seed, mut fits) = (0, 0);
    while fits < 1000 {
        let mut rng = generator(seed, "starts");
        seed += 1;
        let truth = model(2, 1, &mut rng);
        let mut sequences: Vec<StarhmmSequence> = (0..3).map(|_| draw(&truth, 15, &mut rng).0).collect();
        let mut start = model(rng.random_range(1..4), 1, &mut rng);
        if rng.random() {
            let steps = sequences.iter_mut().flat_map(|sequence| &mut sequence.steps);
            steps.for_each(|step| step.can_end = rng.random());
        }
        let mut ties = 0;
        if let ([first, .., last], true) = (&mut start.phases[..], rng.random()) {
            (last.exit, last.entry) = (first.exit, first.entry);
            last.absent.insert(rng.random_range(0..3));
            ties = 1;
        }
        let Ok(fit) = start.fit(&sequences, &parameters) else { continue };
        assert_eq!(fit.iterations(), 12);
        assert!(fit.logistic_steps <= 12 * 2 * (fit.model.exits.len() + 1), "two Newton steps a regression at most");
        newton += fit.logistic_steps;
        special += ties;
        for pair in fit.log_likelihoods.windows(2) {
            fall = fall.max(pair[0] - pair[1]);
        }
        gain += fit.log_likelihood() - fit.log_likelihoods[0];
        fits += 1;
    }
    assert!(fall <= 1e-8, "{fall}");
    assert!(newton > 0 && special > 100, "{newton} {special}");
    assert!(gain / 1000.0 > 10.0, "EM that never moves does not fall either: {gain}");
}

/// A model of three phases. EM knows the structure and a rough start.
#[test]
fn a_planted_model_is_recovered() {
    let mut rng = generator(1, "planted");
    let mut truth = model(3, 1, &mut rng);
    let goals = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]];
    for (phase, goal) in goals.iter().enumerate() {
        // s' = g + 0.5 (s − g): the state is drawn towards the goal.
        let weights = vec![0.5, 0.0, 0.5 * goal[0], 0.0, 0.5, 0.5 * goal[1]];
        truth.phases[phase].emission = LinearGaussian::new(weights, vec![0.6, 0.2, 0.2, 0.8], INPUTS).unwrap();
        truth.exits[phase] = vec![-1.5, 0.0];
    }
    truth.children = vec![vec![1, 2], vec![2, END], vec![0, END]];
    truth.first = vec![0, 1];
    truth.entries = vec![vec![0.0, 0.0], vec![0.5, -1.0], vec![0.0, 0.0], vec![-0.5, 0.0]];
    let drawn: Vec<(StarhmmSequence, Vec<usize>)> = (0..120).map(|_| draw(&truth, 60, &mut rng)).collect();
    let (sequences, paths): (Vec<_>, Vec<_>) = drawn.into_iter().unzip();
    let mut start = truth.clone();
    for (phase, goal) in goals.iter().enumerate() {
        let weights = vec![0.0, 0.0, goal[0] * 0.7 + 0.5, 0.0, 0.0, goal[1] * 0.7];
        start.phases[phase].emission = LinearGaussian::new(weights, vec![4.0, 0.0, 0.0, 4.0], INPUTS).unwrap();
    }
    start.exits.iter_mut().chain(&mut start.entries).for_each(|weights| weights.fill(0.0));
    let parameters =
        FitParameters { ridge: 1e-6, floor: 1e-6, switch_ridge: 1e-3, tolerance: 1e-6, max_iterations: 200 };
    let fit = start.fit(&sequences, &parameters).unwrap();
    let numbers = |model: &Starhmm| -> Vec<f64> {
        let of = |emission: &LinearGaussian| [emission.weights(), emission.covariance()].concat();
        model.phases.iter().flat_map(|phase| of(&phase.emission)).collect()
    };
    let pairs = numbers(&fit.model).into_iter().zip(numbers(&truth));
    let worst = pairs.map(|(found, planted)| (found - planted).abs()).fold(0.0, f64::max);
    let (mut right, mut possible, mut all) = (0, 0, 0);
    for (index, (sequence, path)) in sequences.iter().zip(&paths).enumerate() {
        for (count, model) in [(&mut right, &fit.model), (&mut possible, &truth)] {
            let found = model.most_probable_path(index, sequence).unwrap();
            *count += found.iter().zip(path).filter(|(found, planted)| found == planted).count();
        }
        all += path.len();
    }
    let [share, bound] = [right, possible].map(|count| count as f64 / all as f64);
    // There are 800 steps per phase. The state is up to 4 from 0 and scattered by 1, so the standard error of an offset
    // is about 0.08.
    assert!(worst < 0.25, "{worst}");
    // No model finds more than the planted one, except by chance.
    assert!(bound < 0.99 && share > bound - 0.01, "{share} {bound}");
    for (found, planted) in fit.model.exits.iter().zip(&truth.exits) {
        // There are about 300 ends per phase, so the standard error of the log odds is below 0.15 at the mean.
        let probability = |w: &[f64], x: f64| 1.0 / (1.0 + (-w[0] - w[1] * x).exp());
        assert!((probability(found, 2.0) - probability(planted, 2.0)).abs() < 0.08, "{found:?}");
    }
    let truth_likelihood: f64 = sequences
        .iter()
        .enumerate()
        .map(|(index, sequence)| truth.posterior(index, sequence).unwrap().log_likelihood)
        .sum();
    assert!(fit.log_likelihood() > truth_likelihood - 1.0, "{} {truth_likelihood}", fit.log_likelihood());
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let mut rng = generator(3, "shapes");
    let sound = model(2, 1, &mut rng);
    let (sequence, _) = draw(&sound, 5, &mut rng);
    let parameters = FitParameters { ridge: 1e-3, floor: 1e-3, switch_ridge: 1e-2, tolerance: 1e-3, max_iterations: 3 };
    let refuse = |model: &Starhmm, sequence: &StarhmmSequence, error: StarhmmError| {
        assert_eq!(model.clone().fit(std::slice::from_ref(sequence), &parameters), Err(error.clone()));
        assert_eq!(model.posterior(0, sequence), Err(error.clone()));
        assert_eq!(model.most_probable_path(0, sequence), Err(error));
    };
    let spoilt = |problem, change: &dyn Fn(&mut StarhmmSequence)| {
        let mut other = sequence.clone();
        change(&mut other);
        refuse(&sound, &other, StarhmmError::Shape { sequence: 0, problem });
    };
    spoilt("at least one step", &|sequence| sequence.steps.clear());
    spoilt("a number is not finite", &|sequence| sequence.steps[0].target[1] = f64::NAN);
    let length = "a vector has another length than the model's";
    spoilt(length, &|sequence| sequence.steps[0].regressors.push(0.0));
    spoilt(length, &|sequence| sequence.entry_features.clear());
    spoilt("the origin is not a phase", &|sequence| sequence.origin = Some(2));
    let broken = |problem, change: &dyn Fn(&mut Starhmm)| {
        let mut other = sound.clone();
        change(&mut other);
        refuse(&other, &sequence, StarhmmError::Model(problem));
    };
    broken("a list of children a phase, each child a phase or END", &|model| model.children[0].push(2));
    broken("an index of w or v is out of range", &|model| model.phases[1].exit = 2);
    broken("an index of w or v is out of range", &|model| model.end_entry = 3);
    broken("phases, w and v of one shape each", &|model| model.entries[0].push(0.0));
    broken("a list of children a phase, each child a phase or END", &|model| model.phases.clear());
    assert_eq!(
        LinearGaussian::new(vec![0.0; OUTPUTS * INPUTS], vec![1.0, 2.0, 2.0, 1.0], INPUTS),
        None,
        "not definite"
    );
    assert_eq!(LinearGaussian::new(vec![0.0; 5], vec![1.0], 0), None);
}

/// Two phases, each with W (2 × 3), Σ (3) and a w of 2; and those v that some choice compares.
#[test]
fn parameters_are_counted_where_they_are_free() {
    let mut counted = model(2, 1, &mut generator(4, "count"));
    (counted.first, counted.children) = (vec![0], vec![vec![1], vec![END]]);
    let alone = 2 * (6 + 3) + 2 * 2;
    assert_eq!(counted.free_parameters(), alone);
    counted.children[0].push(END);
    assert_eq!(counted.free_parameters(), alone + 2, "1 against END");
    counted.first.push(1);
    assert_eq!(counted.free_parameters(), alone + 4, "all three");
    counted.phases[1].entry = 0;
    assert_eq!(counted.free_parameters(), alone + 2, "0 and 1 share a v");
}

/// The fit ends with the first iteration that gains less than the tolerance, or with the last that is allowed.
#[test]
fn the_fit_ends_where_it_gains_too_little() {
    let mut early = 0;
    for seed in 0..20 {
        let mut rng = generator(seed, "end");
        let truth = model(2, 1, &mut rng);
        let sequences: Vec<StarhmmSequence> = (0..3).map(|_| draw(&truth, 15, &mut rng).0).collect();
        let start = model(2, 1, &mut rng);
        for (tolerance, max_iterations) in [(0.5, 40), (0.01, 40), (0.01, 3)] {
            let parameters = FitParameters { ridge: 1e-3, floor: 1e-3, switch_ridge: 1e-2, tolerance, max_iterations };
            let Ok(fit) = start.clone().fit(&sequences, &parameters) else { continue };
            let gains: Vec<f64> = fit.log_likelihoods.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let (last, before) = gains.split_last().expect("one iteration at least");
            assert!(before.iter().all(|gain| *gain >= tolerance), "{seed}: {gains:?}");
            assert!(*last < tolerance || gains.len() == max_iterations, "{seed}: {gains:?}");
            early += usize::from(gains.len() < max_iterations);
        }
    }
    assert!(early > 20, "{early} of 60 fits ended early");
}

/// Every w has the length of φ, and every v that of ψ, whichever of them is another.
#[test]
fn each_length_alone_is_refused() {
    let mut rng = generator(3, "lengths");
    let sound = model(2, 1, &mut rng);
    let (sequence, _) = draw(&sound, 5, &mut rng);
    let refused = |change: &dyn Fn(&mut Starhmm)| {
        let mut other = sound.clone();
        change(&mut other);
        let expected = StarhmmError::Model("phases, w and v of one shape each");
        assert_eq!(other.posterior(0, &sequence), Err(expected));
    };
    let last = sound.entries.len() - 1;
    refused(&|model| model.exits[1].push(0.0));
    refused(&|model| model.entries[last].push(0.0));
    refused(&|model| {
        model.phases[1].emission =
            LinearGaussian::new(vec![0.0; OUTPUTS * (INPUTS + 1)], vec![1.0, 0.0, 0.0, 1.0], INPUTS + 1).unwrap();
    });
}
