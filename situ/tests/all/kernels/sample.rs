//! Poses and observations for the tests.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Gripper, Pose};
use situ::keyframe::hmm::Observation;
use situ::random::standard_normal;

pub(crate) fn pose_of(position: [f64; 3], turn: [f64; 3]) -> Pose {
    Pose::from_parts(Translation3::from(Vector3::from(position)), UnitQuaternion::from_scaled_axis(Vector3::from(turn)))
}

pub(crate) fn vector(range: f64) -> impl Strategy<Value = [f64; 3]> {
    [-range..range, -range..range, -range..range]
}

/// Any pose within a metre and a turn of 1.5 rad about each axis.
pub(crate) fn pose() -> impl Strategy<Value = Pose> {
    (vector(1.0), vector(1.5)).prop_map(|(position, turn)| pose_of(position, turn))
}

/// Noisy passes over `waypoints` random waypoints, with a random number of frames at each. Noise in metres and radians.
pub(crate) fn passes(
    seed: u64,
    sequences: usize,
    waypoints: usize,
    position: f64,
    rotation: f64,
) -> Vec<Vec<Observation>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let normals = |rng: &mut ChaCha8Rng, scale: f64| [(); 3].map(|()| scale * standard_normal(rng));
    let turned = if rotation > 0.0 { 1.0 } else { 0.0 };
    let centres: Vec<Pose> =
        (0..waypoints).map(|_| pose_of(normals(&mut rng, 0.1), normals(&mut rng, turned))).collect();
    (0..sequences)
        .map(|_| {
            let mut frames = Vec::new();
            for (index, centre) in centres.iter().enumerate() {
                for _ in 0..1 + rng.random_range(0..4) {
                    let noise = pose_of(normals(&mut rng, position), normals(&mut rng, rotation));
                    let pose = Pose::from_parts(
                        Translation3::from(centre.translation.vector + noise.translation.vector),
                        centre.rotation * noise.rotation,
                    );
                    let gripper = if index % 2 == 0 { Gripper::Open(0.08) } else { Gripper::Close(20.0) };
                    frames.push(Observation { pose, gripper: Some(gripper) });
                }
            }
            frames
        })
        .collect()
}

pub(crate) fn slices<T>(rows: &[Vec<T>]) -> Vec<&[T]> {
    rows.iter().map(Vec::as_slice).collect()
}
