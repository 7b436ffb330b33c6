//! Keyframes of one demonstration and the same keyframes of another, which may have some more.

use crate::demonstration::Pose;

/// How far the keyframes of one list are from the same keyframes of another, in position: metres.
///
/// People give a needless keyframe, and forget one. So the shorter list is laid into the longer one, in order, the rest
/// of which stays without a partner; of all ways to do that, the one counts in which the farthest pair is nearest. 0
/// where a list is empty.
pub fn displacement(left: &[Pose], right: &[Pose]) -> f64 {
    let (short, long) = if left.len() <= right.len() { (left, right) } else { (right, left) };
    // `farthest[j]`: of the best way to lay the keyframes up to here into the first j of the longer list.
    let mut farthest = vec![0.0; long.len() + 1];
    for (index, here) in short.iter().enumerate() {
        let mut diagonal = farthest[index];
        farthest[index] = f64::INFINITY;
        for j in index + 1..=long.len() {
            let apart = (here.translation.vector - long[j - 1].translation.vector).norm();
            let laid = f64::max(diagonal, apart);
            diagonal = farthest[j];
            farthest[j] = laid.min(farthest[j - 1]);
        }
    }
    farthest[long.len()]
}
