//! Newton's method in the samples' dimension.
//!
//! Weights are kept as w = c w₀ + Xᵀ α, w₀ those of the start, c = 1 and α = 0 at first; a full step brings c to 0, for at the
//! minimum w = −Xᵀ r / λ. With G = X Xᵀ and u = X w₀ nothing in a step but the gradient has the features' dimension.

use super::problem::{Problem, along, search};
use super::{LogisticError, LogisticFit, LogisticParameters, cholesky, dot};

/// Where the descent is, in the coordinates above; or a step of it.
struct Point {
    /// α, shape (n).
    alpha: Vec<f64>,
    /// c.
    kept: f64,
    /// b.
    intercept: f64,
}

/// The start as the samples see it.
struct Start<'a> {
    problem: &'a Problem<'a>,
    /// w₀, shape (d).
    weights: Vec<f64>,
    /// G, row-major, shape (n, n).
    gram: Vec<f64>,
    /// u, shape (n).
    seen: Vec<f64>,
}

/// Newton steps from `start` until the gradient is under the tolerance or the steps run out. The same minimum as
/// [`super::primal::minimise`].
pub(super) fn minimise(
    problem: &Problem,
    start: LogisticFit,
    parameters: &LogisticParameters,
) -> Result<LogisticFit, LogisticError> {
    let mut fit = start.clone();
    let mut at = Point { alpha: vec![0.0; problem.rows.len()], kept: 1.0, intercept: start.intercept };
    let start = Start::new(problem, start.weights);
    let mut odds = start.log_odds(&at);
    let mut value = problem.objective(&odds, start.product(&at, &at));
    let mut matrix = Vec::new();
    loop {
        fit.weights = start.weights_of(&at);
        fit.intercept = at.intercept;
        let (excess, residual) = start.excess(&at, &odds);
        let mut gradient: Vec<f64> = start.weights.iter().map(|weight| problem.ridge * at.kept * weight).collect();
        problem.add_transposed(&excess, &mut gradient);
        fit.converged = gradient.iter().chain([&residual]).all(|component| component.abs() <= parameters.tolerance);
        if fit.converged || fit.iterations == parameters.max_iterations {
            return Ok(fit);
        }
        let step = start.step(&mut matrix, &at, &excess, &odds).ok_or(LogisticError::Singular)?;
        let slope = dot(&problem.residuals(&odds), &start.log_odds(&step)) + problem.ridge * start.product(&at, &step);
        let found = search(value, slope, |length| {
            let there = Point {
                alpha: along(&at.alpha, &step.alpha, length),
                kept: at.kept + length * step.kept,
                intercept: at.intercept + length * step.intercept,
            };
            let odds = start.log_odds(&there);
            (problem.objective(&odds, start.product(&there, &there)), (there, odds))
        });
        let Some((_, lower, (there, there_odds))) = found else { return Ok(fit) };
        fit.iterations += 1;
        (at, odds, value) = (there, there_odds, lower);
    }
}

impl<'a> Start<'a> {
    fn new(problem: &'a Problem<'a>, weights: Vec<f64>) -> Self {
        let n = problem.rows.len();
        let mut gram = vec![0.0; n * n];
        for row in 0..n {
            for column in 0..=row {
                let product = dot(problem.rows[row], problem.rows[column]);
                gram[row * n + column] = product;
                gram[column * n + row] = product;
            }
        }
        let seen = problem.log_odds(&weights, 0.0);
        Self { problem, weights, gram, seen }
    }

    /// G v, shape (n).
    fn times_gram(&self, v: &[f64]) -> Vec<f64> {
        self.gram.chunks_exact(v.len()).map(|row| dot(row, v)).collect()
    }

    fn weights_of(&self, at: &Point) -> Vec<f64> {
        let mut weights: Vec<f64> = self.weights.iter().map(|weight| at.kept * weight).collect();
        self.problem.add_transposed(&at.alpha, &mut weights);
        weights
    }

    /// z = G α + c u + b.
    fn log_odds(&self, at: &Point) -> Vec<f64> {
        let mut odds = self.times_gram(&at.alpha);
        odds.iter_mut().zip(&self.seen).for_each(|(z, seen)| *z += at.kept * seen + at.intercept);
        odds
    }

    /// The product of two points' weights.
    fn product(&self, left: &Point, right: &Point) -> f64 {
        left.kept * right.kept * dot(&self.weights, &self.weights)
            + left.kept * dot(&self.seen, &right.alpha)
            + right.kept * dot(&self.seen, &left.alpha)
            + dot(&left.alpha, &self.times_gram(&right.alpha))
    }

    /// h = r + λ α, shape (n), which is 0 at the minimum as c is; and Σ r, the gradient's component of the intercept.
    fn excess(&self, at: &Point, odds: &[f64]) -> (Vec<f64>, f64) {
        let residuals = self.problem.residuals(odds);
        (along(&residuals, &at.alpha, self.problem.ridge), residuals.iter().sum())
    }

    /// The Newton step: δc = −c, and D (G δα − c u + δb) + λ δα = −h with Σ (α + δα) = 0. With R = √D and δα = R β,
    /// (R G R + λ) β = R c u − h/R − R δb.
    fn step(&self, matrix: &mut Vec<f64>, at: &Point, excess: &[f64], odds: &[f64]) -> Option<Point> {
        let n = odds.len();
        let roots: Vec<f64> = self.problem.curvatures(odds).into_iter().map(libm::sqrt).collect();
        matrix.clear();
        matrix.extend_from_slice(&self.gram);
        for row in 0..n {
            for column in 0..=row {
                matrix[row * n + column] *= roots[row] * roots[column];
            }
            matrix[row * n + row] += self.problem.ridge;
        }
        if !cholesky::factor(matrix, n) {
            return None;
        }
        let mut wanted: Vec<f64> = (0..n).map(|i| roots[i] * at.kept * self.seen[i] - excess[i] / roots[i]).collect();
        let mut ones = roots.clone();
        cholesky::solve(matrix, n, &mut wanted);
        cholesky::solve(matrix, n, &mut ones);
        let intercept = (dot(&roots, &wanted) + at.alpha.iter().sum::<f64>()) / dot(&roots, &ones);
        let alpha: Vec<f64> = (0..n).map(|i| roots[i] * (wanted[i] - intercept * ones[i])).collect();
        let finite = intercept.is_finite() && alpha.iter().all(|part| part.is_finite());
        finite.then_some(Point { alpha, kept: -at.kept, intercept })
    }
}
