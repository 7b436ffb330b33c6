//! All or nothing: a correction that is refused half-way leaves the model as it was.
//!
//! A copy of the model would cost with its size. The journal costs with what the correction touches.

use std::collections::BTreeMap;

use super::TaskModel;
use super::journal::Journal;
use crate::primitive::Learner;

impl<L: Learner> TaskModel<L> {
    /// Does some work on the model: all of it, or nothing of it where it fails.
    ///
    /// # Errors
    /// Those of `work`. The model is then as it was before.
    pub fn all_or_nothing<T, E>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, E>) -> Result<T, E> {
        let (histories, next) = (self.histories.len(), self.next);
        self.journal = Some(Journal { nodes: BTreeMap::new(), end: None, edges: Vec::new(), histories, next });
        let outcome = work(self);
        if let Some(journal) = self.journal.take().filter(|_| outcome.is_err()) {
            self.restore(journal);
        }
        outcome
    }

    fn restore(&mut self, journal: Journal<L>) {
        for (from, to, is_added) in journal.edges.into_iter().rev() {
            if is_added {
                self.edges.remove(from, to);
            } else {
                self.edges.add(from, to);
            }
        }
        for history in self.histories.drain(journal.histories..) {
            // The correction is the last demonstration that follows its origin.
            if let Some(after) = history.after
                && let Some(followers) = self.followers.get_mut(&after)
            {
                followers.pop();
                if followers.is_empty() {
                    self.followers.remove(&after);
                }
            }
        }
        for (id, node) in journal.nodes {
            self.take_out(id);
            let Some(node) = node else { continue };
            for segment in &node.segments {
                self.histories[segment.demonstration as usize].nodes[segment.index as usize] = id;
            }
            self.put_in(id, node);
        }
        if let Some(end) = journal.end {
            self.end = end;
        }
        self.next = journal.next;
    }
}
