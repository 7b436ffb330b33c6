//! The corrected Akaike criterion (Hurvich and Tsai 1989), and the weights of candidates (Akaike 1978; Burnham and
//! Anderson 2002).

/// AICc = 2k − 2 log L + 2k(k + 1)/(n − k − 1), for k free parameters and n scalar observations. The smaller, the
/// better.
///
/// `None` if n ≤ k + 1: there the correction has no value, and the model cannot be chosen. Infinite if the data are
/// impossible.
pub fn corrected_akaike(log_likelihood: f64, parameters: usize, observations: usize) -> Option<f64> {
    let rest = observations.checked_sub(parameters + 1).filter(|rest| *rest > 0)?;
    let k = parameters as f64;
    Some(2.0 * k - 2.0 * log_likelihood + 2.0 * k * (k + 1.0) / rest as f64)
}

/// exp(−½ Δ) of each criterion over their sum, where Δ is the difference to the smallest: how much support each
/// candidate has. It is 0 for a candidate that is refused or impossible. If that is so for every candidate, all are 0.
pub fn akaike_weights(criteria: &[Option<f64>]) -> Vec<f64> {
    let least = criteria.iter().flatten().copied().filter(|value| value.is_finite()).reduce(f64::min);
    let Some(least) = least else { return vec![0.0; criteria.len()] };
    let support = |value: &Option<f64>| value.map_or(0.0, |value| libm::exp(-0.5 * (value - least)));
    let supports: Vec<f64> = criteria.iter().map(support).collect();
    let total: f64 = supports.iter().sum();
    supports.into_iter().map(|support| support / total).collect()
}
