//! Newton's method in the features' dimension.

use super::problem::{Problem, along, search};
use super::{LogisticError, LogisticFit, LogisticParameters, cholesky, dot};

/// Newton steps from `start` until the gradient is under the tolerance or the steps run out.
pub(super) fn minimise(
    problem: &Problem,
    start: LogisticFit,
    parameters: &LogisticParameters,
) -> Result<LogisticFit, LogisticError> {
    let mut fit = start;
    let mut odds = problem.log_odds(&fit.weights, fit.intercept);
    let mut value = problem.objective(&odds, dot(&fit.weights, &fit.weights));
    let mut matrix = Vec::new();
    loop {
        let gradient = problem.gradient(&fit.weights, &odds);
        fit.converged = gradient.iter().all(|component| component.abs() <= parameters.tolerance);
        if fit.converged || fit.iterations == parameters.max_iterations {
            return Ok(fit);
        }
        let step = step(problem, &mut matrix, &gradient, &odds).ok_or(LogisticError::Singular)?;
        let (weights_step, intercept_step) = (&step[..fit.weights.len()], step[fit.weights.len()]);
        let found = search(value, dot(&gradient, &step), |length| {
            let weights = along(&fit.weights, weights_step, length);
            let odds = problem.log_odds(&weights, fit.intercept + length * intercept_step);
            (problem.objective(&odds, dot(&weights, &weights)), (weights, odds))
        });
        let Some((length, lower, (weights, there))) = found else { return Ok(fit) };
        fit.weights = weights;
        fit.intercept += length * intercept_step;
        fit.iterations += 1;
        (odds, value) = (there, lower);
    }
}

/// Solves H step = −gradient with H = [X 1]ᵀ D [X 1] + λ on all but the intercept, which is last.
fn step(problem: &Problem, matrix: &mut Vec<f64>, gradient: &[f64], odds: &[f64]) -> Option<Vec<f64>> {
    let size = gradient.len();
    let d = size - 1;
    matrix.clear();
    matrix.resize(size * size, 0.0);
    for (row, curvature) in problem.rows.iter().zip(problem.curvatures(odds)) {
        for (at, value) in row.iter().enumerate() {
            let weighted = curvature * value;
            let sums = &mut matrix[at * size..=at * size + at];
            sums.iter_mut().zip(*row).for_each(|(sum, other)| *sum += weighted * other);
            matrix[d * size + at] += weighted;
        }
        matrix[d * size + d] += curvature;
    }
    for at in 0..d {
        matrix[at * size + at] += problem.ridge;
    }
    if !cholesky::factor(matrix, size) {
        return None;
    }
    let mut step: Vec<f64> = gradient.iter().map(|component| -component).collect();
    cholesky::solve(matrix, size, &mut step);
    step.iter().all(|part| part.is_finite()).then_some(step)
}
