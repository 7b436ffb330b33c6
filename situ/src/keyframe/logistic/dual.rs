//! Newton's method in the dimension of the samples.
//!
//! The weights are w = Xᵀ α, and α = 0 at first. At the minimum w = −Xᵀ r / λ. With G = X Xᵀ, a step is found without
//! the dimension of the features. The objective after the step is still computed from the weights: with features of
//! about a thousand, G α is a small sum of large terms, and if its rounding exceeds what is left to gain, no step would
//! be good enough.

use super::blocks::{Blocks, PANEL, add_transposed, scaled, times, times_each};
use super::factor::Factor;
use super::parameters::{LogisticError, LogisticParameters};
use super::problem::{LogisticFit, Problem, Slopes, along, product, search, steepest};
use crate::vector::{EIGHT, Four, Kernel, Wide, loops, sum, widest};

/// Where the descent is. Vectors are padded.
struct Point {
    /// α, shape (n).
    alpha: Vec<f64>,
    /// b.
    intercept: f64,
    /// w, shape (d).
    weights: Vec<f64>,
    /// z, shape (n).
    odds: Vec<f64>,
    slopes: Slopes,
    value: f64,
}

/// One Newton step.
struct Step {
    /// δα, shape (n), padded.
    alpha: Vec<f64>,
    /// δb.
    intercept: f64,
    /// G δα, shape (n), padded.
    seen: Vec<f64>,
    /// The slope of the objective along the step.
    slope: f64,
}

/// The problem, in the dimension of the samples.
struct Dual<'a> {
    problem: &'a Problem<'a>,
    /// Xᵀ, shape (d, n).
    samples: Blocks,
    /// G, shape (n, n).
    gram: Blocks,
}

/// What the solution of a step needs.
struct Workspace {
    factor: Factor,
    /// √D, shape (n), padded as the others are.
    roots: Vec<f64>,
    /// The solution for R as the right-hand side.
    ones: Vec<f64>,
    wanted: Vec<f64>,
    /// The gradient in w, shape (d), padded, and then in b.
    gradient: Vec<f64>,
}

/// Newton steps from `start`, until the gradient is below the tolerance or the steps run out. The minimum is that of
/// [`super::primal::minimise`].
pub(super) fn minimise(
    problem: &Problem,
    mut fit: LogisticFit,
    parameters: &LogisticParameters,
) -> Result<LogisticFit, LogisticError> {
    let dual = Dual::new(problem);
    let (n, columns) = (problem.rows.len(), dual.samples.rows());
    let (mut at, mut there) = (Point::new(n, columns), Point::new(n, columns));
    dual.evaluate(&mut at);
    let (mut step, mut workspace) = (Step::new(n), Workspace::new(n, columns));
    loop {
        dual.gradient(&at, &mut workspace.gradient);
        fit.converged = steepest(&workspace.gradient) <= parameters.tolerance;
        if fit.converged || fit.iterations == parameters.max_iterations {
            break;
        }
        if !dual.factor(&at, &mut workspace) || !dual.step(&at, &mut workspace, &mut step) {
            return Err(LogisticError::Singular);
        }
        let found = search(at.value, step.slope, |length| {
            there.set_along(&at, &step, length);
            dual.evaluate(&mut there);
            there.value
        });
        if !found {
            break;
        }
        core::mem::swap(&mut at, &mut there);
        fit.iterations += 1;
    }
    fit.weights.copy_from_slice(&at.weights[..problem.dimension]);
    fit.intercept = at.intercept;
    Ok(fit)
}

impl Point {
    fn new(n: usize, columns: usize) -> Self {
        let (zeros, weights) = (vec![0.0; n.next_multiple_of(EIGHT)], vec![0.0; columns]);
        Self { alpha: zeros.clone(), intercept: 0.0, weights, odds: zeros, slopes: Slopes::new(n), value: 0.0 }
    }

    fn set_along(&mut self, base: &Self, step: &Step, length: f64) {
        along(&base.alpha, &step.alpha, length, &mut self.alpha);
        self.intercept = base.intercept + length * step.intercept;
    }
}

impl Step {
    fn new(n: usize) -> Self {
        let zeros = vec![0.0; n.next_multiple_of(EIGHT)];
        Self { alpha: zeros.clone(), intercept: 0.0, seen: zeros, slope: 0.0 }
    }
}

