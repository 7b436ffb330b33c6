//! Sums and probabilities in logarithms.

/// log Σ exp of the terms; −∞ if there is none.
pub(super) fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + libm::log(terms.map(|term| libm::exp(term - greatest)).sum::<f64>())
}

/// log σ(z), without overflow.
pub(super) fn log_sigmoid(z: f64) -> f64 {
    z.min(0.0) - libm::log1p(libm::exp(-z.abs()))
}
