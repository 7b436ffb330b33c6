//! What a correction has changed so far, as it was before.

use std::collections::BTreeMap;

use super::node::{End, Node};
use crate::place::{NodeId, Place};
use crate::primitive::Learner;

/// The state before a correction of everything that the correction has touched.
#[derive(Clone, Debug)]
pub(super) struct Journal<L: Learner> {
    /// Each node that was changed, added or removed, as it was; `None` where it did not exist.
    pub(super) nodes: BTreeMap<NodeId, Option<Node<L>>>,
    /// END as it was, where it was changed.
    pub(super) end: Option<End<L>>,
    /// The edges that were added (true) or removed (false), in that order.
    pub(super) edges: Vec<(Place, Place, bool)>,
    /// The number of demonstrations.
    pub(super) histories: usize,
    /// The id of the next node.
    pub(super) next: u32,
}

/// A journal is no part of what a model says.
impl<L: Learner> PartialEq for Journal<L> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
