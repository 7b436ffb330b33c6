//! Random small models, and sequences drawn from a model.

use std::collections::BTreeSet;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use situ::method::itmcd::starhmm::{END, LinearGaussian, Phase, Starhmm, StarhmmSequence, StarhmmStep};
use situ::random::standard_normal;

/// d.
pub(crate) const OUTPUTS: usize = 2;
/// x = (the state before, 1).
pub(crate) const INPUTS: usize = OUTPUTS + 1;

fn normals(count: usize, scale: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..count).map(|_| scale * standard_normal(rng)).collect()
}

/// An emission that draws the state towards a random goal.
pub(crate) fn emission(rng: &mut ChaCha8Rng) -> LinearGaussian {
    let mut weights = normals(OUTPUTS * INPUTS, 0.2, rng);
    for row in 0..OUTPUTS {
        weights[row * INPUTS + row] += 0.5;
        weights[row * INPUTS + OUTPUTS] = 2.0 * standard_normal(rng);
    }
    let factor = normals(OUTPUTS * OUTPUTS, 0.3, rng);
    let mut covariance = vec![0.0; OUTPUTS * OUTPUTS];
    for row in 0..OUTPUTS {
        for column in 0..OUTPUTS {
            let product: f64 = (0..OUTPUTS).map(|k| factor[row * OUTPUTS + k] * factor[column * OUTPUTS + k]).sum();
            covariance[row * OUTPUTS + column] = product + if row == column { 0.05 } else { 0.0 };
        }
    }
    LinearGaussian::new(weights, covariance, INPUTS).unwrap()
}

/// A model of so many phases over so many contexts. Every child is permitted with probability ½, and each phase has at
/// least one. φ = ψ = (1, the first coordinate).
pub(crate) fn model(phases: usize, contexts: usize, rng: &mut ChaCha8Rng) -> Starhmm {
    let children = |own: Option<usize>, rng: &mut ChaCha8Rng| {
        let others = (0..phases).chain([END]).filter(|to| Some(*to) != own || rng.random());
        let mut some: Vec<usize> = others.collect::<Vec<_>>().into_iter().filter(|_| rng.random()).collect();
        let next = own.map_or(0, |own| (own + 1) % phases);
        if !some.contains(&next) {
            some.push(next);
        }
        if own.is_some() && !some.contains(&END) {
            some.push(END);
        }
        some
    };
    Starhmm {
        children: (0..phases).map(|phase| children(Some(phase), rng)).collect(),
        first: (0..phases).collect(),
        exits: (0..phases).map(|_| normals(2, 1.0, rng)).collect(),
        entries: (0..=phases).map(|_| normals(2, 1.0, rng)).collect(),
        end_entry: phases,
        phases: (0..phases)
            .map(|phase| Phase {
                context: rng.random_range(0..contexts),
                emission: emission(rng),
                exit: phase,
                entry: phase,
                absent: BTreeSet::new(),
            })
            .collect(),
    }
}

fn features(state: &[f64]) -> Vec<f64> {
    vec![1.0, state[0]]
}

fn choose(weights: &[f64], rng: &mut ChaCha8Rng) -> usize {
    let mut rest = rng.random::<f64>() * weights.iter().sum::<f64>();
    for (index, weight) in weights.iter().enumerate() {
        rest -= weight;
        if rest <= 0.0 {
            return index;
        }
    }
    weights.len() - 1
}

/// Draws a sequence from the definition of the model, of at most so many steps, and returns the phases that made it
/// too.
pub(crate) fn draw(model: &Starhmm, most: usize, rng: &mut ChaCha8Rng) -> (StarhmmSequence, Vec<usize>) {
    let product = |left: &[f64], right: &[f64]| -> f64 { left.iter().zip(right).map(|(l, r)| l * r).sum() };
    let enter = |options: &[usize], state: &[f64], rng: &mut ChaCha8Rng| {
        let entry = |to: &usize| if *to == END { model.end_entry } else { model.phases[*to].entry };
        let odds = |to: &usize| product(&model.entries[entry(to)], &features(state)).exp();
        options[choose(&options.iter().map(odds).collect::<Vec<_>>(), rng)]
    };
    let mut state = normals(OUTPUTS, 1.0, rng);
    let entry_features = features(&state);
    let mut phase = enter(&model.first, &state, rng);
    let (mut steps, mut path, mut ends) = (Vec::new(), Vec::new(), false);
    while steps.len() < most && !ends {
        let emission = &model.phases[phase].emission;
        let regressors: Vec<f64> = state.iter().copied().chain([1.0]).collect();
        // The lower Cholesky factor of a 2 × 2 matrix.
        let [a, b, _, c] = emission.covariance() else { unreachable!() };
        let (first, second) = (standard_normal(rng), standard_normal(rng));
        let low = a.sqrt();
        let noise = [low * first, b / low * first + (c - b * b / a).sqrt() * second];
        let target: Vec<f64> = emission
            .weights()
            .chunks(INPUTS)
            .zip(noise)
            .map(|(row, noise)| product(row, &regressors) + noise)
            .collect();
        let shown = features(&target);
        steps.push(StarhmmStep {
            context: model.phases[phase].context,
            regressors,
            exit_features: shown.clone(),
            entry_features: shown.clone(),
            target: target.clone(),
            can_end: true,
        });
        path.push(phase);
        let odds = product(&model.exits[model.phases[phase].exit], &shown);
        if rng.random::<f64>() < 1.0 / (1.0 + (-odds).exp()) {
            let inside: Vec<usize> = model.children[phase].iter().copied().filter(|to| *to != phase).collect();
            match enter(&inside, &target, rng) {
                END => ends = true,
                next => phase = next,
            }
        }
        state = target;
    }
    (StarhmmSequence { origin: None, entry_features, steps, ends }, path)
}
