//! Newton's method in the dimension of the features.

use super::blocks::{Blocks, PANEL, add_transposed, times};
use super::factor::Factor;
use super::parameters::{LogisticError, LogisticParameters};
use super::problem::{LogisticFit, Problem, Slopes, along, product, search, steepest};
use crate::vector::{EIGHT, Four, Kernel, Wide, dot, widest};

/// If a step left at most this share of the gradient, the curvatures hardly changed, and the next step uses the old
/// ones. Such a step leaves about twice the share and costs a fraction. In the dimension of the samples it is not worth
/// it: there a matrix costs little more than a step.
const ENOUGH: f64 = 0.1;

/// Where the descent is.
pub(super) struct Point {
    /// w, then b, padded.
    weights: Vec<f64>,
    slopes: Slopes,
    /// The gradient in w, then in b, padded.
    gradient: Vec<f64>,
    value: f64,
}

impl Point {
    fn new(problem: &Problem) -> Self {
        let zeros = vec![0.0; (problem.dimension + 1).next_multiple_of(EIGHT)];
        Self { weights: zeros.clone(), slopes: Slopes::new(problem.rows.len()), gradient: zeros, value: 0.0 }
    }

    /// The objective and its gradient at these weights and this intercept.
    pub(super) fn at(problem: &Problem, samples: &[Blocks], weights: &[f64], intercept: f64) -> Self {
        let mut point = Self::new(problem);
        point.weights[..problem.dimension].copy_from_slice(weights);
        point.weights[problem.dimension] = intercept;
        point.evaluate(problem, samples);
        point
    }

    fn evaluate(&mut self, problem: &Problem, samples: &[Blocks]) {
        widest(Evaluate { point: self, problem, samples });
    }

    /// The objective, and its gradient: the components of the weights, then that of the intercept.
    pub(super) fn value_and_gradient(mut self, problem: &Problem) -> (f64, Vec<f64>) {
        self.gradient.truncate(problem.dimension + 1);
        (self.value, self.gradient)
    }
}

/// Newton steps from `start`, until the gradient is below the tolerance or the steps run out.
pub(super) fn minimise(
    problem: &Problem,
    mut fit: LogisticFit,
    parameters: &LogisticParameters,
) -> Result<LogisticFit, LogisticError> {
    let d = problem.dimension;
    let samples = Blocks::panels(problem.rows, d);
    let mut at = Point::at(problem, &samples, &fit.weights, fit.intercept);
    let mut there = Point::new(problem);
    let mut factor = Factor::new(d + 1);
    let mut workspace = vec![[0.0; EIGHT]; PANEL * (d + 1).next_multiple_of(EIGHT) / EIGHT];
    let mut step = vec![0.0; (d + 1).next_multiple_of(EIGHT)];
    let (mut left, mut again) = (steepest(&at.gradient), false);
    loop {
        fit.converged = left <= parameters.tolerance;
        if fit.converged || fit.iterations == parameters.max_iterations {
            break;
        }
        // H step = −gradient with H = [X 1]ᵀ D [X 1] + λ; λ is not added for the intercept, which is last.
        if !again {
            Blocks::weighted_square(&samples, &at.slopes.curvatures, d + 1, &mut workspace, factor.matrix());
            factor.add_to_diagonal(d, d + 1, problem.ridge);
            if !factor.factor() {
                return Err(LogisticError::Singular);
            }
        }
        step.iter_mut().zip(&at.gradient).for_each(|(step, component)| *step = -component);
        factor.solve(&mut step);
        if !step.iter().all(|part| part.is_finite()) {
            return Err(LogisticError::Singular);
        }
        let found = search(at.value, product(&at.gradient, &step), |length| {
            along(&at.weights, &step, length, &mut there.weights);
            there.evaluate(problem, &samples);
            there.value
        });
        if found {
            core::mem::swap(&mut at, &mut there);
            fit.iterations += 1;
            let before = core::mem::replace(&mut left, steepest(&at.gradient));
            again = left <= ENOUGH * before;
        } else if again {
            again = false;
        } else {
            break;
        }
    }
    fit.weights.copy_from_slice(&at.weights[..d]);
    fit.intercept = at.weights[d];
    Ok(fit)
}

struct Evaluate<'a> {
    point: &'a mut Point,
    problem: &'a Problem<'a>,
    samples: &'a [Blocks],
}

impl Kernel for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let Self { point: Point { weights, slopes, gradient, value }, problem, samples } = self;
        let mut losses = Four::splat(simd, 0.0);
        gradient.fill(0.0);
        for (index, panel) in samples.iter().enumerate() {
            let mut odds = [0.0; PANEL];
            let (first, odds) = (index * PANEL, &mut odds[..panel.rows()]);
            times((panel, weights, odds));
            slopes.set(simd, problem, first, odds, &mut losses);
            add_transposed(panel, &slopes.residuals[first..first + odds.len()], gradient);
        }
        let weights = &weights[..problem.dimension];
        gradient.iter_mut().zip(weights).for_each(|(component, weight)| *component += problem.ridge * weight);
        *value = losses.joined() + 0.5 * problem.ridge * dot(weights, weights);
    }
}
