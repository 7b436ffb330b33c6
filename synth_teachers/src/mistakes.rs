//! Draws of a teacher's mistakes, all from one seed.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::keyframe::pose;
use situ::random::{standard_normal, stream};

use crate::profile::{Noise, Profile};

/// How often each mistake was made, and how often it could have been.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Keyframes that could have been preceded by a spurious one, or had a pause.
    pub keyframes: u32,
    /// Free keyframes, which could have been missed.
    pub free: u32,
    /// Spurious keyframes given.
    pub spurious: u32,
    /// Keyframes missed.
    pub missing: u32,
    /// Pauses made.
    pub pauses: u32,
}

/// The stream of a demonstration's mistakes.
pub(crate) struct Mistakes<'a> {
    profile: &'a Profile,
    rng: ChaCha8Rng,
    pub(crate) tally: Tally,
}

/// What goes wrong at one keyframe.
pub(crate) struct Mistake {
    pub(crate) spurious: Option<Isometry3<f64>>,
    pub(crate) missing: bool,
    pub(crate) pause: f64,
    pub(crate) offset: Isometry3<f64>,
}

impl<'a> Mistakes<'a> {
    pub(crate) fn new(profile: &'a Profile, seed: u64) -> Self {
        Self { profile, rng: ChaCha8Rng::seed_from_u64(stream(seed, "mistakes")), tally: Tally::default() }
    }

    /// Whether a correction is stopped once back on the model: one draw a demonstration.
    pub(crate) fn stops_early(&mut self) -> bool {
        self.rng.random::<f64>() < self.profile.stop_early
    }

    /// The mistakes of the next keyframe. Every keyframe takes the same number of draws, whatever comes of them, so that a
    /// rate can change without moving the others' draws.
    pub(crate) fn next(&mut self, contact: bool, commands: bool) -> Mistake {
        let [spurious, missing, pause] = [0, 1, 2].map(|_| self.rng.random::<f64>());
        let off_path = self.noise(self.profile.free);
        let offset = self.noise(if contact { self.profile.contact } else { self.profile.free });
        let mistake = Mistake {
            spurious: (spurious < self.profile.spurious).then_some(off_path),
            missing: !contact && !commands && missing < self.profile.missing,
            pause: if pause < self.profile.pause.rate { self.profile.pause.seconds } else { 0.0 },
            offset,
        };
        self.tally.keyframes += 1;
        self.tally.free += u32::from(!contact && !commands);
        self.tally.spurious += u32::from(mistake.spurious.is_some());
        self.tally.missing += u32::from(mistake.missing);
        self.tally.pauses += u32::from(pause < self.profile.pause.rate);
        mistake
    }

    fn noise(&mut self, noise: Noise) -> Isometry3<f64> {
        let normal = pose::Tangent::from_fn(|axis, _| {
            standard_normal(&mut self.rng) * if axis < 3 { noise.position } else { noise.rotation.to_radians() }
        });
        if noise == Noise::default() {
            return Isometry3::identity();
        }
        pose::exp(&Isometry3::identity(), &normal)
    }
}

/// A pose off by an error: shifted in the world's axes, turned in the gripper's.
pub(crate) fn displaced(target: &Isometry3<f64>, error: &Isometry3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(target.translation.vector + error.translation.vector),
        target.rotation * error.rotation,
    )
}

/// Half way between two poses.
pub(crate) fn half_way(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Isometry3<f64> {
    let middle: Vector3<f64> = (from.translation.vector + to.translation.vector) * 0.5;
    let rotation: UnitQuaternion<f64> = pose::exp(from, &(pose::log(from, to) * 0.5)).rotation;
    Isometry3::from_parts(Translation3::from(middle), rotation)
}
