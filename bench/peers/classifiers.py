"""Initiation classifiers: scikit-learn and numpy beside situ.

Regression: ours is the mean loss with the ridge lambda and targets inside (0, 1); scikit-learn has hard labels and C on the sum of
the losses: C = 1 / (n lambda), and targets that are 0 and 1 but for the last bit. Both stop where no component of the
gradient is above the same tolerance.

Screening (line A1.6): which nodes' balls hold a state, by the sum of squared differences to their centres. numpy's
matrix product has the lengths of the centres ready, as an index would.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from sklearn.linear_model import LogisticRegression

from cases import Case, Peer, Way, in_process
from programs import Programs
from values import Values

RIDGE, GRADIENT = 0.002, 1e-9


def regress_case(samples: int, features: int, apart: float, programs: Programs) -> Case:
    rng = np.random.default_rng([20180612, samples])
    labels = rng.random(samples) < 0.3
    rows = rng.standard_normal((samples, features)) + apart * labels[:, None]

    def prepare(solver: str) -> Callable[[], LogisticRegression]:
        model = LogisticRegression(C=1.0 / (samples * RIDGE), solver=solver, tol=GRADIENT, max_iter=1000)
        return lambda: model.fit(rows, labels)

    def values(model: LogisticRegression) -> Values:
        return {"weights": model.coef_[0], "intercept": model.intercept_}

    ways = [Way(f"solver {solver}", in_process(partial(prepare, solver), values))
            for solver in ("lbfgs", "newton-cholesky")]
    ours = programs.ours.measure({"regress": {
        "rows": rows, "labels": labels, "ridge": RIDGE, "tolerance": GRADIENT}})
    return Case(f"logistic regression, {samples} × {features}", ours, [Peer("scikit-learn", ways)])


def screen_case(nodes: int, features: int, programs: Programs) -> Case:
    rng = np.random.default_rng([20180613, features])
    centres, row = rng.standard_normal((nodes, features)), rng.standard_normal(features)
    # One in a hundred passes, and none is so near the bound that rounding decides.
    squares = np.sort(((centres - row) ** 2).sum(axis=1))
    greatest = squares[nodes // 100 - 1:nodes // 100 + 1].mean()
    lengths, apart = (centres ** 2).sum(axis=1), np.empty_like(centres)

    def differences() -> np.ndarray:
        np.subtract(centres, row, out=apart)
        return np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= greatest)

    def product() -> np.ndarray:
        return np.flatnonzero(lengths - 2.0 * (centres @ row) + row @ row <= greatest)

    ways = [Way(name, in_process(lambda work=work: work, lambda passing: {"passing": passing}))
            for name, work in (("differences", differences), ("matrix product", product))]
    name = f"screening: which of {nodes} nodes a state of {features} features can activate"
    ours = programs.ours.measure({"screen": {"centres": centres, "greatest": greatest, "row": row}})
    return Case(name, ours, [Peer("numpy", ways)])
