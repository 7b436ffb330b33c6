//! The gripper commands of a hidden state (decision D11).

use core::f64::consts::PI;

use situ::demonstration::Gripper;
use situ::keyframe::hmm::HmmParameters;

use crate::reference::hmm::EMPTY;

/// One kind of command: how often it is given, a Gaussian over its values, and the variance of its prior.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    share: f64,
    mean: f64,
    variance: f64,
    floor: f64,
}

/// `Opening`, `Open` and `Close`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Commands([Kind; 3]);

fn kind(command: Gripper) -> usize {
    match command {
        Gripper::Opening(_) => 0,
        Gripper::Open(_) => 1,
        Gripper::Close(_) => 2,
    }
}

impl Commands {
    /// Before any command is seen: the middle of the hand's range, with the whole range as the deviation.
    pub(crate) fn unseen() -> Self {
        let unseen =
            |mean: f64, floor: f64| Kind { share: 1.0 / 3.0, mean, variance: mean * mean, floor: floor * floor };
        Self([unseen(0.5, 0.1), unseen(0.04, 0.01), unseen(20.0, 5.0)])
    }

    pub(crate) fn log_density(&self, command: Gripper) -> f64 {
        let Kind { share, mean, variance, .. } = self.0[kind(command)];
        share.ln() - 0.5 * ((2.0 * PI * variance).ln() + (command.value() - mean).powi(2) / variance)
    }

    /// Σ (α log share − ½ ν₀ (log v + f²/v)).
    pub(crate) fn log_prior(&self, rule: &HmmParameters) -> f64 {
        let of_values = |kind: &Kind| -0.5 * rule.prior_weight * (kind.variance.ln() + kind.floor / kind.variance);
        self.0.iter().map(|kind| rule.gripper_smoothing * kind.share.ln() + of_values(kind)).sum()
    }

    /// The maximum a posteriori of weighted commands. A kind that was not given keeps its values.
    pub(crate) fn updated(mut self, weighted: &[(f64, Gripper)], rule: &HmmParameters) -> Self {
        let total: f64 = weighted.iter().map(|(weight, _)| weight).sum();
        for (index, own) in self.0.iter_mut().enumerate() {
            let of_kind = weighted.iter().filter(|(_, command)| kind(*command) == index);
            let values: Vec<(f64, f64)> = of_kind.map(|(weight, command)| (*weight, command.value())).collect();
            let weight: f64 = values.iter().map(|(weight, _)| weight).sum();
            own.share = (weight + rule.gripper_smoothing) / (total + 3.0 * rule.gripper_smoothing);
            if weight > EMPTY {
                own.mean = values.iter().map(|(weight, value)| weight * value).sum::<f64>() / weight;
                let squares: f64 = values.iter().map(|(weight, value)| weight * (value - own.mean).powi(2)).sum();
                own.variance = (squares + rule.prior_weight * own.floor) / (weight + rule.prior_weight);
            }
        }
        self
    }

    /// The kind that is given most often, the first of those that tie, with its mean.
    pub(crate) fn most_probable(&self) -> Gripper {
        let best = (1..3).fold(0, |best, kind| if self.0[kind].share > self.0[best].share { kind } else { best });
        [Gripper::Opening, Gripper::Open, Gripper::Close][best](self.0[best].mean)
    }
}
