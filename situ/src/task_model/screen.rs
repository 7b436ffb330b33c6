//! Which classifiers a state can activate at all: the scan of A1.6, eight nodes at once.

use crate::place::NodeId;
use crate::primitive::Ball;
use crate::state::State;
use crate::vector::{EIGHT, loops};

/// The ball of every node's classifier, in the order of their ids. It follows from the nodes, so it is no part of what
/// a model says.
///
/// ```
/// use situ::state::State;
/// use situ::place::NodeId;
/// use situ::primitive::Ball;
/// use situ::task_model::screen::Screen;
///
/// let mut screen = Screen::default();
/// screen.set(NodeId(0), Some(Ball { scales: &[0.1], centre: &[0.0], greatest: 4.0 }));
/// screen.set(NodeId(1), Some(Ball { scales: &[0.1], centre: &[5.0], greatest: 4.0 }));
/// assert_eq!(screen.passing(&State::new([0.4])), [NodeId(1)]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Screen {
    /// The scale of each feature; none where the classifiers have no ball.
    scales: Vec<f64>,
    ids: Vec<NodeId>,
    /// Nodes are side by side, so that the widest vectors hold a feature of many. Of each [`EIGHT`] of them: the
    /// greatest sums of squares at which they can be activated, then each feature of their centres.
    blocks: Vec<[f64; EIGHT]>,
}

/// The sum of squares of a node that is gone, and of a place that is not taken yet: no state has it.
const GONE: f64 = -1.0;
/// Features between two looks at whether a block can be given up.
const FEATURES: usize = 8;

impl PartialEq for Screen {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Screen {
    fn width(&self) -> usize {
        1 + self.scales.len()
    }

    /// Takes over the ball of a node's classifier; the node can be new or known. A node without a ball always passes.
    ///
    /// # Panics
    /// Where a new node's id is not the greatest so far, or the features are not as many as the first ball's.
    pub fn set(&mut self, id: NodeId, ball: Option<Ball>) {
        if let (true, Some(ball)) = (self.ids.is_empty(), &ball) {
            self.scales = ball.scales.to_vec();
        }
        let width = self.width();
        let slot = self.ids.binary_search(&id).unwrap_or_else(|slot| {
            assert_eq!(slot, self.ids.len(), "a new node's id is the greatest");
            self.ids.push(id);
            slot
        });
        let (first, lane) = (slot / EIGHT * width, slot % EIGHT);
        if first == self.blocks.len() {
            self.blocks.push([GONE; EIGHT]);
            self.blocks.resize(first + width, [0.0; EIGHT]);
        }
        let block = &mut self.blocks[first..first + width];
        block[0][lane] = f64::INFINITY;
        if let Some(Ball { centre, greatest, .. }) = ball {
            assert_eq!(centre.len(), self.scales.len(), "all balls have the same features");
            block[0][lane] = greatest;
            block[1..].iter_mut().zip(centre).for_each(|(features, value)| features[lane] = *value);
        }
    }

    /// Takes a node out.
    pub fn remove(&mut self, id: NodeId) {
        if let Ok(slot) = self.ids.binary_search(&id) {
            let first = slot / EIGHT * self.width();
            self.blocks[first][slot % EIGHT] = GONE;
        }
    }

