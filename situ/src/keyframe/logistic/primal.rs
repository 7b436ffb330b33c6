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

/// Samples whose products are added in one go over the matrix. They are added in their order, so that their number changes no bit.
const TOGETHER: usize = 4;

/// Adds Σ D [x 1]ᵀ [x 1] of some samples, the lower triangle.
fn add_outer<const N: usize>(matrix: &mut [f64], size: usize, rows: &[&[f64]; N], curvatures: &[f64; N]) {
    let d = size - 1;
    for at in 0..d {
        let mut weighted = *curvatures;
        for (weighted, row) in weighted.iter_mut().zip(rows) {
            *weighted *= row[at];
        }
        let columns = rows.map(|row| &row[..=at]);
        for (column, sum) in matrix[at * size..=at * size + at].iter_mut().enumerate() {
            for (weighted, other) in weighted.iter().zip(&columns) {
                *sum += weighted * other[column];
            }
        }
        for weighted in weighted {
            matrix[d * size + at] += weighted;
        }
    }
    for curvature in curvatures {
        matrix[d * size + d] += curvature;
    }
}

/// Solves H step = −gradient with H = [X 1]ᵀ D [X 1] + λ on all but the intercept, which is last.
fn step(problem: &Problem, matrix: &mut Vec<f64>, gradient: &[f64], odds: &[f64]) -> Option<Vec<f64>> {
    let size = gradient.len();
    let d = size - 1;
    matrix.clear();
    matrix.resize(size * size, 0.0);
    let curvatures = problem.curvatures(odds);
    let (rows, rest) = problem.rows.as_chunks::<TOGETHER>();
    let (shares, rest_shares) = curvatures.as_chunks::<TOGETHER>();
    for (rows, curvatures) in rows.iter().zip(shares) {
        add_outer(matrix, size, rows, curvatures);
    }
    for (row, curvature) in rest.iter().zip(rest_shares) {
        add_outer(matrix, size, &[*row], &[*curvature]);
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
