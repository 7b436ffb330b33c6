//! Draws of a teacher's mistakes, all from one seed.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::keyframe::pose;
use situ::random::{standard_normal, stream};

use crate::extent::{Noise, Spread};
use crate::path::{about_z, corners, displaced, half_way, upwards};
use crate::profile::{Profile, Way};
use crate::tally::Tally;

/// What goes wrong at one keyframe.
pub(crate) struct Mistake {
    /// The error of a needless keyframe before this one.
    spurious: Option<Isometry3<f64>>,
    /// The excursion before this one: a displacement from the middle of the way, metres, world frame.
    detour: Option<Vector3<f64>>,
    /// Whether the way leads along one axis after the other.
    one_axis: bool,
    /// Whether it is not recorded.
    pub(crate) missing: bool,
    /// Seconds.
    pub(crate) pause: f64,
    /// The error of its pose.
    pub(crate) offset: Isometry3<f64>,
}

impl Mistake {
    /// The keyframes that a teacher gives on the way from one pose to another, and need not give.
    pub(crate) fn needless(&self, start: &Isometry3<f64>, target: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
        let middle = half_way(start, target);
        let detour = self.detour.map(|way| {
            let mut out = middle;
            out.translation.vector += way;
            out
        });
        let mut needless: Vec<Isometry3<f64>> = detour.into_iter().collect();
        needless.extend(self.spurious.as_ref().map(|error| displaced(&middle, error)));
        if self.one_axis {
            let from = needless.last().copied().unwrap_or(*start);
            needless.extend(corners(&from, target));
        }
        needless
    }
}

/// What goes wrong with a skill as a whole.
pub(crate) struct Slip {
    /// The turn of the gripper about its own z axis.
    pub(crate) turn: UnitQuaternion<f64>,
    /// Which of the other objects is named in place of the reference object, as a fraction of their number.
    pub(crate) wrong_reference: Option<f64>,
    /// Whether the reference object is named, be it that of the skill before.
    pub(crate) announced: bool,
}

