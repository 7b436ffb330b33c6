//! Two lists of the same keyframes, of which one may have some more, laid into each other.
//!
//! People give keyframes that nobody needs, and they forget some. So the shorter list is laid into the longer one, in
//! order. The other keyframes of the longer list have no partner.

use crate::demonstration::Pose;

/// A keyframe as it is laid: its pose, and whether the hand closes or opens there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laid {
    /// The pose, relative to the reference object.
    pub pose: Pose,
    /// Whether the hand closes or opens there.
    pub is_contact: bool,
}

/// How far the keyframes of one list are from the same keyframes of the other, in position, in the units that `unit`
/// gives for two keyframes that are both a contact, and for two others. There are many ways to lay one list into the
/// other; this takes the one in which the farthest pair is nearest. So many keyframes of the shorter list may be left
/// out, too, if they are no contact: where one demonstration has a needless keyframe and lacks another, the lists are
/// as long as each other. At least one pair is laid. 0 if a list is empty.
pub fn displacement(left: &[Laid], right: &[Laid], left_out: usize, unit: impl Fn(bool) -> f64) -> f64 {
    let (short, long) = if left.len() <= right.len() { (left, right) } else { (right, left) };
    let left_out = left_out.min(short.len().saturating_sub(1));
    // `farthest[k][j]`: the farthest pair if the keyframes so far, but for k of them, are laid into the first j of the
    // longer list in the best way.
    let mut farthest = vec![vec![0.0; long.len() + 1]; left_out + 1];
    farthest[1..].iter_mut().for_each(|row| row.fill(f64::INFINITY));
    for here in short {
        for k in (0..=left_out).rev() {
            let without: Vec<f64> = match k.checked_sub(1).filter(|_| !here.is_contact) {
                Some(fewer) => farthest[fewer].clone(),
                None => vec![f64::INFINITY; long.len() + 1],
            };
            let row = &mut farthest[k];
            let mut diagonal = row[0];
            row[0] = without[0];
            for j in 1..=long.len() {
                let there = &long[j - 1];
                let apart = distance(here, there) / unit(here.is_contact && there.is_contact);
                let laid = f64::max(diagonal, apart);
                diagonal = row[j];
                row[j] = laid.min(row[j - 1]).min(without[j]);
            }
        }
    }
    farthest.iter().map(|row| row[long.len()]).fold(f64::INFINITY, f64::min)
}

fn distance(left: &Laid, right: &Laid) -> f64 {
    (left.pose.translation.vector - right.pose.translation.vector).norm()
}

/// The indices of the keyframes that are partners, with the least sum of squared distances.
pub fn partners(left: &[Laid], right: &[Laid]) -> Vec<(usize, usize)> {
    if left.len() > right.len() {
        return partners(right, left).into_iter().map(|(right, left)| (left, right)).collect();
    }
    let columns = right.len() + 1;
    // The least sum if the first `row` keyframes are laid into the first `column` of the longer list.
    let mut sums = vec![f64::INFINITY; (left.len() + 1) * columns];
    sums[..columns].fill(0.0);
    for row in 1..=left.len() {
        for column in row..columns {
            let apart = distance(&left[row - 1], &right[column - 1]);
            let laid = sums[(row - 1) * columns + column - 1] + apart * apart;
            sums[row * columns + column] = laid.min(sums[row * columns + column - 1]);
        }
    }
    let mut pairs = Vec::with_capacity(left.len());
    let mut column = right.len();
    for row in (1..=left.len()).rev() {
        while column > row && sums[row * columns + column] == sums[row * columns + column - 1] {
            column -= 1;
        }
        pairs.push((row - 1, column - 1));
        column -= 1;
    }
    pairs.reverse();
    pairs
}
