"""Mints hmmlearn.json: expectation maximisation by an outside implementation.

Versions: Python 3.11, hmmlearn 0.3.3, scikit-learn 1.9.1, numpy 2.4.6, scipy 1.17.1.
Command:  python mint_hmmlearn.py > hmmlearn.json

hmmlearn has no end of a sequence, so the end is a state here. Each sequence is followed by two frames far from all
others. The last state alone can emit them, and goes only to itself. That is exactly the same model: its log likelihood
is ours plus the known log density of those frames, which is subtracted. hmmlearn divides a covariance by
max(covars_weight - D, 0) + the frames of the state. So covars_weight = nu0 + D and the matrix covars_prior = nu0 * S0
give the maximum a posteriori of situ. Frames have six dimensions, of which the last three are 0: equal rotations.
"""

import json
import sys

import numpy as np
from hmmlearn import hmm

NU0, POSITION, ROTATION, D, ITERATIONS = 4.0, 0.02, 0.15, 6, 20
S0 = np.diag([POSITION**2] * 3 + [ROTATION**2] * 3)
END_FRAME = np.array([8.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # a power of two: its sums are exact


def log_normal_at_mean(covariance):
    return -0.5 * (D * np.log(2 * np.pi) + np.linalg.slogdet(covariance)[1])


def run(sequences, initial, transition, end, means, covariances):
    states = len(initial)
    rows, lengths = [], []
    for sequence in sequences:
        frames = np.hstack([sequence, np.zeros((len(sequence), 3))])
        rows += [frames, END_FRAME[None], END_FRAME[None]]
        lengths.append(len(sequence) + 2)
    model = hmm.GaussianHMM(
        n_components=states + 1, covariance_type="full", min_covar=0.0, init_params="", params="stmc", n_iter=1,
        tol=-np.inf, covars_weight=NU0 + D, covars_prior=NU0 * S0, means_weight=0.0, implementation="log")
    model.startprob_ = np.append(initial, 0.0)
    full = np.zeros((states + 1, states + 1))
    full[:states, :states], full[:states, states], full[states, states] = transition, end, 1.0
    model.transmat_ = full
    model.n_features = D
    model.means_ = np.vstack([means, END_FRAME])
    model.covars_ = np.concatenate([covariances, S0[None]])
    history = []
    for _ in range(ITERATIONS):
        of_the_end = 2 * len(sequences) * log_normal_at_mean(model.covars_[states])
        model.fit(np.vstack(rows), lengths)
        history.append(model.monitor_.history[0] - of_the_end)
    of_the_end = 2 * len(sequences) * log_normal_at_mean(model.covars_[states])
    history.append(model.score(np.vstack(rows), lengths) - of_the_end)
    return {
        "sequences": [sequence.tolist() for sequence in sequences],
        "start": {"initial": list(initial), "transition": np.asarray(transition).ravel().tolist(), "end": list(end),
                  "means": np.asarray(means).tolist(),
                  "covariances": [c.ravel().tolist() for c in covariances]},
        "log_likelihoods": history,
        "initial": model.startprob_[:states].tolist(),
        "transition": model.transmat_[:states, :states].ravel().tolist(),
        "end": model.transmat_[:states, states].tolist(),
        "means": model.means_[:states].tolist(),
        "covariances": [c.ravel().tolist() for c in model.covars_[:states]],
    }


def sequences_of(rng, waypoints, paths, noise):
    return [np.round(waypoints[path] + noise * rng.standard_normal((len(path), 3)), 6) for path in paths]


def even_cut(sequences, states):
    """Each sequence cut into even runs; maximum a posteriori of each run."""
    runs = [[] for _ in range(states)]
    transition, end = np.zeros((states, states)), np.zeros(states)
    for sequence in sequences:
        labels = [t * states // len(sequence) for t in range(len(sequence))]
        for frame, label in zip(sequence, labels):
            runs[label].append(np.append(frame, np.zeros(3)))
        for before, after in zip(labels, labels[1:]):
            transition[before, after] += 1
        end[labels[-1]] += 1
    sums = transition.sum(axis=1) + end
    means = [np.mean(run, axis=0) for run in runs]
    covariances = [(sum(np.outer(x - m, x - m) for x in run) + NU0 * S0) / (len(run) + NU0)
                   for run, m in zip(runs, means)]
    return np.eye(states)[0], transition / sums[:, None], end / sums, means, np.array(covariances)


rng = np.random.default_rng(20180610)
waypoints = np.array([[0.0, 0.0, 0.2], [0.05, 0.02, 0.12], [0.08, 0.05, 0.02], [0.02, 0.1, 0.1]])
first = sequences_of(rng, waypoints, [np.arange(n) * 4 // n for n in [9, 11, 8, 12, 10]], 0.04)
# Some leave the first or the second waypoint out, and some stop early.
paths = [[0, 0, 1, 1, 2, 2, 2], [0, 0, 2, 2], [1, 1, 1, 2, 2], [0, 1, 1], [0, 0, 0], [1, 2, 2, 2]]
second = sequences_of(rng, waypoints, paths, 0.03)
# The second starts from a model where every state can stay, go on, be left out or end.
skips = ([0.7, 0.3, 0.0], [[0.5, 0.3, 0.1], [0.0, 0.6, 0.3], [0.0, 0.0, 0.7]], [0.1, 0.1, 0.3],
         np.hstack([waypoints[:3] + 0.01, np.zeros((3, 3))]), np.array([2.0 * S0] * 3))
json.dump({"prior_weight": NU0, "position_floor": POSITION, "rotation_floor": ROTATION, "iterations": ITERATIONS,
           "even_cut": run(first, *even_cut(first, 4)), "skips": run(second, *skips)}, sys.stdout)
print()