impl Workspace {
    fn new(n: usize, columns: usize) -> Self {
        let zeros = vec![0.0; n.next_multiple_of(EIGHT)];
        Self {
            factor: Factor::new(n),
            roots: zeros.clone(),
            ones: zeros.clone(),
            wanted: zeros,
            gradient: vec![0.0; columns + 1],
        }
    }
}

impl<'a> Dual<'a> {
    fn new(problem: &'a Problem<'a>) -> Self {
        let samples = Blocks::transposed(problem.rows, problem.dimension);
        let mut gram = samples.square();
        gram.mirror();
        Self { problem, samples, gram }
    }

    /// Computes the weights, and the objective and its slopes there.
    fn evaluate(&self, at: &mut Point) {
        widest(Evaluate { dual: self, at });
    }

    /// The gradient in w, then in b.
    fn gradient(&self, at: &Point, gradient: &mut [f64]) {
        let (intercept, gradient) = gradient.split_last_mut().expect("the last is the intercept's");
        self.samples.times(&at.slopes.residuals, gradient);
        gradient.iter_mut().zip(&at.weights).for_each(|(component, weight)| *component += self.problem.ridge * weight);
        *intercept = sum(&at.slopes.residuals);
    }

    /// Sets R = √D, factors R G R + λ, and solves it for R as the right-hand side. False if the matrix is not positive
    /// definite.
    fn factor(&self, at: &Point, workspace: &mut Workspace) -> bool {
        #[inline(always)]
        fn prepare((dual, roots, matrix): (&Dual, &[f64], &mut Blocks)) {
            for (right, columns) in roots.as_chunks::<EIGHT>().0.iter().enumerate() {
                let scaled_rows = matrix.block_mut(right)[..(right + 1) * EIGHT].iter_mut();
                for ((numbers, own), row) in scaled_rows.zip(dual.gram.block(right)).zip(roots) {
                    *numbers = times_each(*own, scaled(*columns, *row));
                }
            }
        }
        let Workspace { factor, roots, ones, .. } = workspace;
        roots.iter_mut().zip(&at.slopes.curvatures).for_each(|(root, curvature)| *root = libm::sqrt(*curvature));
        loops!(prepare, (self, roots.as_slice(), factor.matrix()));
        let n = self.problem.rows.len();
        factor.add_to_diagonal(n, n, self.problem.ridge);
        let factored = factor.factor();
        ones.copy_from_slice(roots);
        factor.solve(ones);
        factored
    }

    /// The Newton step: D (G δα + δb) + λ δα = −h with h = r + λ α and Σ (α + δα) = 0. With R = √D and δα = R β,
    /// (R G R + λ) β = −h/R − R δb. False if it cannot be solved.
    fn step(&self, at: &Point, workspace: &mut Workspace, step: &mut Step) -> bool {
        let Workspace { factor, roots, ones, wanted, .. } = workspace;
        let (residuals, ridge, n) = (&at.slopes.residuals, self.problem.ridge, self.problem.rows.len());
        for index in 0..n {
            let excess = residuals[index] + ridge * at.alpha[index];
            wanted[index] = -excess / roots[index];
        }
        factor.solve(wanted);
        step.intercept = (product(roots, wanted) + sum(&at.alpha)) / product(roots, ones);
        for index in 0..n {
            step.alpha[index] = roots[index] * (wanted[index] - step.intercept * ones[index]);
        }
        self.gram.transpose_times(&step.alpha, &mut step.seen);
        let loss = product(residuals, &step.seen) + step.intercept * sum(residuals);
        step.slope = loss + ridge * product(&at.alpha, &step.seen);
        step.intercept.is_finite() && step.alpha.iter().all(|part| part.is_finite())
    }
}

struct Evaluate<'a> {
    dual: &'a Dual<'a>,
    at: &'a mut Point,
}

impl Kernel for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let Self { dual, at: Point { alpha, intercept, weights, odds, slopes, value } } = self;
        times((&dual.samples, alpha, weights));
        odds.fill(*intercept);
        add_transposed(&dual.samples, weights, odds);
        let mut losses = Four::splat(simd, 0.0);
        for (panel, odds) in odds.chunks(PANEL).enumerate() {
            slopes.set(simd, dual.problem, panel * PANEL, odds, &mut losses);
        }
        *value = losses.joined() + 0.5 * dual.problem.ridge * product(weights, weights);
    }
}
