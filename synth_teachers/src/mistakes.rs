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

#[cfg(test)]
mod tests {
    use super::*;

    /// Keyframes drawn. Each is free with a command, free without one, or a contact, in turn.
    const KEYFRAMES: u32 = 6000;
    /// The two-sided normal quantile of 0.05 / 17: four rates and thirteen deviations, at 5 % together (Bonferroni).
    const QUANTILE: f64 = 2.974;

    fn novice() -> Profile {
        Profile::named("novice").unwrap()
    }

    fn draws(profile: &Profile, seed: u64) -> (Vec<Mistake>, Tally) {
        let mut mistakes = Mistakes::new(profile, seed);
        let drawn = (0..KEYFRAMES).map(|index| mistakes.next(index % 3 == 2, index % 3 != 1)).collect();
        (drawn, mistakes.tally)
    }

    /// Within the binomial interval about the configured rate.
    fn assert_rate(name: &str, happened: u32, of: u32, rate: f64) {
        let (mean, variance) = (f64::from(of) * rate, f64::from(of) * rate * (1.0 - rate));
        assert!(variance > 9.0, "{name}: too few for the normal approximation");
        let off = (f64::from(happened) - mean).abs();
        assert!(off <= 0.5 + QUANTILE * variance.sqrt(), "{name}: {happened} of {of}, configured {rate}");
    }

    /// Within the χ² interval about the configured deviation (quantiles by Wilson and Hilferty 1931), about a mean of 0.
    fn assert_deviation(name: &str, values: &[f64], deviation: f64) {
        let count = values.len() as f64;
        let sum: f64 = values.iter().map(|value| (value / deviation) * (value / deviation)).sum();
        let bound = |quantile: f64| {
            let spread = 2.0 / (9.0 * count);
            count * (1.0 - spread + quantile * spread.sqrt()).powi(3)
        };
        assert!((bound(-QUANTILE)..=bound(QUANTILE)).contains(&sum), "{name}: {sum} of {count}");
    }

    #[test]
    fn a_novice_errs_as_often_and_as_far_as_configured() {
        let profile = novice();
        let (drawn, tally) = draws(&profile, 1);
        assert_eq!((tally.keyframes, tally.free), (KEYFRAMES, KEYFRAMES / 3));
        let count = |has: &dyn Fn(&Mistake) -> bool| drawn.iter().filter(|mistake| has(mistake)).count() as u32;
        assert_eq!(tally.spurious, count(&|mistake| mistake.spurious.is_some()));
        assert_eq!(tally.missing, count(&|mistake| mistake.missing));
        assert_eq!(tally.pauses, count(&|mistake| mistake.pause == profile.pause.seconds));
        assert_eq!(KEYFRAMES - tally.pauses, count(&|mistake| mistake.pause == 0.0));
        assert_rate("spurious", tally.spurious, tally.keyframes, profile.spurious);
        assert_rate("missing", tally.missing, tally.free, profile.missing);
        assert_rate("pause", tally.pauses, tally.keyframes, profile.pause.rate);
        let stopped = (0..2000).filter(|seed| Mistakes::new(&profile, *seed).stops_early()).count() as u32;
        assert_rate("stop_early", stopped, 2000, profile.stop_early);
        // Neither a contact nor a command is ever missed.
        assert!(drawn.iter().enumerate().all(|(index, mistake)| index % 3 == 1 || !mistake.missing));

        let tangents = |of: &dyn Fn(usize, &Mistake) -> Option<Isometry3<f64>>| -> Vec<pose::Tangent> {
            let poses = drawn.iter().enumerate().filter_map(|(index, mistake)| of(index, mistake));
            poses.map(|error| pose::log(&Isometry3::identity(), &error)).collect()
        };
        let groups = [
            ("contact", tangents(&|index, mistake| (index % 3 == 2).then_some(mistake.offset)), profile.contact),
            ("free", tangents(&|index, mistake| (index % 3 != 2).then_some(mistake.offset)), profile.free),
        ];
        for (name, errors, noise) in groups {
            for axis in 0..6 {
                let values: Vec<f64> = errors.iter().map(|error| error[axis]).collect();
                let deviation = if axis < 3 { noise.position } else { noise.rotation.to_radians() };
                assert_deviation(&format!("{name}, axis {axis}"), &values, deviation);
            }
        }
        // Off the path by the free noise.
        let spurious = tangents(&|_, mistake| mistake.spurious);
        assert_eq!(spurious.len(), tally.spurious as usize);
        let values: Vec<f64> = spurious.iter().flat_map(|error| [error[0], error[1], error[2]]).collect();
        assert_deviation("spurious", &values, profile.free.position);
    }

    #[test]
    fn a_seed_is_a_teacher_and_a_rate_moves_no_other_draw() {
        let profile = novice();
        let offsets =
            |profile: &Profile, seed| draws(profile, seed).0.iter().map(|mistake| mistake.offset).collect::<Vec<_>>();
        assert_eq!(offsets(&profile, 1), offsets(&profile, 1));
        assert_ne!(offsets(&profile, 1), offsets(&profile, 2));
        let other = Profile { spurious: 0.5, missing: 0.0, pause: Default::default(), ..profile.clone() };
        assert_eq!(offsets(&other, 1), offsets(&profile, 1));
        assert_eq!(draws(&other, 1).1.missing, 0);
    }

    #[test]
    fn an_expert_errs_in_nothing() {
        let (drawn, tally) = draws(&Profile::named("expert").unwrap(), 1);
        assert_eq!(tally, Tally { keyframes: KEYFRAMES, free: KEYFRAMES / 3, ..Tally::default() });
        for mistake in drawn {
            assert!(mistake.offset == Isometry3::identity() && mistake.spurious.is_none());
            assert!(mistake.pause == 0.0 && !mistake.missing);
        }
    }
}
