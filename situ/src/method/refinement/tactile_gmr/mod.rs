//! `tactile_gmr`: Gaussian mixture regression of pose from phase and contact (Sauser, Argall, Metta and Billard 2012).
//!
//! The original adapts a robot's grasp. It has a Gaussian mixture over posture and the readings of tactile cells,
//! regressed at execution. After a person has pushed the fingers, the mixture is fitted again to the original and the
//! corrected data. This is a *reconstruction*: our scenes have no tactile cells, so the contact is whether the hand is
//! commanded to be closed, and the time is a phase.
//!
//! - **Data**: points along the way through a segment's keyframes, five per leg. A point has the phase, the contact on
//!   the way there, and the pose in the tangent space at the mean pose of the primitive (6). The phase of keyframe k of
//!   the primitive's K keyframes is k/(K−1). A segment's keyframes get the phases of their partners
//!   ([`super::alignment`]), and even phases between them. Before the first and after the last partner, phases continue
//!   to 0 and 1; what is beyond is left out.
//! - **Model**: one Gaussian per leg, which starts from the points of its leg, because on a leg the pose is linear in
//!   the phase. The fit is maximum a posteriori by expectation maximisation ([`mixture`]). Where two legs meet, their
//!   Gaussians predict the same pose, so little is smoothed away there.
//! - **Correction**: its points are added to the data, and everything is fitted anew. All corrections together weigh
//!   [`CORRECTED_WEIGHT`] times the originals. Only data are weighed, so a part of the way that no correction shows
//!   stays as it was.
//! - **Execution**: the regression at the K phases of the original's keyframes, with its grip commands and rests. The
//!   number of keyframes never changes.
//!
//! Before the first correction a primitive does what the original policy does. From then on its regression is executed,
//! which is within two millimetres of the original policy.

pub mod mixture;

use nalgebra::{Matrix6, Vector6};
use serde::Serialize;

use self::mixture::{CovariancePrior, Mixture, fit, regress};
use super::alignment::{Stop, align};
use super::refine::{Refine, RefinedKeyframe};
use crate::demonstration::Pose;
use crate::error::SituError;
use crate::keyframe::policy::KeyframePolicy;
use crate::keyframe::pose::{exp, karcher_mean, log};
use crate::segment::{RelativeKeyframe, Segment};
use crate::trace::Counters;

/// The numbers of a point.
pub const DIMENSIONS: usize = 8;
/// Phase 0 to 1, contact 0 or 1, and the pose in the tangent space at the base: metres (3), radians (3).
pub type Point = [f64; DIMENSIONS];

/// The points of a leg, the later keyframe included.
const POINTS_A_LEG: usize = 5;
/// The weight of all corrections together, where that of the originals is 1. With a weight of 1, a keyframe that is
/// moved by 12 cm ends 6 cm short. With nine it is 1.2 cm short, which a grasp tolerates.
pub const CORRECTED_WEIGHT: f64 = 9.0;
/// The prior standard deviations: phase; contact, which is 0 or 1; metres; radians (1°). They are small compared with a
/// leg, so the leg determines the regression.
const PRIOR: CovariancePrior<DIMENSIONS> = CovariancePrior {
    deviations: [0.01, 0.05, 0.003, 0.003, 0.003, 0.0175, 0.0175, 0.0175],
    // One point, which is just enough to keep a covariance regular.
    weight: 1.0,
};

/// Refines by Gaussian mixture regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TactileGmr;

/// A primitive: its data and their mixture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MixturePrimitive {
    /// The keyframes of the original policy. Their number, grips and rests are executed.
    original: Vec<RelativeKeyframe>,
    /// The pose at which the tangent space is taken.
    base: Pose,
    /// The points of the originals.
    points: Vec<Point>,
    /// The points of each correction.
    corrected: Vec<Vec<Point>>,
    mixture: Mixture<DIMENSIONS>,
}

impl MixturePrimitive {
    fn stops(&self) -> Vec<Stop> {
        self.original.iter().map(Stop::from).collect()
    }

    /// Fits the mixture to all data.
    fn refit(&mut self, counters: &mut Counters) -> Result<(), SituError> {
        let legs = self.original.len().saturating_sub(1).max(1);
        let share = CORRECTED_WEIGHT * self.points.len() as f64 / self.corrected.len().max(1) as f64;
        let mut weights = vec![1.0; self.points.len()];
        let mut points = self.points.clone();
        for correction in &self.corrected {
            weights.extend(correction.iter().map(|_| share / correction.len() as f64));
            points.extend(correction);
        }
        // The leg that ends at the phase, or after it.
        let labels: Vec<usize> = points
            .iter()
            .map(|point| (libm::ceil(point[0] * legs as f64) as usize).saturating_sub(1).min(legs - 1))
            .collect();
        let fit = fit(&points, &weights, &labels, legs, &PRIOR)?;
        counters.em_iterations += fit.objective.len() as u64;
        self.mixture = fit.mixture;
        Ok(())
    }
}

