//! Segments as points of phase, contact and pose.

use super::super::alignment::{Stop, align};
use crate::demonstration::Pose;
use crate::keyframe::pose::{exp, log};
use crate::segment::RelativeKeyframe;

/// The numbers of a point.
pub const DIMENSIONS: usize = 8;
/// Phase 0 to 1, contact 0 or 1, and the pose in the tangent space at the base: metres (3), radians (3).
pub type Point = [f64; DIMENSIONS];

/// The points of a leg, the later keyframe included.
const POINTS_A_LEG: usize = 5;

fn contact(stop: &Stop) -> f64 {
    if stop.is_closed() { 1.0 } else { 0.0 }
}

/// The phase of keyframe `index` of `count`.
fn phase(index: f64, count: usize) -> f64 {
    index / count.saturating_sub(1).max(1) as f64
}

/// The input at keyframe `index` of the primitive: its phase, and the contact on the way there.
pub(super) fn input(stops: &[Stop], index: usize) -> [f64; 2] {
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
pub(super) fn of(stops: &[Stop], base: &Pose, keyframes: &[RelativeKeyframe]) -> Vec<Point> {
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
