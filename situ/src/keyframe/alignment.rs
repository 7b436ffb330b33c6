//! The displacement of keyframes: two lists of the same keyframes, of which one may have some more.

use crate::demonstration::Pose;

/// How far the keyframes of one list are from the same keyframes of the other, in position: metres.
///
/// People give keyframes that nobody needs, and they forget some. So the shorter list is laid into the longer one, in
/// order. The other keyframes of the longer list have no partner. There are many ways to do that; this takes the one in
/// which the farthest pair is nearest. The displacement is 0 if a list is empty.
pub fn displacement(left: &[Pose], right: &[Pose]) -> f64 {
    let (short, long) = if left.len() <= right.len() { (left, right) } else { (right, left) };
    // `farthest[j]`: the farthest pair if the keyframes so far are laid into the first j of the longer list in the best
    // way.
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