    /// The nodes whose ball holds a state, in order.
    pub fn passing(&self, state: &State) -> Vec<NodeId> {
        let scaled: Vec<f64> = state.values().iter().zip(&self.scales).map(|(value, scale)| value / scale).collect();
        let mut passing = Vec::new();
        loops!(scan, (self, scaled.as_slice(), &mut passing));
        passing
    }
}

/// Adds the nodes whose sum of squared differences to `scaled` is at most their greatest.
#[inline(always)]
fn scan((screen, scaled, passing): (&Screen, &[f64], &mut Vec<NodeId>)) {
    for (block, ids) in screen.blocks.chunks_exact(screen.width()).zip(screen.ids.chunks(EIGHT)) {
        let Some((greatest, centres)) = block.split_first() else { return };
        let mut sums = [0.0; EIGHT];
        let mut within = 1;
        for (values, centres) in scaled.chunks(FEATURES).zip(centres.chunks(FEATURES)) {
            for (value, centres) in values.iter().zip(centres) {
                sums = with_squares(sums, *value, *centres);
            }
            within = held(&sums, greatest);
            if within == 0 {
                break;
            }
        }
        if within != 0 {
            let within = held(&sums, greatest);
            passing.extend(ids.iter().enumerate().filter(|(lane, _)| within >> lane & 1 == 1).map(|(_, id)| *id));
        }
    }
}

/// Sums and the squares of the differences of their centres to a value.
#[inline(always)]
fn with_squares(mut sums: [f64; EIGHT], value: f64, centres: [f64; EIGHT]) -> [f64; EIGHT] {
    for lane in 0..EIGHT {
        let difference = value - centres[lane];
        sums[lane] += difference * difference;
    }
    sums
}

/// A bit for each sum that is at most its greatest.
#[inline(always)]
fn held(sums: &[f64; EIGHT], greatest: &[f64; EIGHT]) -> u32 {
    let mut bits = 0;
    for lane in 0..EIGHT {
        bits |= u32::from(sums[lane] <= greatest[lane]) << lane;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A step of a model's life.
    #[derive(Clone, Debug)]
    enum Step {
        Add { centre: Vec<i8>, greatest: Option<u16> },
        Change { which: usize, centre: Vec<i8>, greatest: Option<u16> },
        Remove { which: usize },
    }

    const MOST: usize = 20;

    fn step() -> impl Strategy<Value = Step> {
        let ball = || (prop::collection::vec(-2_i8..=2, MOST), prop::option::weighted(0.9, 0_u16..60));
        prop_oneof![
            6 => ball().prop_map(|(centre, greatest)| Step::Add { centre, greatest }),
            1 => (any::<usize>(), ball()).prop_map(|(which, (centre, greatest))| Step::Change { which, centre, greatest }),
            1 => any::<usize>().prop_map(|which| Step::Remove { which }),
        ]
    }

    proptest! {
        /// Against each node by itself. The numbers are whole, so that sums are exact and many are just the greatest.
        #[test]
        fn the_scan_finds_what_each_node_by_itself_does(
            dimension in 1..=MOST,
            steps in prop::collection::vec(step(), 1..80),
            state in prop::collection::vec(-2_i8..=2, MOST),
        ) {
            let numbers = |whole: &[i8]| whole[..dimension].iter().map(|number| f64::from(*number)).collect::<Vec<f64>>();
            // The first has a ball: it is the one that brings the scales.
            let first = Step::Add { centre: vec![0; MOST], greatest: Some(3) };
            let scales = vec![0.5; dimension];
            let mut screen = Screen::default();
            let mut nodes: Vec<Option<(Vec<f64>, Option<u16>)>> = Vec::new();
            for step in [first].into_iter().chain(steps) {
                let (index, node) = match step {
                    Step::Add { centre, greatest } => (nodes.len(), Some((numbers(&centre), greatest))),
                    Step::Change { which, centre, greatest } => (which % nodes.len(), Some((numbers(&centre), greatest))),
                    Step::Remove { which } => (which % nodes.len(), None),
                };
                let id = NodeId(3 * index as u32);
                match &node {
                    None => screen.remove(id),
                    Some((centre, greatest)) => {
                        let ball = |greatest| Ball { scales: &scales, centre, greatest: f64::from(greatest) };
                        screen.set(id, greatest.map(ball));
                    }
                }
                nodes.truncate(nodes.len().max(index));
                if index == nodes.len() { nodes.push(node) } else { nodes[index] = node }
            }
            let state = numbers(&state);
            let holds = |(centre, greatest): &(Vec<f64>, Option<u16>)| {
                let squares = centre.iter().zip(&state).map(|(centre, value)| (centre - value) * (centre - value));
                greatest.is_none_or(|greatest| squares.sum::<f64>() <= f64::from(greatest))
            };
            let expected: Vec<NodeId> = nodes.iter().enumerate()
                .filter(|(_, node)| node.as_ref().is_some_and(holds))
                .map(|(index, _)| NodeId(3 * index as u32))
                .collect();
            // In units of the scales.
            let state = State::new(state.iter().map(|value| 0.5 * value).collect::<Vec<f64>>());
            prop_assert_eq!(screen.passing(&state), expected);
        }
    }

    /// Rounding, too, is that of a sum in the features' order.
    #[test]
    fn sums_are_those_of_one_node_to_the_bit() {
        let centres: Vec<Vec<f64>> =
            (0..50).map(|node| (0..13).map(|at| libm::sin(f64::from(node * 13 + at))).collect()).collect();
        let state: Vec<f64> = (0..13).map(|at| libm::cos(f64::from(at))).collect();
        let sum = |centre: &[f64]| {
            centre.iter().zip(&state).fold(0.0, |sum, (centre, value)| sum + (value - centre) * (value - centre))
        };
        let mut screen = Screen::default();
        for (node, centre) in centres.iter().enumerate() {
            let greatest = if node % 2 == 0 { sum(centre) } else { sum(centre).next_down() };
            screen.set(NodeId(node as u32), Some(Ball { scales: &[1.0; 13], centre, greatest }));
        }
        let even: Vec<NodeId> = (0..50).step_by(2).map(NodeId).collect();
        assert_eq!(screen.passing(&State::new(state)), even);
    }
}
