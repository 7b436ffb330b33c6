//! What a camera has seen of a world: poses with noise, and of what is hidden the last one.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use situ_sim::{Pose, World, pose_at, rotation_about};

use crate::stream;

/// How well a camera sees: `[perception]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perception {
    /// Standard deviation of an observed position along each axis of the world, in metres.
    #[serde(default)]
    pub position: f64,
    /// Standard deviation of an observed rotation, in radians: of the rotation vector along each axis of the world.
    #[serde(default)]
    pub rotation: f64,
    /// Where the camera is, in metres, world frame. None: nothing is ever hidden.
    pub eye: Option<[f64; 3]>,
}

/// Where a camera has seen things, each in the last picture in which it was not hidden.
///
/// A picture is taken where the hand stands still: at the start, after each motion of the hand with what the gripper
/// does then, and after each event. The noise of a pose depends on the seed of the episode, the name of the object and
/// the time of the picture, and on nothing else. So two looks at one picture agree, and a copy of an episode goes on
/// alike.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sight {
    seed: u64,
    poses: BTreeMap<String, Pose>,
}

impl Sight {
    /// Nothing has been seen yet.
    pub(crate) fn new(seed: u64) -> Sight {
        Sight { seed, poses: BTreeMap::new() }
    }

    /// Takes a picture.
    pub(crate) fn look(&mut self, perception: &Perception, world: &World) {
        for name in world.objects() {
            if perception.eye.is_some_and(|eye| world.is_hidden(name, eye)) {
                continue;
            }
            if let Some(pose) = world.pose(name) {
                let seen = noisy(&pose, perception, self.rng(name, world.steps()));
                self.poses.insert(name.to_owned(), seen);
            }
        }
    }

    /// The pose at which an object was seen last; none where it has never been seen.
    pub(crate) fn pose(&self, object: &str) -> Option<Pose> {
        self.poses.get(object).copied()
    }

    /// The random numbers of an object in the picture after so many steps.
    fn rng(&self, object: &str, steps: u64) -> ChaCha8Rng {
        let mut key = stream::key(self.seed, &format!("the sight of {object}"));
        key[16..24].copy_from_slice(&steps.to_le_bytes());
        ChaCha8Rng::from_seed(key)
    }
}

/// A pose as it is observed.
fn noisy(pose: &Pose, perception: &Perception, mut rng: ChaCha8Rng) -> Pose {
    let shift = normal(&mut rng) * perception.position;
    let turn = normal(&mut rng) * perception.rotation;
    let turn = rotation_about(turn.into(), turn.norm());
    pose_at((pose.translation.vector + shift).into(), turn * pose.rotation)
}

/// Three standard normal numbers, by Box and Muller (1958): with the functions of `libm`, which are the same bits on
/// every machine.
fn normal(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| {
        // 1 − u is never 0.
        let (length, angle) = (1.0 - rng.random::<f64>(), core::f64::consts::TAU * rng.random::<f64>());
        libm::sqrt(-2.0 * libm::log(length)) * libm::cos(angle)
    })
}
