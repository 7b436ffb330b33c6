//! The transient upper bound of the divergence.

use crate::keyframe::hmm::{EmissionDensity, Hmm};

/// An upper bound on KL(p ‖ q) of whole sequences by the chain rule, divided by the expected length of p: nats per
/// frame.
///
/// If both have as many states, state i of one corresponds to state i of the other: Σ π log(π/π′) + Σ n_i [KL(b_i ‖
/// b′_i) + Σ_j a_ij log(a_ij/a′_ij)], where j also runs over the end and n_i are the expected visits.
///
/// If the numbers of states differ, there is no such bound. Then each state of p is assigned a state of q, in order and
/// never back, so that Σ n_i [KL(b_i ‖ b′) + KL of staying or leaving] is least, by dynamic programming. A state of q
/// without a state of p costs nothing here: the other direction counts it.
///
/// Infinite if q cannot do what p can. It is not symmetric: average it with the other direction.
pub fn transient_bound<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>) -> f64 {
    let visits = p.expected_visits();
    let length: f64 = visits.iter().sum();
    if !length.is_finite() || length <= 0.0 {
        return f64::INFINITY;
    }
    let total = if p.states() == q.states() { same_states(p, q, &visits) } else { aligned(p, q, &visits) };
    total / length
}

fn same_states<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, visits: &[f64]) -> f64 {
    let k = p.states();
    let mut total: f64 = p.initial.iter().zip(&q.initial).map(|(own, other)| relative_entropy(*own, *other)).sum();
    for (state, visit) in visits.iter().enumerate() {
        // A state that is never visited adds nothing, even if its counterpart differs without bound.
        if *visit > 0.0 {
            let row = state * k..(state + 1) * k;
            let ways = p.transition[row.clone()].iter().zip(&q.transition[row]);
            let chain: f64 = ways.map(|(own, other)| relative_entropy(*own, *other)).sum::<f64>()
                + relative_entropy(p.end[state], q.end[state]);
            total += visit * (p.emissions[state].kl(&q.emissions[state]) + chain);
        }
    }
    total
}

fn aligned<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, visits: &[f64]) -> f64 {
    // best[j]: the least cost of the states of p so far, if the last of them is assigned to state j of q.
    let mut best = vec![0.0; q.states()];
    for (state, visit) in visits.iter().enumerate() {
        let mut least = f64::INFINITY;
        for (other, cost) in best.iter_mut().enumerate() {
            least = least.min(*cost);
            let (own, others) = (stay(p, state), stay(q, other));
            let dwell = relative_entropy(own, others) + relative_entropy(1.0 - own, 1.0 - others);
            let step = if *visit > 0.0 { visit * (p.emissions[state].kl(&q.emissions[other]) + dwell) } else { 0.0 };
            *cost = least + step;
        }
    }
    best.into_iter().fold(f64::INFINITY, f64::min)
}

fn stay<E>(hmm: &Hmm<E>, state: usize) -> f64 {
    hmm.transition[state * hmm.states() + state]
}

/// p log(p/q), and 0 if p is 0.
fn relative_entropy(p: f64, q: f64) -> f64 {
    if p > 0.0 { p * libm::log(p / q) } else { 0.0 }
}
