//! From segments to the steps of a STARHMM.
//!
//! A segment becomes a fixed number of points, uniform in arc length, relative to its reference object as everywhere
//! else (decision D0b). A rigid change of frame keeps densities comparable between objects. A point is the hand's
//! position and two points at a tenth of a metre along the hand's axes, which turn with the hand without a jump. These
//! are nine coordinates in centimetres. Those that vary most over all data are kept; a change in another coordinate
//! alone is not seen.
//!
//! A point is regressed on (1, u, u²), where u is the share of the arc length behind it. That is the action a_t of the
//! STARHMM: how far the motion was told to go. The state of the world is only seen once per segment; it decides what is
//! entered. The context is the object, and whether the hand is closed at the end (D6b).
//!
//! Interpolated points are not independent. Ten of them stand for three to five keyframes, so evidence is counted two
//! to three times. The floor of the variance, (2 cm)², bounds the effect.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::Vector3;

use super::parameters::ItmcdParameters;
use super::starhmm::StarhmmStep;
use crate::demonstration::{Gripper, Pose};
use crate::keyframe::interpolate::resample;
use crate::keyframe::pose::METRES_PER_RADIAN;
use crate::segment::Segment;
use crate::state::State;

/// The unit of a coordinate, metres.
pub const UNIT: f64 = 0.01;
/// The coordinates of a pose before the projection.
const COORDINATES: usize = 9;

/// How a world is seen: the contexts, and the coordinates and features that are kept.
pub(super) struct Frames {
    contexts: BTreeMap<(Arc<str>, bool), usize>,
    coordinates: Vec<usize>,
    features: Vec<usize>,
    scales: Vec<f64>,
    points: usize,
}

impl Frames {
    /// A view of these segments and states. `scales` has one scale per feature.
    pub(super) fn new(
        segments: &[&Segment],
        states: &[&State],
        scales: Vec<f64>,
        parameters: &ItmcdParameters,
    ) -> Self {
        let keys: BTreeSet<_> = segments.iter().map(|segment| key(segment)).collect();
        let points: Vec<Vec<f64>> =
            segments.iter().flat_map(|segment| path(segment, parameters.points)).map(|point| point.to_vec()).collect();
        let states: Vec<Vec<f64>> = states
            .iter()
            .map(|state| state.values().iter().zip(&scales).map(|(value, scale)| value / scale).collect())
            .collect();
        let mut coordinates = most_varied(&points, parameters.coordinates);
        if coordinates.is_empty() {
            // If the hand stands still everywhere, every coordinate is equally good, and a phase needs one.
            coordinates.push(0);
        }
        Self {
            contexts: keys.into_iter().zip(0..).collect(),
            coordinates,
            features: most_varied(&states, parameters.features),
            scales,
            points: parameters.points,
        }
    }

    /// The context of a segment.
    pub(super) fn context(&self, segment: &Segment) -> usize {
        self.contexts.get(&key(segment)).copied().unwrap_or(self.contexts.len())
    }

    /// ψ: 1, and the features that are kept, each divided by its scale.
    pub(super) fn entry_features(&self, state: &State) -> Vec<f64> {
        let kept = self.features.iter().map(|index| state.values()[*index] / self.scales[*index]);
        std::iter::once(1.0).chain(kept).collect()
    }

    /// The length of ψ.
    pub(super) fn entry_width(&self) -> usize {
        1 + self.features.len()
    }

    /// The steps of a segment in this context. `after` is the state that the segment reached. Its phase can end only at
    /// the last step, because the segmentation is known and an automaton runs whole primitives. φ is a constant.
    pub(super) fn steps(&self, segment: &Segment, context: usize, after: &State) -> Vec<StarhmmStep> {
        let entry_features = self.entry_features(after);
        let last = self.points - 1;
        path(segment, self.points)
            .into_iter()
            .enumerate()
            .map(|(index, point)| {
                let share = index as f64 / last as f64;
                StarhmmStep {
                    context,
                    regressors: vec![1.0, share, share * share],
                    target: self.coordinates.iter().map(|axis| point[*axis]).collect(),
                    can_end: index == last,
                    exit_features: vec![1.0],
                    entry_features: entry_features.clone(),
                }
            })
            .collect()
    }
}

/// The reference object, and whether the hand is closed at the end.
fn key(segment: &Segment) -> (Arc<str>, bool) {
    let last = segment.keyframes.last().map(|keyframe| keyframe.gripper);
    (segment.reference.clone(), matches!(last, Some(Gripper::Close(_))))
}

/// The points of a segment, in [`UNIT`].
fn path(segment: &Segment, points: usize) -> Vec<[f64; COORDINATES]> {
    let poses: Vec<Pose> = segment.keyframes.iter().map(|keyframe| keyframe.pose).collect();
    let arm = |pose: &Pose, axis: Vector3<f64>| pose.rotation * (axis * METRES_PER_RADIAN);
    resample(&poses, points, METRES_PER_RADIAN)
        .iter()
        .map(|pose| {
            let (position, x, z) = (pose.translation.vector, arm(pose, Vector3::x()), arm(pose, Vector3::z()));
            [position.x, position.y, position.z, x.x, x.y, x.z, z.x, z.y, z.z].map(|metres| metres / UNIT)
        })
        .collect()
}

/// The indices, in order, of the `count` columns with the greatest variance; the first if two tie. A column that does
/// not vary is left out.
fn most_varied(rows: &[Vec<f64>], count: usize) -> Vec<usize> {
    let width = rows.first().map_or(0, Vec::len);
    let size = rows.len() as f64;
    let variance = |column: usize| {
        let mean = rows.iter().map(|row| row[column]).sum::<f64>() / size;
        rows.iter().map(|row| (row[column] - mean) * (row[column] - mean)).sum::<f64>() / size
    };
    let mut columns: Vec<(f64, usize)> = (0..width).map(|column| (variance(column), column)).collect();
    columns.sort_by(|left, right| right.0.total_cmp(&left.0).then(left.1.cmp(&right.1)));
    let mut kept: Vec<usize> =
        columns.into_iter().filter(|(variance, _)| *variance > 0.0).take(count).map(|(_, column)| column).collect();
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::most_varied;

    /// It is the variance that counts: not the mean, and not the number of rows.
    #[test]
    fn the_columns_that_vary_most_are_kept() {
        let rows: Vec<Vec<f64>> = (0..8)
            .map(|row| {
                let sign = if row % 2 == 0 { 1.0 } else { -1.0 };
                vec![100.0 + sign, 2.0 * sign, 7.0, 0.5 * sign - 50.0, 2.0 * sign]
            })
            .collect();
        assert_eq!(most_varied(&rows, 1), [1]);
        assert_eq!(most_varied(&rows, 2), [1, 4]);
        assert_eq!(most_varied(&rows, 3), [0, 1, 4]);
        assert_eq!(most_varied(&rows, 9), [0, 1, 3, 4]);
        assert!(most_varied(&[], 3).is_empty());
    }
}