impl Refine for TactileGmr {
    type Primitive = MixturePrimitive;

    fn fit(
        &self,
        original: &KeyframePolicy,
        segments: &[&Segment],
        counters: &mut Counters,
    ) -> Result<MixturePrimitive, SituError> {
        let keyframes = original.mean_keyframes();
        let means: Vec<Pose> = keyframes.iter().map(|keyframe| keyframe.pose).collect();
        let mut primitive = MixturePrimitive {
            original: keyframes,
            base: karcher_mean(&means, &vec![1.0; means.len()]),
            points: Vec::new(),
            corrected: Vec::new(),
            mixture: Mixture::default(),
        };
        let stops = primitive.stops();
        for segment in segments {
            counters.segments_touched += 1;
            primitive.points.extend(points_of(&stops, &primitive.base, &segment.keyframes));
        }
        primitive.refit(counters)?;
        Ok(primitive)
    }

    fn correct(
        &self,
        primitive: &mut MixturePrimitive,
        shown: &Segment,
        counters: &mut Counters,
    ) -> Result<(), SituError> {
        counters.segments_touched += 1;
        let points = points_of(&primitive.stops(), &primitive.base, &shown.keyframes);
        if points.is_empty() {
            return Ok(());
        }
        primitive.corrected.push(points);
        primitive.refit(counters)
    }

    fn keyframes(&self, primitive: &MixturePrimitive) -> Vec<RefinedKeyframe> {
        let stops = primitive.stops();
        let keyframe = |(index, original): (usize, &RelativeKeyframe)| {
            let input = input(&stops, index);
            let (mean, covariance) = regress::<2, 6, DIMENSIONS>(&primitive.mixture, &input);
            RefinedKeyframe {
                mean: RelativeKeyframe { pose: exp(&primitive.base, &Vector6::from(mean)), ..*original },
                scatter: Matrix6::from_fn(|row, column| covariance[row][column]),
            }
        };
        primitive.original.iter().enumerate().map(keyframe).collect()
    }
}

fn contact(stop: &Stop) -> f64 {
    if stop.is_closed() { 1.0 } else { 0.0 }
}

/// The phase of keyframe `index` of `count`.
fn phase(index: f64, count: usize) -> f64 {
    index / count.saturating_sub(1).max(1) as f64
}

/// The input at keyframe `index` of the primitive: its phase, and the contact on the way there.
fn input(stops: &[Stop], index: usize) -> [f64; 2] {
    [phase(index as f64, stops.len()), contact(&stops[index.saturating_sub(1)])]
}

/// The phase of each shown keyframe. `None` if it is beyond the primitive.
fn phases(stops: &[Stop], shown: &[Stop]) -> Vec<Option<f64>> {
    let mut knots = align(stops, shown);
    let (last, last_shown) = (stops.len() - 1, shown.len() - 1);
    // From the first partner back to the beginning, and from the last on to the end, if both have something there.
    if knots.first().is_none_or(|(i, j)| *i > 0 && *j > 0) {
        knots.insert(0, (0, 0));
    }
    if knots.last().is_none_or(|(i, j)| *i < last && *j < last_shown) {
        knots.push((last, last_shown));
    }
    let mut phases = vec![None; shown.len()];
    for pair in knots.windows(2) {
        let ((i, j), (next, next_shown)) = (pair[0], pair[1]);
        let steps = (next_shown - j).max(1) as f64;
        for (step, known) in phases[j..=next_shown].iter_mut().enumerate() {
            *known = Some(phase(i as f64 + step as f64 / steps * (next - i) as f64, stops.len()));
        }
    }
    if let [(i, j)] = knots[..] {
        phases[j] = Some(phase(i as f64, stops.len()));
    }
    phases
}

/// The points of a segment with these keyframes, at least one, for a primitive with these stops, at least one. `base`
/// is the pose at which the tangent space is taken.
fn points_of(stops: &[Stop], base: &Pose, keyframes: &[RelativeKeyframe]) -> Vec<Point> {
    let shown: Vec<Stop> = keyframes.iter().map(Stop::from).collect();
    let point = |phase: f64, contact: f64, pose: &Pose| -> Point {
        let tangent = log(base, pose);
        [phase, contact, tangent[0], tangent[1], tangent[2], tangent[3], tangent[4], tangent[5]]
    };
    let mut points = Vec::new();
    let mut before: Option<(f64, &Stop)> = None;
    for (phase, stop) in phases(stops, &shown).into_iter().zip(&shown) {
        let Some(phase) = phase else { continue };
        match before {
            None => points.push(point(phase, contact(stop), &stop.pose)),
            Some((from, start)) => {
                let leg = log(&start.pose, &stop.pose);
                points.extend((1..=POINTS_A_LEG).map(|step| {
                    let share = step as f64 / POINTS_A_LEG as f64;
                    point(from + share * (phase - from), contact(start), &exp(&start.pose, &(leg * share)))
                }));
            }
        }
        before = Some((phase, stop));
    }
    points
}
