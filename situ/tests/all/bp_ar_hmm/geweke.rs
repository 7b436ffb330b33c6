//! Geweke's joint distribution test (2004): two ways to draw parameters and data together must agree.
//!
//! The first way draws from the prior, and then data given that. The second way alternates between data given the state
//! and a sweep of the sampler given the data. If every move leaves the posterior unchanged, both have the same
//! distribution. The statistics are bounded or have light tails, so their means exist. The draws of the second way are
//! correlated, so its standard error is from means of batches.
//!
//! Each of these bugs was planted by hand and made the test fail:
//! - births and deaths without their Hastings correction (the mildest bug, with a greatest z of 9), or without the
//!   choice among the unique behaviours (their number then grows without end);
//! - η given z with sums of the rows that include the counts;
//! - split and merge without the probability of the proposal, or without that of the behaviours drawn;
//! - the prior odds of a shared behaviour wrong by one;
//! - random walks that are assumed to be symmetric;
//! - the intensity of births over c + N;
//! - a death that counts one behaviour too many;
//! - columns of F of one sequence too many;
//! - a first state that is not uniform, in the forward pass or with η integrated out;
//! - a split without the normaliser of its choices of parts;
//! - backward draws that do not look ahead;
//! - η of a new behaviour without κ;
//! - γ given F over N;
//! - c without log c;
//! - degrees of freedom that grow too slowly.
//!
//! Plant such a bug again after changing a move. Some bugs do not show in one dimension and one evidence, such as
//! Bartlett's degrees of freedom and constants per frame; `dynamics.rs` catches those.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{SMatrix, SVector};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::bp_ar_hmm::sampler::{
    Chain, ChainState, Dynamics, DynamicsPrior, GammaPrior, LaggedSequence, Moves, Prior, SequenceState, Weights,
};
use situ::random::standard_normal;

use crate::bp_ar_hmm::synthetic::{frames, gamma_of_halves, poisson};

/// The frames of each sequence.
const FRAMES: [usize; 3] = [5, 7, 4];
/// The number of draws from the prior.
const DRAWS: usize = 40_000;
/// The number of sweeps.
const SWEEPS: usize = 40_000;
/// The number of batches, of 400 sweeps each, which is far longer than the statistics are correlated.
const BATCHES: usize = 100;
/// The greatest |z|. If the sampler is right, one of so many statistics is beyond 4.5 once in about 5000 seeds, even
/// with the heavier tail of the batches.
const GREATEST_Z: f64 = 4.5;

/// The degrees of freedom of Σ. With these, 1/Σ is a gamma draw of whole shape, and Σ has a mean and a variance.
const FREEDOM: f64 = 8.0;
const SCALE: f64 = 6.0;
const PRECISION: f64 = 4.0;

/// The shapes are multiples of a half, because the draws from the prior use no gamma sampler. γ is so large that there
/// are many behaviours of one sequence alone. With a mean of 1 nearly every death was accepted, and a death with a
/// wrong count passed.
fn prior() -> Prior<1> {
    Prior {
        dynamics: DynamicsPrior {
            precision: SMatrix::from_element(PRECISION),
            scale: SMatrix::from_element(SCALE),
            freedom: FREEDOM,
        },
        alpha: GammaPrior { shape: 4.0, rate: 3.0 },
        kappa: GammaPrior { shape: 4.0, rate: 2.0 },
        gamma: GammaPrior { shape: 5.0, rate: 2.0 },
        c: GammaPrior { shape: 4.0, rate: 3.0 },
    }
}

fn hyper(prior: GammaPrior, rng: &mut impl Rng) -> f64 {
    gamma_of_halves((2.0 * prior.shape) as usize, prior.rate, rng)
}

/// A draw from the two-parameter Indian buffet process, repeated until every guest has a dish.
fn state_from_prior(rng: &mut ChaCha8Rng) -> ChainState<1> {
    let prior = prior();
    let (gamma, c, dishes) = loop {
        let (gamma, c) = (hyper(prior.gamma, rng), hyper(prior.c, rng));
        let mut dishes: Vec<Vec<usize>> = Vec::new();
        let mut eaters: Vec<usize> = Vec::new();
        for guest in 0..FRAMES.len() {
            let weight = c + guest as f64;
            let mut taken: Vec<usize> =
                (0..eaters.len()).filter(|dish| rng.random::<f64>() < eaters[*dish] as f64 / weight).collect();
            let new = poisson(gamma * c / weight, rng);
            taken.extend(eaters.len()..eaters.len() + new);
            eaters.resize(eaters.len() + new, 0);
            taken.iter().for_each(|dish| eaters[*dish] += 1);
            dishes.push(taken);
        }
        if dishes.iter().all(|taken| !taken.is_empty()) {
            break (gamma, c, dishes);
        }
    };
    let (alpha, kappa) = (hyper(prior.alpha, rng), hyper(prior.kappa, rng));
    let mut dynamics = BTreeMap::new();
    for dish in dishes.iter().flatten() {
        dynamics.entry(*dish).or_insert_with(|| {
            let variance = 1.0 / gamma_of_halves(FREEDOM as usize, SCALE / 2.0, rng);
            let slope = (variance / PRECISION).sqrt() * standard_normal(rng);
            Dynamics::new(SMatrix::from_element(slope), SMatrix::from_element(variance)).unwrap()
        });
    }
    let row = |(active, frames): (Vec<usize>, usize)| {
        let weights = Weights::from_prior(active.len(), alpha, kappa, rng);
        let mut place = rng.random_range(0..active.len());
        let mut states = vec![active[place]];
        while states.len() < frames {
            let row: Vec<f64> = (0..active.len()).map(|to| weights.value(place, to)).collect();
            let mut left = rng.random::<f64>() * row.iter().sum::<f64>();
            place = row
                .iter()
                .position(|weight| {
                    left -= weight;
                    left < 0.0
                })
                .unwrap_or(active.len() - 1);
            states.push(active[place]);
        }
        SequenceState { active, weights, states }
    };
    let rows = dishes.into_iter().zip(FRAMES).map(row).collect();
    ChainState { dynamics, rows, alpha, kappa, gamma, c }
}

