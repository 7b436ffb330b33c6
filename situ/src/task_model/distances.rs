//! The distances that are known already, between nodes whose policies did not change since they were compared.

use std::collections::BTreeMap;

use crate::place::NodeId;

/// Distances of pairs, from the lower id to the higher, each kept under both orders. They follow from the nodes, so
/// they are no part of what a model says.
#[derive(Clone, Debug, Default)]
pub(super) struct Distances(BTreeMap<(NodeId, NodeId), f64>);

impl PartialEq for Distances {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Distances {
    /// The distance of a pair; none where it is not known.
    pub(super) fn get(&self, lower: NodeId, higher: NodeId) -> Option<f64> {
        self.0.get(&(lower, higher)).copied()
    }

    pub(super) fn keep(&mut self, lower: NodeId, higher: NodeId, distance: f64) {
        self.0.insert((lower, higher), distance);
        self.0.insert((higher, lower), distance);
    }

    /// Forgets the pairs of a node whose policy is another now, or gone.
    pub(super) fn forget(&mut self, id: NodeId) {
        let pairs = self.0.range((id, NodeId(0))..=(id, NodeId(u32::MAX)));
        let others: Vec<NodeId> = pairs.map(|((_, other), _)| *other).collect();
        for other in others {
            self.0.remove(&(id, other));
            self.0.remove(&(other, id));
        }
    }
}
