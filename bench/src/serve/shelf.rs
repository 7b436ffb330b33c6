//! The last snapshots of this process, so that they need not be simulated again to be restored.

use std::collections::VecDeque;

use super::served::Served;

/// The most snapshots that are kept.
const MOST: usize = 64;
/// The bytes that they may take.
const ROOM: usize = 256 << 20;

/// Snapshots by their texts, the last one at the end.
#[derive(Default)]
pub(super) struct Shelf {
    kept: VecDeque<(String, Served)>,
}

impl Shelf {
    /// The episode of a text; `None` where it is not kept.
    pub(super) fn find(&self, text: &str) -> Option<&Served> {
        self.kept.iter().find(|(own, _)| own == text).map(|(_, served)| served)
    }

    /// Keeps an episode, and drops the oldest where there is no room for all.
    pub(super) fn keep(&mut self, text: &str, served: &Served) {
        if self.find(text).is_some() {
            return;
        }
        self.kept.push_back((text.to_owned(), served.clone()));
        while self.kept.len() > MOST || self.bytes() > ROOM {
            self.kept.pop_front();
        }
    }

    fn bytes(&self) -> usize {
        self.kept.iter().map(|(text, served)| text.len() + served.bytes()).sum()
    }
}
