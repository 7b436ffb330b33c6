//! Which classifiers a state can activate at all: the scan of A1.6 over one block of memory instead of a node after the other.

use crate::demonstration::State;
use crate::place::NodeId;
use crate::primitive::{Ball, Initiation};

/// The ball of every node's classifier, in the order of their ids. It follows from the nodes, and says nothing that they do not.
#[derive(Clone, Debug, Default)]
pub(super) struct Screen {
    /// The scale of each feature; none where the classifiers have no ball.
    scales: Vec<f64>,
    ids: Vec<NodeId>,
    /// Of each node: the greatest sum of squares at which it can be activated, then the centre.
    rows: Vec<f64>,
}

/// A node that is gone keeps its row, with a sum of squares that no state has.
const GONE: f64 = -1.0;

impl PartialEq for Screen {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Screen {
    fn width(&self) -> usize {
        1 + self.scales.len()
    }

    /// Takes over a node's classifier, of a new node or of one that was here.
    pub(super) fn set(&mut self, id: NodeId, classifier: &impl Initiation) {
        let ball = classifier.ball();
        if let (true, Some(ball)) = (self.ids.is_empty(), &ball) {
            self.scales = ball.scales.to_vec();
        }
        let width = self.width();
        let slot = self.ids.binary_search(&id).unwrap_or_else(|slot| {
            self.ids.insert(slot, id);
            self.rows.splice(slot * width..slot * width, core::iter::repeat_n(0.0, width));
            slot
        });
        let row = &mut self.rows[slot * width..(slot + 1) * width];
        row[0] = f64::INFINITY;
        if let Some(Ball { centre, greatest, .. }) = ball {
            row[0] = greatest;
            row[1..].copy_from_slice(centre);
        }
    }

    /// Takes a node out.
    pub(super) fn remove(&mut self, id: NodeId) {
        if let Ok(slot) = self.ids.binary_search(&id) {
            let row = slot * self.width();
            self.rows[row] = GONE;
        }
    }

    /// The nodes whose ball holds a state, in order.
    pub(super) fn passing<'a>(&'a self, state: &State) -> impl Iterator<Item = NodeId> + use<'a> {
        let scaled: Vec<f64> = state.values().iter().zip(&self.scales).map(|(value, scale)| value / scale).collect();
        let rows = self.ids.iter().zip(self.rows.chunks_exact(self.width()));
        rows.filter(move |(_, row)| within(&row[1..], row[0], scaled.iter().copied())).map(|(id, _)| *id)
    }
}

/// Whether the sum of squared differences is at most `greatest`; given up once it is not.
fn within(centre: &[f64], greatest: f64, scaled: impl Iterator<Item = f64>) -> bool {
    let mut sum = 0.0;
    for (value, centre) in scaled.zip(centre) {
        sum += (value - centre) * (value - centre);
        if sum > greatest {
            return false;
        }
    }
    sum <= greatest
}
