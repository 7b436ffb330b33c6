//! Draws of a teacher's mistakes, all from one seed.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::keyframe::pose;
use situ::random::{standard_normal, stream};

use crate::profile::{Noise, Profile};
use crate::tally::{Tally, Way};

/// What goes wrong at one keyframe.
pub(crate) struct Mistake {
    /// The error of a needless keyframe before this one.
    pub(crate) spurious: Option<Isometry3<f64>>,
    /// The excursion before this one: a displacement from the middle of the way, metres, world frame.
    pub(crate) detour: Option<Vector3<f64>>,
    /// Whether the way leads along one axis after the other.
    pub(crate) one_axis: bool,
    /// Whether it is not recorded.
    pub(crate) missing: bool,
    /// Seconds.
    pub(crate) pause: f64,
    /// The error of its pose.
    pub(crate) offset: Isometry3<f64>,
}

/// What goes wrong with a skill as a whole.
pub(crate) struct Slip {
    /// The turn of the gripper about its own z axis.
    pub(crate) turn: UnitQuaternion<f64>,
    /// Which of the other objects is named in place of the reference object, as a fraction of their number.
    pub(crate) wrong_reference: Option<f64>,
}

/// When a teacher steps in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Onset {
    /// At the first moment at which the robot has to be stopped.
    OnTime,
    /// One primitive before.
    Early,
    /// At the second such moment, or at the robot's own end.
    Late,
}

/// The streams of a demonstration's mistakes: each kind has its own, so that a rate can change without moving the others' draws.
pub(crate) struct Mistakes<'a> {
    profile: &'a Profile,
    /// Noise, needless and missing keyframes, pauses, early ends.
    keyframes: ChaCha8Rng,
    detours: ChaCha8Rng,
    axes: ChaCha8Rng,
    skills: ChaCha8Rng,
    pub(crate) tally: Tally,
}

impl<'a> Mistakes<'a> {
    pub(crate) fn new(profile: &'a Profile, seed: u64) -> Self {
        let rng = |name| ChaCha8Rng::seed_from_u64(stream(seed, name));
        Self {
            profile,
            keyframes: rng("mistakes"),
            detours: rng("detours"),
            axes: rng("axes"),
            skills: rng("skills"),
            tally: Tally::default(),
        }
    }

    /// Whether a demonstration, if it is a correction, is stopped once back on the model: one draw, the first.
    pub(crate) fn stops_early(&mut self, corrective: bool) -> bool {
        let stops = self.keyframes.random::<f64>() < self.profile.stops_early;
        corrective && self.tally.count(Way::StopsEarly, stops)
    }

    /// The mistakes of the next skill.
    pub(crate) fn next_skill(&mut self) -> Slip {
        let [misaligned, side, wrong, which] = [0, 1, 2, 3].map(|_| self.skills.random::<f64>());
        let misaligned = self.tally.count(Way::Misaligned, misaligned < self.profile.misaligned.rate);
        let wrong = self.tally.count(Way::WrongReference, wrong < self.profile.wrong_reference);
        let angle = self.profile.misaligned.turn.to_radians() * if side < 0.5 { -1.0 } else { 1.0 };
        Slip { turn: about_z(if misaligned { angle } else { 0.0 }), wrong_reference: wrong.then_some(which) }
    }

    /// The mistakes of the next keyframe. Every keyframe takes the same number of draws from each stream, whatever comes of them.
    pub(crate) fn next(&mut self, contact: bool, commands: bool) -> Mistake {
        let profile = self.profile;
        let [spurious, missing, pause] = [0, 1, 2].map(|_| self.keyframes.random::<f64>());
        let off_path = self.noise(profile.free);
        let offset = self.noise(if contact { profile.contact } else { profile.free });
        let is_free = !contact && !commands;
        let spurious = self.tally.count(Way::Spurious, spurious < profile.spurious);
        let missing = is_free && self.tally.count(Way::Missing, missing < profile.missing);
        let pause = self.tally.count(Way::Pause, pause < profile.pause.rate);

        let [detour, height, turn] = [0, 1, 2].map(|_| self.detours.random::<f64>());
        let detour = self.tally.count(Way::Detour, detour < profile.detour.rate);
        let one_axis = self.axes.random::<f64>() < profile.one_axis;
        Mistake {
            spurious: spurious.then_some(off_path),
            detour: detour.then(|| upwards(height, turn) * profile.detour.reach),
            one_axis: self.tally.count(Way::OneAxis, one_axis),
            missing,
            pause: if pause { profile.pause.seconds } else { 0.0 },
            offset,
        }
    }