fn observations(state: &ChainState<1>, rng: &mut ChaCha8Rng) -> Vec<LaggedSequence<1>> {
    let sequence = |row: &SequenceState| {
        frames(SVector::from([1.0]), &row.states, |name, before| {
            let own = &state.dynamics[&name];
            SVector::from([own.transition[0] * before[0] + own.covariance[0].sqrt() * standard_normal(rng)])
        })
    };
    state.rows.iter().map(sequence).collect()
}

/// The statistics by name: of each part of the state, and of parts together. A wrong move would change some of them.
fn statistics(state: &ChainState<1>, sequences: &[LaggedSequence<1>]) -> Vec<(&'static str, f64)> {
    let behaviours = state.dynamics.len() as f64;
    let owned = |name: &usize| state.rows.iter().filter(|row| row.active.contains(name)).count();
    let memberships: usize = state.rows.iter().map(|row| row.active.len()).sum();
    let common = state.dynamics.keys().filter(|name| owned(name) == FRAMES.len()).count() as f64;
    let unique = state.dynamics.keys().filter(|name| owned(name) == 1).count() as f64;
    let mean = |value: &dyn Fn(&Dynamics<1>) -> f64| state.dynamics.values().map(value).sum::<f64>() / behaviours;
    let pairs = || state.rows.iter().flat_map(|row| row.states.windows(2));
    let switches = pairs().filter(|pair| pair[0] != pair[1]).count() as f64;
    let used: usize = state.rows.iter().map(|row| row.states.iter().collect::<BTreeSet<_>>().len()).sum();
    let sums = state.rows.iter().map(|row| {
        let own: f64 = (0..row.active.len()).map(|to| row.weights.value(0, to)).sum();
        own.ln()
    });
    let own = state.rows.iter().map(|row| row.weights.value(0, 0).ln()).sum::<f64>();
    let explained = sequences.iter().zip(&state.rows).flat_map(|(sequence, row)| {
        (0..row.states.len()).map(|frame| {
            let own = &state.dynamics[&row.states[frame]];
            (sequence.current[frame][0] - own.transition[0] * sequence.lagged[frame][0]).powi(2) / own.covariance[0]
        })
    });
    let turned = sequences.iter().map(|sequence| {
        (0..sequence.len()).map(|t| (sequence.current[t][0] * sequence.lagged[t][0]).tanh()).sum::<f64>()
    });
    let large = sequences.iter().flat_map(|sequence| &sequence.current).map(|x| x[0].abs().ln_1p());
    vec![
        ("alpha", state.alpha),
        ("kappa", state.kappa),
        ("gamma", state.gamma),
        ("c", state.c),
        ("log c", state.c.ln()),
        ("behaviours", behaviours),
        ("behaviours squared", behaviours.powi(2)),
        ("memberships", memberships as f64),
        ("common", common),
        ("unique", unique),
        ("slope", mean(&|own| own.transition[0].tanh())),
        ("slope squared", mean(&|own| own.transition[0].powi(2).tanh())),
        ("log variance", mean(&|own| own.covariance[0].ln())),
        ("switches", switches),
        ("states used", used as f64),
        ("log row sum", sums.sum()),
        ("log own weight", own),
        ("explained", explained.sum::<f64>().sqrt()),
        ("turned", turned.sum()),
        ("size of the frames", large.sum()),
        ("gamma by behaviours", state.gamma * behaviours),
        ("switches by kappa", switches * state.kappa),
        ("memberships by c", memberships as f64 * state.c),
    ]
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn sweeps_leave_the_joint_distribution_as_it_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut from_prior: Vec<Vec<f64>> = Vec::new();
    for _ in 0..DRAWS {
        let state = state_from_prior(&mut rng);
        let sequences = observations(&state, &mut rng);
        from_prior.push(statistics(&state, &sequences).into_iter().map(|(_, value)| value).collect());
    }
    // The windows are as short as the sequences allow, so that they differ.
    let moves = Moves { births: 2, window: (2, 5), split_merges: 2, inner: 8 };
    let state = state_from_prior(&mut rng);
    let mut chain = Chain::at(prior(), moves, observations(&state, &mut rng), state);
    let names: Vec<&str> = statistics(chain.state(), chain.sequences()).into_iter().map(|(name, _)| name).collect();
    let mut batches = vec![vec![0.0; BATCHES]; names.len()];
    for sweep in 0..SWEEPS {
        chain.observe(observations(chain.state(), &mut rng));
        chain.sweep(&mut rng).unwrap();
        for (sums, (_, value)) in batches.iter_mut().zip(statistics(chain.state(), chain.sequences())) {
            sums[sweep * BATCHES / SWEEPS] += value * BATCHES as f64 / SWEEPS as f64;
        }
    }
    let mut wrong = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let column: Vec<f64> = from_prior.iter().map(|row| row[index]).collect();
        let ((expected, one), (found, other)) = (mean_and_error(&column), mean_and_error(&batches[index]));
        let z = (found - expected) / one.hypot(other);
        println!("{name:>20}: prior {expected:9.4}, sampler {found:9.4}, z {z:6.2}");
        if z.is_nan() || z.abs() > GREATEST_Z {
            wrong.push(format!("{name}: prior {expected:.4}, sampler {found:.4}, z {z:.2}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
