//! Newton's method for the ridge logistic regression, in either dimension.

use super::{LogisticError, cholesky, dot, sigmoid};

/// A step must gain this share of what its slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// Halvings of a step at most; a Newton step on this objective seldom needs one.
const HALVINGS: usize = 40;

/// n samples of d features.
pub(super) struct Problem<'a> {
    /// Shape (n, d).
    pub(super) rows: &'a [&'a [f64]],
    /// Shape (n).
    pub(super) targets: &'a [f64],
    /// Shape (n), summing to 1.
    pub(super) shares: &'a [f64],
    pub(super) ridge: f64,
}

impl Problem<'_> {
    /// z_i = b + w·x_i.
    pub(super) fn log_odds(&self, weights: &[f64], intercept: f64) -> Vec<f64> {
        self.rows.iter().map(|row| intercept + dot(weights, row)).collect()
    }

    /// Σ s_i (log(1 + e^z_i) − t_i z_i) + ½ λ |w|².
    pub(super) fn objective(&self, weights: &[f64], odds: &[f64]) -> f64 {
        let mut loss = 0.0;
        for ((z, target), share) in odds.iter().zip(self.targets).zip(self.shares) {
            loss += share * (z.max(0.0) + libm::log1p(libm::exp(-z.abs())) - target * z);
        }
        loss + 0.5 * self.ridge * dot(weights, weights)
    }

    /// s_i (p_i − t_i), shape (n).
    fn residuals(&self, odds: &[f64]) -> Vec<f64> {
        let terms = odds.iter().zip(self.targets).zip(self.shares);
        terms.map(|((z, target), share)| share * (sigmoid(*z) - target)).collect()
    }

    /// The weights' components, then the intercept's: shape (d + 1).
    pub(super) fn gradient(&self, weights: &[f64], odds: &[f64]) -> Vec<f64> {
        let mut gradient: Vec<f64> = weights.iter().map(|weight| self.ridge * weight).collect();
        let mut intercept = 0.0;
        for (row, residual) in self.rows.iter().zip(self.residuals(odds)) {
            gradient.iter_mut().zip(*row).for_each(|(sum, value)| *sum += residual * value);
            intercept += residual;
        }
        gradient.push(intercept);
        gradient
    }

    /// Newton steps from the given start; returns their number and whether the gradient came under the tolerance.
    pub(super) fn minimise(
        &self,
        weights: &mut Vec<f64>,
        intercept: &mut f64,
        dual: bool,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<(usize, bool), LogisticError> {
        let gram = if dual { self.gram() } else { Vec::new() };
        let mut matrix = Vec::new();
        let mut odds = self.log_odds(weights, *intercept);
        let mut value = self.objective(weights, &odds);
        for iteration in 0..max_iterations {
            let gradient = self.gradient(weights, &odds);
            if gradient.iter().all(|component| component.abs() <= tolerance) {
                return Ok((iteration, true));
            }
            // Curvatures s p (1 − p); never quite 0, so that the intercept's is not.
            let curvatures: Vec<f64> = odds
                .iter()
                .zip(self.shares)
                .map(|(z, share)| share * (sigmoid(*z) * sigmoid(-z)).max(f64::MIN_POSITIVE))
                .collect();
            let step = if dual {
                self.dual_step(&gram, &mut matrix, weights, *intercept, &odds, &curvatures)
            } else {
                self.primal_step(&mut matrix, &gradient, &curvatures)
            };
            let step = step.filter(|step| step.iter().all(|part| part.is_finite())).ok_or(LogisticError::Singular)?;
            let slope = dot(&gradient, &step);
            let mut length = 1.0;
            let mut moved = false;
            for _ in 0..HALVINGS {
                let trial: Vec<f64> = weights.iter().zip(&step).map(|(weight, part)| weight + length * part).collect();
                let trial_intercept = *intercept + length * step[weights.len()];
                let trial_odds = self.log_odds(&trial, trial_intercept);
                let trial_value = self.objective(&trial, &trial_odds);
                // The second term is the rounding error of the objective: at the minimum no step gains more than that.
                if trial_value <= value + SUFFICIENT * length * slope + 4.0 * f64::EPSILON * value.abs() {
                    (*weights, *intercept, odds, value) = (trial, trial_intercept, trial_odds, trial_value);
                    moved = true;
                    break;
                }
                length *= 0.5;
            }
            if !moved {
                return Ok((iteration, false));
            }
        }
        let converged = self.gradient(weights, &odds).iter().all(|component| component.abs() <= tolerance);
        Ok((max_iterations, converged))
    }

    /// Solves H step = −gradient, H = X̃ᵀ D X̃ + λ J of size d + 1, the intercept last.
    fn primal_step(&self, matrix: &mut Vec<f64>, gradient: &[f64], curvatures: &[f64]) -> Option<Vec<f64>> {
        let size = gradient.len();
        let d = size - 1;
        matrix.clear();
        matrix.resize(size * size, 0.0);
        for (row, curvature) in self.rows.iter().zip(curvatures) {
            for (at, value) in row.iter().enumerate() {
                let weighted = curvature * value;
                let sums = &mut matrix[at * size..at * size + at + 1];
                sums.iter_mut().zip(*row).for_each(|(sum, other)| *sum += weighted * other);
                matrix[d * size + at] += weighted;
            }
            matrix[d * size + d] += curvature;
        }
        for at in 0..d {
            matrix[at * size + at] += self.ridge;
        }
        let mut step: Vec<f64> = gradient.iter().map(|component| -component).collect();
        cholesky::factor(matrix, size).then(|| {
            cholesky::solve(matrix, size, &mut step);
            step
        })
    }

    /// X Xᵀ, lower triangle, shape (n, n).
    fn gram(&self) -> Vec<f64> {
        let n = self.rows.len();
        let mut gram = vec![0.0; n * n];
        for row in 0..n {
            for column in 0..=row {
                gram[row * n + column] = dot(self.rows[row], self.rows[column]);
            }
        }
        gram
    }

    /// The same step from the dual: the weighted least squares of the working response y = z + (t − p)/(p(1 − p)) has
    /// w = Xᵀ R β with (R X Xᵀ R + λ) β = R (y − b), R = √D, and b from Σ R β = 0.
    fn dual_step(
        &self,
        gram: &[f64],
        matrix: &mut Vec<f64>,
        weights: &[f64],
        intercept: f64,
        odds: &[f64],
        curvatures: &[f64],
    ) -> Option<Vec<f64>> {
        let n = self.rows.len();
        let roots: Vec<f64> = curvatures.iter().map(|curvature| libm::sqrt(*curvature)).collect();
        matrix.clear();
        matrix.extend_from_slice(gram);
        for row in 0..n {
            for column in 0..=row {
                matrix[row * n + column] *= roots[row] * roots[column];
            }
            matrix[row * n + row] += self.ridge;
        }
        if !cholesky::factor(matrix, n) {
            return None;
        }
        // The response is taken relative to the present intercept: the b that comes out is then the intercept's step.
        let residuals = self.residuals(odds);
        let mut response: Vec<f64> =
            (0..n).map(|at| roots[at] * (odds[at] - intercept) - residuals[at] / roots[at]).collect();
        let mut ones = roots.clone();
        cholesky::solve(matrix, n, &mut response);
        cholesky::solve(matrix, n, &mut ones);
        let shift = dot(&roots, &response) / dot(&roots, &ones);
        let mut step: Vec<f64> = weights.iter().map(|weight| -weight).collect();
        for at in 0..n {
            let alpha = roots[at] * (response[at] - shift * ones[at]);
            step.iter_mut().zip(self.rows[at]).for_each(|(sum, value)| *sum += alpha * value);
        }
        step.push(shift);
        Some(step)
    }
}
