//! How well the probabilities of children are calibrated: at every branch of a rollout, the likeliest child against
//! what the task's own program would do next.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use situ::graph::Graph;
use situ::place::{NodeId, Place};

/// A choice of the executor.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The place that ran last.
    pub last: Place,
    /// Its likeliest child.
    pub child: Place,
    /// The probability that the model gives it, 0 to 1.
    pub probability: f64,
    /// What the task's program would do.
    pub due: Due,
}

/// What the task's program would do next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Due {
    /// This skill.
    Skill(String),
    /// Nothing: the goal holds.
    End,
    /// Nothing that the program knows: the goal does not hold either.
    Unknown,
}

/// The number of bins, equally wide from 0 to 1.
const BINS: usize = 10;

/// The choices whose probability is in one bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfidenceBin {
    /// Choices.
    pub choices: u32,
    /// Those that were right.
    pub right: u32,
    /// The sum of their probabilities.
    pub probability: f64,
}

/// The calibration over some rollouts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchCalibration {
    /// The sum of the squared differences of probability and outcome, 1 for right and 0 for wrong.
    pub squares: f64,
    /// The bins, from low to high probability.
    pub bins: Vec<ConfidenceBin>,
}

impl BranchCalibration {
    /// The calibration of these choices in a model with this graph and these skills of its nodes. Only places with two
    /// children or more have a choice. A choice is right where the child holds the skill that is due. `None` where
    /// there was no choice.
    pub fn of(choices: &[Choice], graph: &Graph, skills: &BTreeMap<NodeId, Arc<str>>) -> Option<Self> {
        let mut calibration = Self { squares: 0.0, bins: vec![ConfidenceBin::default(); BINS] };
        let mut is_empty = true;
        for Choice { last, child, probability, due } in choices {
            let is_branch = graph.edges.iter().filter(|(from, _)| from == last).nth(1).is_some();
            let is_right = match (child, due) {
                (_, Due::Unknown) => continue,
                (Place::Node(node), Due::Skill(skill)) => skills.get(node).is_some_and(|held| **held == **skill),
                (child, due) => *child == Place::End && *due == Due::End,
            };
            if !is_branch {
                continue;
            }
            is_empty = false;
            calibration.squares += (probability - f64::from(u8::from(is_right))).powi(2);
            let bin = &mut calibration.bins[((probability * BINS as f64) as usize).min(BINS - 1)];
            bin.choices += 1;
            bin.right += u32::from(is_right);
            bin.probability += probability;
        }
        (!is_empty).then_some(calibration)
    }

    /// Choices.
    pub fn choices(&self) -> u32 {
        self.bins.iter().map(|bin| bin.choices).sum()
    }

    /// Choices that were right.
    pub fn right(&self) -> u32 {
        self.bins.iter().map(|bin| bin.right).sum()
    }
}

/// The Brier score of pooled choices, 0 to 1 (Brier 1950); `None` where there is none.
pub fn brier<'a>(of: impl Iterator<Item = &'a BranchCalibration>) -> Option<f64> {
    let (squares, choices) =
        of.fold((0.0, 0), |(squares, choices), one| (squares + one.squares, choices + one.choices()));
    (choices > 0).then(|| squares / f64::from(choices))
}

/// The expected calibration error of pooled choices, 0 to 1 (Naeini, Cooper and Hauskrecht 2015): the mean over choices
/// of the difference, in their bin, of the mean probability and the share that was right. `None` where there is none.
pub fn calibration_error<'a>(of: impl Iterator<Item = &'a BranchCalibration>) -> Option<f64> {
    let mut bins = [(0, 0.0); BINS];
    for calibration in of {
        for (sum, bin) in bins.iter_mut().zip(&calibration.bins) {
            *sum = (sum.0 + bin.choices, sum.1 + bin.probability - f64::from(bin.right));
        }
    }
    let choices: u32 = bins.iter().map(|bin| bin.0).sum();
    (choices > 0).then(|| bins.iter().map(|bin| bin.1.abs()).sum::<f64>() / f64::from(choices))
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Place = Place::Start;

    fn node(number: u32) -> Place {
        Place::Node(NodeId(number))
    }

    fn choice(last: Place, child: Place, probability: f64, due: Due) -> Choice {
        Choice { last, child, probability, due }
    }

    fn skill(name: &str) -> Due {
        Due::Skill(name.to_owned())
    }

    /// Two children of START, one of node 0. By hand: of the four choices at START the first and the last are right.
    #[test]
    fn by_hand() {
        let graph =
            Graph { edges: vec![(START, node(0)), (START, node(1)), (node(0), Place::End)], ..Graph::default() };
        let skills = BTreeMap::from([(NodeId(0), "lift".into()), (NodeId(1), "pour".into())]);
        let choices = [
            choice(START, node(0), 0.95, skill("lift")),
            choice(START, node(1), 0.91, skill("lift")),
            choice(START, node(1), 0.62, Due::End),
            choice(START, node(1), 1.0, skill("pour")),
            // No branch, and nothing that is due.
            choice(node(0), Place::End, 0.2, Due::End),
            choice(START, node(1), 0.5, Due::Unknown),
        ];
        let found = BranchCalibration::of(&choices, &graph, &skills).unwrap();
        assert_eq!((found.choices(), found.right()), (4, 2));
        let squares = 0.05_f64.powi(2) + 0.91_f64.powi(2) + 0.62_f64.powi(2);
        assert!((found.squares - squares).abs() < 1e-12);
        assert!((brier([&found].into_iter()).unwrap() - squares / 4.0).abs() < 1e-12);
        // The bin of .6 has one choice, which is wrong; that of .9 has three, two of them right.
        let error = (0.62 + (0.95 + 0.91 + 1.0 - 2.0)) / 4.0;
        assert!((calibration_error([&found].into_iter()).unwrap() - error).abs() < 1e-12);
        let twice = [&found, &found];
        assert_eq!(brier(twice.into_iter()), brier([&found].into_iter()));
        assert!((calibration_error(twice.into_iter()).unwrap() - error).abs() < 1e-12);
        assert_eq!(BranchCalibration::of(&choices[4..], &graph, &skills), None);
        assert_eq!((brier([].into_iter()), calibration_error([].into_iter())), (None, None));
    }
}
