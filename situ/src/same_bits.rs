//! No result depends on the vectors of the processor: fits, regressions and scans have the same bits without them.

use core::fmt::Debug;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::demonstration::{Gripper, Pose};
use crate::keyframe::hmm::{Hmm, HmmParameters, Observation};
use crate::keyframe::logistic::{self, LogisticParameters, Path};
use crate::keyframe::pose::{Tangent, exp};
use crate::place::NodeId;
use crate::primitive::Ball;
use crate::state::State;
use crate::task_model::screen::Screen;
use crate::vector::PLAINLY;

/// Computes something with the processor's vectors, and checks that it has the same bits without them.
fn either_way<T: Debug + PartialEq>(compute: impl Fn() -> T) -> T {
    let found = compute();
    PLAINLY.set(true);
    let plain = compute();
    PLAINLY.set(false);
    assert_eq!(found, plain, "not the same bits without the processor's vectors");
    found
}

#[test]
fn no_result_depends_on_the_vectors() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut draw = move |spread: f64| spread * (rng.random::<f64>() - 0.5);
    for case in 0..40 {
        // Rotations near one another, and as far apart as they can be.
        let spread = [0.2, 1.0, 3.0, 6.0][case % 4];
        let sequences: Vec<Vec<Observation>> = (0..1 + case % 6)
            .map(|sequence| {
                let observe = |frame| {
                    let pose = exp(&Pose::identity(), &Tangent::from_fn(|_, _| draw(spread)));
                    let gripper = (case % 2 == 0).then(|| Gripper::Open(0.01 * f64::from(frame)));
                    Observation { pose, gripper }
                };
                (0..5 + 3 * sequence as u32).map(observe).collect()
            })
            .collect();
        let slices: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
        let parameters = HmmParameters::default();
        let fit = either_way(|| Hmm::fit(&slices, 1 + case % 7, &parameters).unwrap());
        assert!(fit.log_likelihood().is_finite());
        either_way(|| fit.hmm.total_log_likelihood(&sequences).to_bits());
        let rows: Vec<Vec<f64>> = (0..12 + 5 * case).map(|_| (0..1 + case).map(|_| draw(4.0)).collect()).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let labels: Vec<bool> = rows.iter().map(|row| row[0] + draw(1.0) > 0.5).collect();
        for path in [Path::Primal, Path::Dual] {
            let parameters = LogisticParameters { path, ..LogisticParameters::default() };
            assert!(either_way(|| logistic::fit(&rows, &labels, &parameters).unwrap()).converged);
        }
        let mut screen = Screen::default();
        let scales = vec![0.3; 1 + case];
        for (node, centre) in rows.iter().enumerate() {
            screen.set(NodeId(node as u32), Some(Ball { scales: &scales, centre, greatest: 20.0 * case as f64 }));
        }
        either_way(|| screen.passing(&State::new(rows[0].iter().map(|value| 0.2 * value).collect::<Vec<f64>>())));
    }
}
