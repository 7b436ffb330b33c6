"""Mints logistic.json: ridge logistic regressions by scikit-learn.

Versions: Python 3.11, scikit-learn 1.9.1, numpy 2.4.6, scipy 1.17.1.
Command:  python mint_logistic.py > logistic.json

scikit-learn minimises |w|^2 / 2 + C * the sum of weighted losses. The weights sum to 1, so C = 1 / ridge. It has no
soft targets, so each sample appears twice: as positive with the weight share * target, and as negative with
share * (1 - target).
"""

import json
import sys

import numpy as np
from scipy.special import expit
from sklearn.linear_model import LogisticRegression


def case(rng, samples, features, positives, ridge, balanced, high, low):
    labels = np.arange(samples) < positives
    rows = np.round(rng.standard_normal((samples, features)) + 0.8 * labels[:, None], 4)
    if balanced:
        shares = np.where(labels, 0.5 / positives, 0.5 / (samples - positives))
    else:
        shares = np.full(samples, 1.0 / samples)
    targets = np.where(labels, high, low)
    model = LogisticRegression(C=1.0 / ridge, solver="newton-cholesky", tol=1e-14, max_iter=1000)
    model.fit(np.vstack([rows, rows]), np.repeat([1, 0], samples),
              sample_weight=np.concatenate([shares * targets, shares * (1.0 - targets)]))
    weights, intercept = model.coef_[0], model.intercept_[0]
    probability = expit(rows @ weights + intercept)
    residual = shares * (probability - targets)
    gradient = np.append(rows.T @ residual + ridge * weights, residual.sum())
    assert np.abs(gradient).max() < 1e-13, gradient
    return {"rows": rows.tolist(), "labels": labels.tolist(), "ridge": ridge, "balanced": balanced, "positive": high,
            "negative": low, "weights": weights.tolist(), "intercept": intercept, "probabilities": probability.tolist()}


rng = np.random.default_rng(20180611)
json.dump([
    case(rng, 24, 5, 4, 0.002, True, 0.95, 0.05),
    case(rng, 24, 5, 9, 0.1, False, 0.95, 0.05),
    case(rng, 9, 14, 2, 0.003, True, 0.9, 0.02),
    case(rng, 6, 10, 1, 0.02, False, 0.7, 0.4),
], sys.stdout)
print()
