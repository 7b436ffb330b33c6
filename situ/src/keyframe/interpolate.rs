//! Interpolation of keyframes, uniform in arc length (decision D5).

use nalgebra::Translation3;

use super::pose::{arc_length, log, rotation_exp};
use crate::demonstration::Pose;

/// `n` poses along the path through `poses`, uniform in arc length, with the first and the last.
///
/// Positions are joined by straight lines, rotations by the shortest turn at an even rate. The arc length of a leg is
/// its metres plus `metres_per_radian` × its radians. A single pose, or a path of length 0, gives `n` copies of the
/// first pose. No pose gives none.
pub fn resample(poses: &[Pose], n: usize, metres_per_radian: f64) -> Vec<Pose> {
    let Some((first, last)) = poses.first().zip(poses.last()) else { return Vec::new() };
    let legs: Vec<_> = poses.windows(2).map(|pair| log(&pair[0], &pair[1])).collect();
    let mut reached = Vec::with_capacity(poses.len());
    let mut length = 0.0;
    reached.push(length);
    for leg in &legs {
        length += arc_length(leg, metres_per_radian);
        reached.push(length);
    }
    if length <= 0.0 || n < 2 {
        return vec![*first; n];
    }
    let mut leg = 0;
    (0..n)
        .map(|index| {
            if index == 0 {
                return *first;
            }
            if index == n - 1 {
                return *last;
            }
            let at = length * index as f64 / (n - 1) as f64;
            while leg + 1 < legs.len() && reached[leg + 1] < at {
                leg += 1;
            }
            let span = reached[leg + 1] - reached[leg];
            let share = if span > 0.0 { ((at - reached[leg]) / span).clamp(0.0, 1.0) } else { 0.0 };
            let (base, step) = (&poses[leg], legs[leg] * share);
            Pose::from_parts(
                Translation3::from(base.translation.vector + step.fixed_rows::<3>(0)),
                base.rotation * rotation_exp(&step.fixed_rows::<3>(3).into_owned()),
            )
        })
        .collect()
}
