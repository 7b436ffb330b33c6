"""Initiation classifiers: scikit-learn and numpy beside situ.

Ours is the mean loss with the ridge lambda and targets inside (0, 1); scikit-learn has hard labels and C on the sum of
the losses: C = 1 / (n lambda), and targets that are 0 and 1 but for the last bit. Both stop where no component of the
gradient is above the same tolerance.
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


def screen_case(classifiers: int, features: int, programs: Programs) -> Case:
    rng = np.random.default_rng(20180613)
    weights, intercepts = rng.standard_normal((classifiers, features)), rng.standard_normal(classifiers)
    row, odds = rng.standard_normal(features), np.empty(classifiers)

    def screen() -> np.ndarray:
        np.dot(weights, row, out=odds)
        np.add(odds, intercepts, out=odds)
        return odds

    ways = [Way("matrix product", in_process(lambda: screen, lambda odds: {"log_odds": odds}))]
    name = f"screening: log odds of one state under {classifiers} classifiers of {features} features"
    ours = programs.ours.measure({"screen": {"weights": weights, "intercepts": intercepts, "row": row}})
    return Case(name, ours, [Peer("numpy", ways)])
