//! Keyframes of a correction laid against those of a primitive: sequence alignment (Needleman and Wunsch 1970).

use crate::demonstration::{Gripper, Pose, RelativeKeyframe};
use crate::keyframe::frechet::METRES_PER_RADIAN;
use crate::keyframe::pose::{exp, log};

/// What a keyframe without a partner costs, metres. So two keyframes are partners at up to twice this, 30 cm: further
/// than a modification of a primitive moves one (8 to 12 cm), nearer than another place for the same object (40 cm).
const UNPAIRED: f64 = 0.15;
/// Opening below which a hand that is commanded a share of its stroke counts as closed: the middle.
const CLOSED_BELOW: f64 = 0.5;
/// Points at which a leg between two keyframes is looked at: 1.5 cm apart on one of 30 cm.
const POINTS_A_LEG: usize = 20;

/// What of a keyframe is aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Pose of the gripper in the frame of the reference object.
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

/// Which stops are contacts: those at which the hand closes or opens. The first is none: what the hand did before is
/// another primitive's.
pub fn contacts(stops: &[Stop]) -> Vec<bool> {
    (0..stops.len()).map(|index| index > 0 && stops[index].is_closed() != stops[index - 1].is_closed()).collect()
}

/// Metres between two poses, a radian counting a tenth.
pub fn distance(left: &Pose, right: &Pose) -> f64 {
    let apart = log(left, right);
    let norm = |from: usize| libm::sqrt((from..from + 3).map(|axis| apart[axis] * apart[axis]).sum::<f64>());
    norm(0) + METRES_PER_RADIAN * norm(3)
}

/// The partners, `(index in model, index in shown)`, in order; both indices grow.
///
/// Of all ways to pair the two lists in order, the one with the least cost: the distance of each pair, and 15 cm for
/// each stop that is left alone. A stop at which the hand is closed is never the partner of one at which it is open.
/// Where two ways cost the same, stops are paired rather than left alone. Cost O(model × shown).
pub fn align(model: &[Stop], shown: &[Stop]) -> Vec<(usize, usize)> {
    let (rows, columns) = (model.len() + 1, shown.len() + 1);
    let pair = |i: usize, j: usize| {
        let possible = model[i].is_closed() == shown[j].is_closed();
        if possible { distance(&model[i].pose, &shown[j].pose) } else { f64::INFINITY }
    };
    // `least[i * columns + j]`: of the best way to lay the first i stops of the model against the first j shown.
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
        // The same sums as above, so that equality is exact.
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

/// How far a pose is from the path along straight legs through `path`: metres, a radian counting a tenth; and where on
/// the path it is nearest, in legs from the beginning. None where the path has no leg.
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
