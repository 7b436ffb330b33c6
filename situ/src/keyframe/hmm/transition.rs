//! The chain of a left-to-right model: which ways are open, and their probabilities from counts.

/// The farthest state that state `from` of `states` can go to: the next, or the one after it if states can be skipped.
pub(super) fn farthest(from: usize, states: usize, skip: bool) -> usize {
    (from + 1 + usize::from(skip)).min(states - 1)
}

/// The last state that a sequence can start in: the first, or the second if states can be skipped.
pub(super) fn last_start(states: usize, skip: bool) -> usize {
    usize::from(skip).min(states - 1)
}

/// The probabilities, none below `floor`, that maximise Σ count · log probability. They overwrite the counts.
///
/// A probability that would be below the floor is put on the floor. The others share the rest in proportion to their
/// counts, until none is below. That is the constrained maximum, so a re-estimation never lowers the likelihood.
/// Returns false, and changes nothing, if all counts are 0.
pub(super) fn proportions(counts: &mut [f64], floor: f64) -> bool {
    let total: f64 = counts.iter().sum();
    if total <= 0.0 {
        return false;
    }
    // Which ways are on the floor. A row has at most four ways.
    let mut floored = [false; 4];
    let floored = &mut floored[..counts.len()];
    loop {
        let on_floor = floored.iter().filter(|on| **on).count();
        let free: f64 = counts.iter().zip(floored.iter()).filter(|(_, on)| !**on).map(|(count, _)| count).sum();
        let rest = 1.0 - on_floor as f64 * floor;
        let falls = |count: f64| count * rest < floor * free;
        match counts.iter().zip(floored.iter()).position(|(count, on)| !on && falls(*count)) {
            Some(index) => floored[index] = true,
            None => {
                for (count, on) in counts.iter_mut().zip(floored.iter()) {
                    *count = if *on { floor } else { *count * rest / free };
                }
                return true;
            }
        }
    }
}
