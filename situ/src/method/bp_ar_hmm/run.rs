//! Runs: stretches of one label, which are the segments of this method.

use std::sync::Arc;

use serde::Serialize;

use super::recording::Frame;
use crate::demonstration::Demonstration;

/// A run with fewer frames, less than 0.3 s, is a flicker and belongs to the run before. This is a reconstruction: we
/// do not know what the original does.
const LEAST_FRAMES: usize = 3;

/// The frames at the end of a run that identify it: half a second. The cut itself moves by a frame or two from one
/// segmentation to the next.
const TAIL_FRAMES: usize = 5;

/// A range of frames of one recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Stretch {
    /// The index of the demonstration.
    pub(super) demonstration: u32,
    /// The first frame.
    pub(super) start: usize,
    /// One past the last frame.
    pub(super) end: usize,
}

impl Stretch {
    /// Its last frames. They identify its end after all is segmented anew.
    pub(super) fn tail(&self) -> Self {
        Self { start: self.start.max(self.end.saturating_sub(TAIL_FRAMES)), ..*self }
    }

    /// The number of frames that both have.
    pub(super) fn overlap(&self, other: &Self) -> usize {
        if self.demonstration == other.demonstration {
            self.end.min(other.end).saturating_sub(self.start.max(other.start))
        } else {
            0
        }
    }
}

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Run {
    /// Its frames.
    pub(super) stretch: Stretch,
    /// The behaviour.
    pub(super) label: usize,
    /// The reference object that most of its frames name, the earlier of equals.
    pub(super) reference: Arc<str>,
    /// Its first frame that names that object.
    pub(super) first: usize,
}

/// The runs of a recording, in order. There is at least one frame, so there is at least one run.
pub(super) fn runs(number: u32, shown: &Demonstration, frames: &[Frame], labels: &[usize]) -> Vec<Run> {
    let mut parts: Vec<(usize, usize, usize)> = Vec::new();
    let mut start = 0;
    for same in labels.chunk_by(|left, right| left == right) {
        let end = start + same.len();
        match parts.last_mut() {
            Some(last) if same.len() < LEAST_FRAMES || last.2 == same[0] => last.1 = end,
            _ => parts.push((start, end, same[0])),
        }
        start = end;
    }
    // A flicker at the very beginning has no run before it, so it joins the run after it.
    if parts.len() > 1 && parts[0].1 - parts[0].0 < LEAST_FRAMES {
        parts[1].0 = 0;
        parts.remove(0);
    }
    let name = |frame: usize| &shown.keyframes()[frames[frame].keyframe].reference;
    let run = |(start, end, label): (usize, usize, usize)| {
        let count = |first: usize| (start..end).filter(|frame| name(*frame) == name(first)).count();
        let first = (start..end).reduce(|best, other| if count(other) > count(best) { other } else { best });
        let first = first.unwrap_or(start);
        Run { stretch: Stretch { demonstration: number, start, end }, label, reference: name(first).clone(), first }
    };
    parts.into_iter().map(run).collect()
}
