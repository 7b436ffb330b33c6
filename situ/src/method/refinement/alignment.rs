//! The alignment of the keyframes of a correction with those of a primitive: sequence alignment (Needleman and Wunsch
//! 1970).

use crate::demonstration::{Gripper, Pose};
use crate::keyframe::pose::{METRES_PER_RADIAN, arc_length, exp, log};
use crate::segment::RelativeKeyframe;

/// The cost of a keyframe without a partner, metres. So two keyframes can be partners at up to twice this, 30 cm. That
/// is more than a modification of a primitive moves a keyframe (8 to 12 cm), and less than the distance to another
/// place for the same object (40 cm).
const UNPAIRED: f64 = 0.15;
/// A hand that is commanded a smaller share of its stroke than this, the middle, counts as closed.
const CLOSED_BELOW: f64 = 0.5;
/// The points at which a leg between two keyframes is examined: 1.5 cm apart on a leg of 30 cm.
const POINTS_A_LEG: usize = 20;

/// The part of a keyframe that is aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The pose of the gripper in the frame of the reference object.
    pub pose: Pose,
    /// The command in force from here on.
    pub gripper: Gripper,
}

impl From<&RelativeKeyframe> for Stop {
    fn from(keyframe: &RelativeKeyframe) -> Self {
        Self { pose: keyframe.pose, gripper: keyframe.gripper }
    }
}

impl Stop {
    /// Whether the command closes the hand.
    pub fn is_closed(&self) -> bool {
        match self.gripper {
            Gripper::Close(_) => true,
            Gripper::Open(_) => false,
            Gripper::Opening(share) => share < CLOSED_BELOW,
        }
    }
}

/// Which stops are contacts, where the hand closes or opens. The first stop is no contact: what the hand did before it
/// belongs to another primitive.
pub fn contacts(stops: &[Stop]) -> Vec<bool> {
    (0..stops.len()).map(|index| index > 0 && stops[index].is_closed() != stops[index - 1].is_closed()).collect()
}

/// The distance of two poses in metres, where a radian counts a tenth of a metre.
pub fn distance(left: &Pose, right: &Pose) -> f64 {
    arc_length(&log(left, right), METRES_PER_RADIAN)
}

/// The partners, `(index in model, index in shown)`, in order; both indices grow.
///
/// Of all ways to pair the two lists in order, this is the one with the least cost. The cost is the distance of each
/// pair, and 15 cm for each stop without a partner. A stop with a closed hand is never the partner of a stop with an
/// open hand. If two ways cost the same, stops are paired rather than left alone. O(model × shown).
pub fn align(model: &[Stop], shown: &[Stop]) -> Vec<(usize, usize)> {
    let (rows, columns) = (model.len() + 1, shown.len() + 1);
    let pair = |i: usize, j: usize| {
        let possible = model[i].is_closed() == shown[j].is_closed();
        if possible { distance(&model[i].pose, &shown[j].pose) } else { f64::INFINITY }
    };
    // `least[i * columns + j]`: the least cost of aligning the first i stops of the model with the first j shown.
    let mut least = vec![0.0; rows * columns];
    for i in 0..rows {
        for j in 0..columns {
            least[i * columns + j] = match (i, j) {
                (0, _) | (_, 0) => UNPAIRED * (i + j) as f64,
                _ => {
                    let alone = least[(i - 1) * columns + j].min(least[i * columns + j - 1]) + UNPAIRED;
                    alone.min(least[(i - 1) * columns + j - 1] + pair(i - 1, j - 1))
                }
            };
        }
    }
    let mut pairs = Vec::new();
    let (mut i, mut j) = (model.len(), shown.len());
    while i > 0 && j > 0 {
        // These are the same sums as above, so equality is exact.
        let here = least[i * columns + j];
        if here == least[(i - 1) * columns + j - 1] + pair(i - 1, j - 1) {
            (i, j) = (i - 1, j - 1);
            pairs.push((i, j));
        } else if here == least[(i - 1) * columns + j] + UNPAIRED {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    pairs.reverse();
    pairs
}

/// The distance of a pose from the path of straight legs through `path`, and where on the path it is nearest. The
/// distance is in metres, where a radian counts a tenth of a metre; the place is in legs from the beginning. `None` if
/// the path has no leg.
pub fn off_path(pose: &Pose, path: &[Pose]) -> Option<(f64, f64)> {
    let legs = path.windows(2).enumerate().flat_map(|(leg, ends)| {
        let whole = log(&ends[0], &ends[1]);
        (0..=POINTS_A_LEG).map(move |point| {
            let share = point as f64 / POINTS_A_LEG as f64;
            (distance(&exp(&ends[0], &(whole * share)), pose), leg as f64 + share)
        })
    });
    legs.reduce(|nearest, other| if other.0 < nearest.0 { other } else { nearest })
}
