"""Initiation classifiers: scikit-learn and numpy beside situ.

Regression: our objective is the mean loss with the ridge lambda, and our targets are inside (0, 1). scikit-learn has
hard labels, and a factor C on the sum of the losses. So C = 1 / (n lambda), and our targets differ from 0 and 1 by the
last bit. Both stop where no component of the gradient is above the same tolerance.

Screening (line A1.6): which nodes have a ball that holds a state, by the sum of squared differences to their centres.
For numpy's matrix product, the lengths of the centres are computed before, as an index would hold them.
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
    # One node in a hundred passes, and no node is so near the bound that rounding decides.
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