    fn noise(&mut self, noise: Noise) -> Isometry3<f64> {
        let normal = pose::Tangent::from_fn(|axis, _| {
            standard_normal(&mut self.keyframes) * if axis < 3 { noise.position } else { noise.rotation.to_radians() }
        });
        if noise == Noise::default() {
            return Isometry3::identity();
        }
        pose::exp(&Isometry3::identity(), &normal)
    }
}

/// When a teacher of this profile steps in: one draw a correction.
pub(crate) fn onset(profile: &Profile, seed: u64) -> Onset {
    let draw = ChaCha8Rng::seed_from_u64(stream(seed, "onset")).random::<f64>();
    if draw < profile.begins_early {
        Onset::Early
    } else if draw < profile.begins_early + profile.begins_late {
        Onset::Late
    } else {
        Onset::OnTime
    }
}

/// A turn about the z axis, radians.
fn about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    UnitQuaternion::new_unchecked(Quaternion::new(cosine, 0.0, 0.0, sine))
}

/// A direction of the upper half-space, all equally likely, from two numbers between 0 and 1 (Archimedes: the height is uniform).
fn upwards(height: f64, turn: f64) -> Vector3<f64> {
    let radius = libm::sqrt((1.0 - height * height).max(0.0));
    let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
    Vector3::new(radius * cosine, radius * sine, height)
}

