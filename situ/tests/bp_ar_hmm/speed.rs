//! How long a sweep takes: reported, never a gate.
//!
//! ```text
//! cargo test --release -p situ --test bp_ar_hmm speed -- --ignored --nocapture
//! ```

use std::time::Instant;

use nalgebra::SVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::method::Method;
use situ::method::bp_ar_hmm::BpArHmm;
use situ::method::bp_ar_hmm::parameters::BpArHmmParameters;
use situ::method::bp_ar_hmm::sampler::{Chain, Moves};
use situ::random::standard_normal;

use crate::common::{CAREFUL, Task};
use crate::synthetic::{frames, published};

/// Frames of each of four sequences, and behaviours in each.
const SIZES: [(usize, usize); 6] = [(100, 2), (100, 5), (200, 5), (400, 5), (400, 10), (800, 10)];
const SWEEPS: usize = 50;

#[test]
#[ignore = "a measurement"]
fn sweeps_a_second() {
    println!("frames  planted  found  sweeps/s  (4 sequences of 7 numbers)");
    for (length, planted) in SIZES {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let rates: Vec<SVector<f64, 7>> =
            (0..planted).map(|_| SVector::from_fn(|_, _| standard_normal(&mut rng).tanh())).collect();
        let sequences = (0..4).map(|first| {
            let states: Vec<usize> = (0..length).map(|frame| (first + frame / 20) % planted).collect();
            frames(SVector::repeat(1.0), &states, |state, before: &SVector<f64, 7>| {
                before.component_mul(&rates[state]) + SVector::<f64, 7>::from_fn(|_, _| 0.5 * standard_normal(&mut rng))
            })
        });
        let sequences = sequences.collect();
        let mut chain = Chain::new(published(), Moves::default(), sequences, 2, &mut rng).unwrap();
        let clock = Instant::now();
        (0..SWEEPS).for_each(|_| chain.sweep(&mut rng).unwrap());
        let rate = SWEEPS as f64 / clock.elapsed().as_secs_f64();
        println!("{length:>6}  {planted:>7}  {:>5}  {rate:>8.0}", chain.state().dynamics.len());
    }
    println!("chains  sweeps  seconds  log joint  nodes  (a task of five skills, three demonstrations)");
    let task = Task::new(5, 5, 3);
    for (chains, sweeps) in [(3, 100), (3, 300), (1, 1000), (3, 1000)] {
        let parameters = BpArHmmParameters { chains, sweeps, ..BpArHmmParameters::default() };
        let clock = Instant::now();
        let model = BpArHmm { parameters }.teach(&task.schema, &task.originals(3, CAREFUL), 1).unwrap();
        let (seconds, nodes) = (clock.elapsed().as_secs_f64(), model.graph().nodes.len());
        let log_joint = model.to_json()["labelling"]["log_joint"].as_f64().unwrap();
        println!("{chains:>6}  {sweeps:>6}  {seconds:>7.2}  {log_joint:>9.1}  {nodes:>5}");
    }
}