/// The streams of random numbers of a demonstration's mistakes. Each kind has its own stream, so a rate can change and
/// the draws of the other kinds stay.
pub(crate) struct Mistakes<'a> {
    profile: &'a Profile,
    /// Noise, needless and missing keyframes, pauses, early ends.
    keyframes: ChaCha8Rng,
    detours: ChaCha8Rng,
    axes: ChaCha8Rng,
    skills: ChaCha8Rng,
    announcements: ChaCha8Rng,
    grasps: ChaCha8Rng,
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
            announcements: rng("announcements"),
            grasps: rng("grasps"),
            tally: Tally::default(),
        }
    }

    /// Whether this draw is an error: it counts as one more chance of that way of erring.
    fn errs(&mut self, way: Way, draw: f64) -> bool {
        self.tally.count(way, draw < self.profile.rate(way))
    }

    /// Whether a demonstration is stopped once back on the model. This is one draw, the first, and only a correction is
    /// stopped.
    pub(crate) fn stops_early(&mut self, corrective: bool) -> bool {
        let draw = self.keyframes.random::<f64>();
        corrective && self.errs(Way::StopsEarly, draw)
    }

    /// The mistakes of the next skill.
    pub(crate) fn next_skill(&mut self) -> Slip {
        let [misaligned, side, wrong, which] = [0, 1, 2, 3].map(|_| self.skills.random::<f64>());
        let misaligned = self.errs(Way::Misaligned, misaligned);
        let wrong = self.errs(Way::WrongReference, wrong);
        let unannounced = self.announcements.random::<f64>();
        let unannounced = self.errs(Way::Unannounced, unannounced);
        let angle = self.profile.misaligned.turn.to_radians() * if side < 0.5 { -1.0 } else { 1.0 };
        Slip {
            turn: about_z(if misaligned { angle } else { 0.0 }),
            wrong_reference: wrong.then_some(which),
            announced: !unannounced,
        }
    }

    /// Whether this teacher takes things in other ways than the script does.
    pub(crate) fn varies_grasps(&self) -> bool {
        self.profile.varies_grasps()
    }

    /// A way to take a thing, off from the script's: in the gripper's frame.
    pub(crate) fn next_grasp(&mut self) -> Isometry3<f64> {
        let Spread { position, rotation, freedom } = self.profile.grasp;
        let [side, which, half] = [0, 1, 2].map(|_| self.grasps.random::<f64>());
        let [x, y, turn] = [0, 1, 2].map(|_| standard_normal(&mut self.grasps));
        let squares: f64 = (0..freedom).map(|_| standard_normal(&mut self.grasps)).map(|normal| normal * normal).sum();
        let tail = if freedom == 0 { 0.0 } else { libm::sqrt(f64::from(freedom) / squares.max(f64::MIN_POSITIVE)) };
        let quarter = if which < 0.5 { -FRAC_PI_2 } else { FRAC_PI_2 };
        let mut angle = turn * tail * rotation.to_radians();
        angle += if self.errs(Way::OtherSide, side) { quarter } else { 0.0 };
        angle += if self.errs(Way::HalfTurn, half) { PI } else { 0.0 };
        Isometry3::from_parts(Translation3::new(x * tail * position, y * tail * position, 0.0), about_z(angle))
    }

    /// The mistakes of the next keyframe. Every keyframe takes the same number of draws from each stream, whatever
    /// comes of them.
    pub(crate) fn next(&mut self, contact: bool, commands: bool) -> Mistake {
        let profile = self.profile;
        let [spurious, missing, pause] = [0, 1, 2].map(|_| self.keyframes.random::<f64>());
        let off_path = self.noise(profile.free);
        let offset = self.noise(if contact { profile.contact } else { profile.free });
        let [detour, height, turn] = [0, 1, 2].map(|_| self.detours.random::<f64>());
        let one_axis = self.axes.random::<f64>();
        let is_free = !contact && !commands;
        Mistake {
            spurious: self.errs(Way::Spurious, spurious).then_some(off_path),
            detour: self.errs(Way::Detour, detour).then(|| upwards(height, turn) * profile.detour.reach),
            one_axis: self.errs(Way::OneAxis, one_axis),
            missing: is_free && self.errs(Way::Missing, missing),
            pause: if self.errs(Way::Pause, pause) { profile.pause.seconds } else { 0.0 },
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::onset::{Onset, onset};
    use crate::roster::Roster;
    use crate::tally::Count;

    /// Keyframes drawn. Each is free with a command, free without one, or a contact, in turn; every third begins a
    /// skill.
    const KEYFRAMES: u32 = 6000;
    /// Corrections drawn.
    const CORRECTIONS: u64 = 2000;

    fn named(name: &str) -> Profile {
        Roster::builtin().unwrap().get(name).unwrap().clone()
    }

    struct Drawn {
        keyframes: Vec<Mistake>,
        slips: Vec<Slip>,
        grasps: Vec<Isometry3<f64>>,
        tally: Tally,
    }

    fn draws(profile: &Profile, seed: u64) -> Drawn {
        let mut mistakes = Mistakes::new(profile, seed);
        let (mut keyframes, mut slips, mut grasps) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..KEYFRAMES {
            if index % 3 == 0 {
                slips.push(mistakes.next_skill());
                grasps.push(mistakes.next_grasp());
            }
            keyframes.push(mistakes.next(index % 3 == 2, index % 3 != 1));
        }
        Drawn { keyframes, slips, grasps, tally: mistakes.tally }
    }

    /// Asserts that the values are within the χ² interval about the configured deviation, with a mean of 0. Quantiles
    /// by Wilson and Hilferty (1931).
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
            let Drawn { keyframes, slips, mut tally, .. } = draws(profile, 1);
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
                let tails = tally.of(way).tails(profile.rate(way));
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

    /// Student's t of two degrees of freedom has the distribution function 1/2 + t / 2√(2 + t²).
    #[test]
    fn grasps_are_off_by_a_t_in_the_plane_and_turned_as_often_as_tallied() {
        let profile = named("person");
        let only_spread = Profile { other_side: 0.0, half_turn: 0.0, ..profile.clone() };
        let spread = only_spread.grasp;
        let drawn = draws(&only_spread, 1).grasps;
        assert!(drawn.iter().all(|grasp| grasp.translation.z == 0.0 && grasp.rotation.imag().xy().norm() == 0.0));
        for limit in [0.5_f64, 1.0, 2.0, 4.0, 8.0] {
            let share = limit / (2.0 + limit * limit).sqrt();
            let deviation = (share * (1.0 - share) / drawn.len() as f64).sqrt();
            for axis in 0..2 {
                let within =
                    drawn.iter().filter(|grasp| grasp.translation.vector[axis].abs() < limit * spread.position);
                let seen = within.count() as f64 / drawn.len() as f64;
                assert!((seen - share).abs() < 3.5 * deviation, "axis {axis}: {seen} within {limit}, not {share}");
            }
        }
        for (name, angle, way) in [("sideways", FRAC_PI_2, Way::OtherSide), ("flipped", PI, Way::HalfTurn)] {
            let Drawn { grasps, tally, .. } = draws(&named(name), 1);
            let turned = grasps.iter().filter(|grasp| (grasp.rotation.angle() - angle).abs() < 1e-9).count();
            assert_eq!(tally.of(way).happened as usize, turned, "{name}");
            assert!(grasps.iter().any(|grasp| grasp.rotation.imag().z < 0.0) == (way == Way::OtherSide), "{name}");
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
        let Drawn { keyframes, slips, grasps, tally } = draws(&named("expert"), 1);
        assert!(Way::ALL.iter().all(|way| tally.of(*way).happened == 0));
        for mistake in keyframes {
            assert!(mistake.offset == Isometry3::identity() && mistake.spurious.is_none());
            assert!(mistake.pause == 0.0 && !mistake.missing && mistake.detour.is_none() && !mistake.one_axis);
        }
        assert!(grasps.iter().all(|grasp| *grasp == Isometry3::identity()));
        assert!(slips.iter().all(|slip| slip.turn == UnitQuaternion::identity() && slip.wrong_reference.is_none()));
    }
}