/// The corners of the way from one pose to another along one axis after the other: up before sideways, sideways before down, so that
/// nothing is dragged along what it stands on. The gripper turns on the first leg. Axes with next to nothing to go have no corner.
pub(crate) fn corners(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
    /// Who has less than this to go along an axis does not notice it, metres.
    const LEAST: f64 = 0.01;
    let way = to.translation.vector - from.translation.vector;
    let order = if way.z > 0.0 { [2, 0, 1] } else { [0, 1, 2] };
    let legs: Vec<usize> = order.into_iter().filter(|axis| way[*axis].abs() >= LEAST).collect();
    let mut at = from.translation.vector;
    // The last leg ends at the keyframe itself, which is no corner.
    let corners = legs.iter().take(legs.len().saturating_sub(1)).map(|axis| {
        at[*axis] = to.translation.vector[*axis];
        Isometry3::from_parts(Translation3::from(at), to.rotation)
    });
    corners.collect()
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
    use crate::roster::Roster;
    use crate::tally::Count;

    /// Keyframes drawn. Each is free with a command, free without one, or a contact, in turn; every third begins a skill.
    const KEYFRAMES: u32 = 6000;
    /// Corrections drawn.
    const CORRECTIONS: u64 = 2000;

    fn named(name: &str) -> Profile {
        Roster::builtin().unwrap().get(name).unwrap().clone()
    }

    struct Drawn {
        keyframes: Vec<Mistake>,
        slips: Vec<Slip>,
        tally: Tally,
    }

    fn draws(profile: &Profile, seed: u64) -> Drawn {
        let mut mistakes = Mistakes::new(profile, seed);
        let (mut keyframes, mut slips) = (Vec::new(), Vec::new());
        for index in 0..KEYFRAMES {
            if index % 3 == 0 {
                slips.push(mistakes.next_skill());
            }
            keyframes.push(mistakes.next(index % 3 == 2, index % 3 != 1));
        }
        Drawn { keyframes, slips, tally: mistakes.tally }
    }

    /// Within the χ² interval about the configured deviation (quantiles by Wilson and Hilferty 1931), about a mean of 0.
    fn assert_deviation(name: &str, values: &[f64], deviation: f64) {
        /// The two-sided normal quantile of 0.05 / 13 / 2 profiles with noise: 5 % together (Bonferroni).
        const QUANTILE: f64 = 3.1;
        let count = values.len() as f64;
        let sum: f64 = values.iter().map(|value| (value / deviation) * (value / deviation)).sum();
        let bound = |quantile: f64| {
            let spread = 2.0 / (9.0 * count);
            count * (1.0 - spread + quantile * spread.sqrt()).powi(3)
        };
        assert!((bound(-QUANTILE)..=bound(QUANTILE)).contains(&sum), "{name}: {sum} of {count}");
    }

    #[test]
    fn what_is_tallied_is_what_is_drawn_and_as_often_as_configured() {
        let roster = Roster::builtin().unwrap();
        for profile in roster.profiles() {
            let Drawn { keyframes, slips, mut tally } = draws(profile, 1);
            let count = |has: &dyn Fn(&Mistake) -> bool| keyframes.iter().filter(|mistake| has(mistake)).count() as u32;
            let happened = |way| tally.of(way).happened;
            assert_eq!(happened(Way::Spurious), count(&|mistake| mistake.spurious.is_some()));
            assert_eq!(happened(Way::Missing), count(&|mistake| mistake.missing));
            assert_eq!(happened(Way::Pause), count(&|mistake| mistake.pause > 0.0));
            assert_eq!(happened(Way::Detour), count(&|mistake| mistake.detour.is_some()));
            assert_eq!(happened(Way::OneAxis), count(&|mistake| mistake.one_axis));
            let turned = slips.iter().filter(|slip| slip.turn.angle() > 0.0).count() as u32;
            assert_eq!(happened(Way::Misaligned), turned);
            let wrong = slips.iter().filter(|slip| slip.wrong_reference.is_some()).count() as u32;
            assert_eq!(happened(Way::WrongReference), wrong);
            // Neither a contact nor a command is ever missed.
            assert!(keyframes.iter().enumerate().all(|(index, mistake)| index % 3 == 1 || !mistake.missing));
            for seed in 0..CORRECTIONS {
                let mut mistakes = Mistakes::new(profile, seed);
                assert!(
                    !mistakes.stops_early(false) && mistakes.tally == Tally::default(),
                    "only corrections are stopped"
                );
                let mut mistakes = Mistakes::new(profile, seed);
                mistakes.stops_early(true);
                tally += mistakes.tally;
                let onset = onset(profile, seed);
                tally.count(Way::BeginsEarly, onset == Onset::Early);
                tally.count(Way::BeginsLate, onset == Onset::Late);
            }
            for way in Way::ALL {
                let Count { happened, chances } = tally.of(way);
                let of = match way.unit() {
                    "keyframes" => KEYFRAMES,
                    "corrections" => CORRECTIONS as u32,
                    _ => KEYFRAMES / 3,
                };
                assert_eq!(chances, of, "{}: {}", profile.name, way.name());
                let tails = tally.of(way).tails(way.rate(profile));
                let alpha = 0.05 / (Way::ALL.len() * roster.profiles().len()) as f64;
                assert!(tails >= alpha, "{}: {}: {happened} of {chances}: p = {tails}", profile.name, way.name());
            }
        }
    }

    #[test]
    fn noise_is_as_large_as_configured() {
        for profile in ["novice", "shaky"].map(named) {
            let Drawn { keyframes, tally, .. } = draws(&profile, 1);
            let tangents = |of: &dyn Fn(usize, &Mistake) -> Option<Isometry3<f64>>| -> Vec<pose::Tangent> {
                let poses = keyframes.iter().enumerate().filter_map(|(index, mistake)| of(index, mistake));
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
            assert_eq!(spurious.len(), tally.of(Way::Spurious).happened as usize);
            if !spurious.is_empty() {
                let values: Vec<f64> = spurious.iter().flat_map(|error| [error[0], error[1], error[2]]).collect();
                assert_deviation("spurious", &values, profile.free.position);
            }
        }
    }

    #[test]
    fn detours_lead_as_far_as_configured_and_never_down() {
        let profile = named("explorer");
        let detours: Vec<_> = draws(&profile, 1).keyframes.iter().filter_map(|mistake| mistake.detour).collect();
        assert!(detours.iter().all(|way| (way.norm() - profile.detour.reach).abs() < 1e-12 && way.z >= 0.0));
        // Uniform over the half-sphere: the heights are uniform, so their mean is half of the reach.
        let mean = detours.iter().map(|way| way.z).sum::<f64>() / detours.len() as f64 / profile.detour.reach;
        assert!((mean - 0.5).abs() < 4.0 / (12.0 * detours.len() as f64).sqrt(), "{mean}");
    }

    #[test]
    fn a_misaligned_gripper_is_turned_about_its_own_axis() {
        let profile = named("misaligned");
        let turns = draws(&profile, 1).slips.into_iter().map(|slip| slip.turn.scaled_axis());
        let angle = profile.misaligned.turn.to_radians();
        let seen: Vec<f64> = turns.map(|turn| if turn.xy().norm() < 1e-12 { turn.z } else { f64::NAN }).collect();
        assert!(seen.iter().all(|z| [-angle, 0.0, angle].iter().any(|allowed| (z - allowed).abs() < 1e-9)));
        assert!(seen.iter().any(|z| *z > 0.0) && seen.iter().any(|z| *z < 0.0), "either way");
    }

    #[test]
    fn corners_turn_at_right_angles_and_go_up_first_and_down_last() {
        let at = |x, y, z| Isometry3::translation(x, y, z);
        let way = |from, to| -> Vec<[f64; 3]> {
            corners(&from, &to).iter().map(|corner| corner.translation.vector.into()).collect()
        };
        assert_eq!(way(at(0.0, 0.0, 0.0), at(0.1, 0.2, 0.3)), [[0.0, 0.0, 0.3], [0.1, 0.0, 0.3]]);
        assert_eq!(way(at(0.1, 0.2, 0.3), at(0.0, 0.0, 0.0)), [[0.0, 0.2, 0.3], [0.0, 0.0, 0.3]]);
        assert_eq!(way(at(0.0, 0.0, 0.3), at(0.001, 0.2, 0.1)), [[0.0, 0.2, 0.3]]);
        assert!(way(at(0.0, 0.0, 0.3), at(0.0, 0.0, 0.1)).is_empty());
    }

    #[test]
    fn a_seed_is_a_teacher_and_a_rate_moves_no_other_draw() {
        let profile = named("novice");
        let offsets = |profile: &Profile, seed| {
            draws(profile, seed).keyframes.iter().map(|mistake| mistake.offset).collect::<Vec<_>>()
        };
        assert_eq!(offsets(&profile, 1), offsets(&profile, 1));
        assert_ne!(offsets(&profile, 1), offsets(&profile, 2));
        let other = Profile { spurious: 0.5, missing: 0.0, pause: Default::default(), ..profile.clone() };
        let other = Profile { one_axis: 1.0, detour: named("explorer").detour, wrong_reference: 0.5, ..other };
        assert_eq!(offsets(&other, 1), offsets(&profile, 1));
        assert_eq!(draws(&other, 1).tally.of(Way::Missing).happened, 0);
    }

    #[test]
    fn an_expert_errs_in_nothing() {
        let Drawn { keyframes, slips, tally } = draws(&named("expert"), 1);
        assert!(Way::ALL.iter().all(|way| tally.of(*way).happened == 0));
        for mistake in keyframes {
            assert!(mistake.offset == Isometry3::identity() && mistake.spurious.is_none());
            assert!(mistake.pause == 0.0 && !mistake.missing && mistake.detour.is_none() && !mistake.one_axis);
        }
        assert!(slips.iter().all(|slip| slip.turn == UnitQuaternion::identity() && slip.wrong_reference.is_none()));
    }
}
