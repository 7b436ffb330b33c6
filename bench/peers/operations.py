"""Counts the operations on doubles that a fit of a Gaussian HMM needs, whichever program makes the fit.

An operation is an addition, a subtraction, a multiplication or a division. Comparisons, changes of sign and powers of
two are no operations. Each operation that the definition of the fit (situ/src/keyframe/hmm/fit.rs) asks for is counted
once. With F frames in S sequences, K states, D = 6 dimensions, A transitions that the chain has, and I iterations:

* Before the first iteration, F K residuals: a position's is 3 differences, a rotation's a logarithm (59).
* Each of the I + 1 expectation steps:
  * for every frame and state, whitening and the squared length, D (D + 1) + D - 1 = 47; the log density, 2; less the
    frame's greatest, 1; an exponential (23).
  * for every two frames that follow each other, the recursions, 6 A: forward A products, A - K sums and K densities;
    backward the same; A products and A sums of the expected transitions.
  * for every frame and state, the posterior, 2.
* Each of the I maximisation steps:
  * for every frame and state, the sum of the shares, 1, and the residual of the position, 3.
  * for every step of a state's mean, F logarithms of rotations.
  * for every frame that counts in a state, the weighted position, 6; the weighted rotation, 6, and again after each
    step of the mean; the weighted scatter, D + D (D + 1) = 48, and again about the mean before where the mean turned,
    for the guard of the objective.

A frame counts in a state where its share is not below 1e-20 of the state's; the fit leaves the others out. Where all
rotations are about one axis, a step of the mean is exact. So a state's mean takes one step where it turns by the
tolerance or more, and none otherwise. The work that is done once for each sequence or state (factors of covariances,
logarithms of likelihoods, proportions) is left out: it is less than a hundredth.

The logarithm of a rotation: the quaternion's product with the mean's conjugate, 28; the squared sine, 5; a series of
12 coefficients, 22; its factor and the vector, 4. The exponential is counted as the crate `libm` computes it: the
multiple of log 2, 2; the rest of it in two parts, 4; a square, 1; a polynomial, 10; a quotient and the sum, 6. Ours has
longer polynomials for both, so that it needs no root, quotient or branch; the operations beyond these are not counted.
"""

from dataclasses import dataclass

import numpy as np

POSITION_DIFFERENCE, LOGARITHM, EXPONENTIAL = 3, 28 + 5 + 22 + 4, 2 + 4 + 1 + 10 + 6
WEIGHTED_VECTOR = 6
"""Three products and three sums."""
NEGLIGIBLE_SHARE, MEAN_TOLERANCE = 1e-20, 1e-9


@dataclass
class FitCount:
    """What one fit went through."""

    frames: int
    sequences: int
    states: int
    dimensions: int
    transitions: int
    iterations: int = 0
    counting: int = 0
    """The frames that count in a state, summed over all states and iterations."""
    turned_counting: int = 0
    """Of these, those in states whose mean turned."""
    mean_steps: int = 0
    """Over all states and iterations."""

    def add_iteration(self, posteriors: np.ndarray, turned: np.ndarray) -> None:
        """Adds a maximisation step: the posteriors, shape (F, K), and the angle by which each mean turned, radians."""
        counting = (posteriors >= NEGLIGIBLE_SHARE * posteriors.sum(axis=0)).sum(axis=0)
        steps = turned >= MEAN_TOLERANCE
        self.iterations += 1
        self.counting += int(counting.sum())
        self.turned_counting += int(counting[steps].sum())
        self.mean_steps += int(steps.sum())

    def operations(self) -> int:
        """All of them."""
        d, cells = self.dimensions, self.frames * self.states
        scatter = d + d * (d + 1)
        expectation = cells * (d * (d + 1) + d - 1 + 2 + 1 + EXPONENTIAL + 2)
        expectation += (self.frames - self.sequences) * 6 * self.transitions
        return (cells * (POSITION_DIFFERENCE + LOGARITHM)
                + (self.iterations + 1) * expectation
                + self.iterations * cells * (1 + POSITION_DIFFERENCE)
                + self.mean_steps * self.frames * LOGARITHM
                + self.counting * (2 * WEIGHTED_VECTOR + scatter)
                + self.turned_counting * (WEIGHTED_VECTOR + scatter))
