//! How long a sweep takes, and a lesson: reported, never a gate.
//!
//! ```text
//! cargo test --release -p situ --test bp_ar_hmm speed -- --nocapture --include-ignored
//! ```

use std::time::Instant;

use nalgebra::SVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::method::bp_ar_hmm::BpArHmm;
use situ::method::bp_ar_hmm::parameters::BpArHmmParameters;
use situ::method::bp_ar_hmm::sampler::{Chain, Moves};
use situ::method::{Learned, Method};
use situ::random::standard_normal;

use crate::common::{CAREFUL, Planted, Task};
use crate::synthetic::{frames, published};

/// Frames of each of four sequences, and behaviours in each.
const SIZES: [(usize, usize); 6] = [(100, 2), (100, 5), (200, 5), (400, 5), (400, 10), (800, 10)];
const SWEEPS: usize = 20;

#[test]
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
}

/// Frames of each demonstration that a model has seen.
fn seen(model: &dyn Learned) -> Vec<usize> {
    let labelling = &model.to_json()["labelling"]["state"]["rows"];
    let rows = labelling.as_array().unwrap().iter();
    rows.map(|row| row["states"].as_array().unwrap().len()).collect()
}

/// What one chain more or a longer one finds, and costs: three demonstrations of 15 keyframes, then a correction to the
/// end.
#[test]
#[ignore = "a measurement"]
fn a_lesson_and_a_correction() {
    println!("chains  sweeps  seed  teach s  correct s  log joint  nodes  frames");
    let task = Task::new(5, 5, 3);
    let correction = task.correction(Planted::NewNode, 0, CAREFUL, true);
    let BpArHmmParameters { chains, sweeps, .. } = BpArHmmParameters::default();
    let ours = (chains, sweeps, 3);
    // Chains, sweeps and seeds. The last as published, which takes long.
    for (chains, sweeps, seeds) in [ours, (1, 300, 3), (2, 200, 3), (3, 150, 3), (3, 300, 3), (10, 1000, 1)] {
        for seed in 0..seeds {
            let parameters = BpArHmmParameters { chains, sweeps, ..BpArHmmParameters::default() };
            let clock = Instant::now();
            let mut model = BpArHmm { parameters }.teach(&task.schema, &task.originals(3, CAREFUL), seed).unwrap();
            let teach = clock.elapsed().as_secs_f64();
            let last = correction.last_in(&model.graph());
            let clock = Instant::now();
            model.correct(Correction::after(last, &correction.demonstration)).unwrap();
            let correct = clock.elapsed().as_secs_f64();
            let nodes = model.graph().nodes.len();
            let log_joint = model.to_json()["labelling"]["log_joint"].as_f64().unwrap();
            let frames = seen(&*model);
            println!(
                "{chains:>6}  {sweeps:>6}  {seed:>4}  {teach:>7.2}  {correct:>9.2}  {log_joint:>9.1}  {nodes:>5}  {frames:?}"
            );
        }
    }
}
