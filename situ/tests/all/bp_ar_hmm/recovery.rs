//! The sampler finds planted behaviours.

use nalgebra::{Matrix2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::bp_ar_hmm::sampler::{Chain, LaggedSequence, Moves};
use situ::random::{standard_normal, stream};

use crate::bp_ar_hmm::synthetic::{frames, hamming, published};

/// Each behaviour turns by such an angle per frame, radians, with damping: oscillations at four speeds and directions.
const TURNS: [f64; 4] = [0.9, -0.9, 0.1, 2.4];
const DAMPING: f64 = 0.97;
const NOISE: f64 = 0.3;
const CHAINS: u64 = 2;
const SWEEPS: usize = 150;

/// Six sequences of 150 frames. Each has two or three of the four behaviours, which change every 25 frames.
fn planted(seed: u64) -> (Vec<Vec<usize>>, Vec<LaggedSequence<2>>) {
    const HAS: [&[usize]; 6] = [&[0, 1], &[1, 2], &[0, 2, 3], &[1, 3], &[0, 1, 2], &[2, 3]];
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    HAS.iter()
        .map(|has| {
            let first = rng.random_range(0..has.len());
            let states: Vec<usize> = (0..150).map(|frame| has[(first + frame / 25) % has.len()]).collect();
            let sequence = frames(Vector2::new(3.0, 0.0), &states, |state, before| {
                let (sin, cos) = TURNS[state].sin_cos();
                let noise = Vector2::from_fn(|_, _| NOISE * standard_normal(&mut rng));
                Matrix2::new(cos, -sin, sin, cos) * before * DAMPING + noise
            });
            (states, sequence)
        })
        .unzip()
}

#[test]
fn planted_behaviours_are_told_apart() {
    for seed in 0..2 {
        let (truth, sequences) = planted(seed);
        let mut best: Option<(f64, Vec<Vec<usize>>)> = None;
        for chain in 0..CHAINS {
            let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, &format!("chain {chain}")));
            let mut chain = Chain::new(published(), Moves::default(), sequences.clone(), 2, &mut rng).unwrap();
            for _ in 0..SWEEPS {
                chain.sweep(&mut rng).unwrap();
                let log_joint = chain.log_joint().unwrap();
                if best.as_ref().is_none_or(|(most, _)| log_joint > *most) {
                    best = Some((log_joint, chain.state().rows.iter().map(|row| row.states.clone()).collect()));
                }
            }
        }
        let (log_joint, found) = best.unwrap();
        let distance = hamming(&truth, &found);
        println!("seed {seed}: log joint {log_joint:.1}, Hamming distance {distance:.4}");
        assert!(distance <= 0.05, "seed {seed}: {distance}");
    }
}
