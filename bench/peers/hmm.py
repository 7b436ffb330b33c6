"""Hidden Markov models: hmmlearn and the crate hmmlearn-rs beside situ.

All compute the same, for these reasons:

* Poses. Ours are in R3 x S3 and hmmlearn's in R6. They are the same model where all rotations are about one axis,
  because the logarithm at a mean is then the difference of the angles. So a frame here is a position and an angle
  times a slanted axis: hmmlearn gets the position and the rotation vector, ours the pose. Covariances are full. In the
  two directions in which the frames do not vary, they are those of the prior. Ours also takes the logarithms of
  rotations and the mean on the manifold, which hmmlearn does not.
* Ends. hmmlearn has none. `EndingHMM` puts the probability of going on, or of ending, at each frame beside the
  frame's density, and re-estimates it. That needs no further state and no further frame, and costs hmmlearn hardly any
  time.
* Prior. hmmlearn divides a covariance by max(covars_weight - D, 0) + the state's frames, so covars_weight = nu0 + D
  and the matrix covars_prior = nu0 * S0 give the maximum a posteriori of situ.
* Iterations. All are made. Ours has one expectation step more, for the likelihood of the last model.
* The crate. hmmlearn-rs is a port of hmmlearn, and it cannot be asked exactly the same. It has no ends, and no way to
  put them beside a frame's density. Its prior of the covariances is one number, which is added to every element of the
  scatter. So a covariance would be singular in the two directions in which the frames do not vary. For these reasons
  its frames have noise in these two directions, its model has no ends, and its values must be those of hmmlearn's
  GaussianHMM of the same frames, start, prior and iterations. Frames, states and iterations are as many as ours, and
  its time hardly depends on the numbers. Ours computes the ends and the rotations besides.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from hmmlearn.hmm import GaussianHMM

from cases import Case, Peer, Way, in_process
from operations import FitCount
from programs import Program, Programs
from values import Values

STATES, D, ITERATIONS = 6, 6, 20
NU0, POSITION, ROTATION = 4.0, 0.02, 0.15
S0 = np.diag([POSITION**2] * 3 + [ROTATION**2] * 3)
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
LIFT = np.zeros((D, 4))
"""Takes a position and an angle to a position and a rotation vector."""
LIFT[:3, :3], LIFT[3:, 3] = np.eye(3), AXIS
UNMOVED = np.zeros((D, D))
"""The prior's variance in the directions in which the frames do not vary."""
UNMOVED[3:, 3:] = ROTATION**2 * (np.eye(3) - np.outer(AXIS, AXIS))
CRATE_PRIOR = NU0 * POSITION**2
"""What the crate adds to every element of a state's scatter."""
IMPLEMENTATIONS = ("log", "scaling")


class EndingHMM(GaussianHMM):
    """hmmlearn's model with an end after each state. `transmat_` is the chain of the sequences that go on."""

    ends_: np.ndarray

    def _compute_log_likelihood(self, X: np.ndarray) -> np.ndarray:
        densities = super()._compute_log_likelihood(X)
        with np.errstate(divide="ignore"):
            densities[:-1] += np.log1p(-self.ends_)
            densities[-1] += np.log(self.ends_)
        return densities

    def _initialize_sufficient_statistics(self) -> dict[str, Any]:
        return super()._initialize_sufficient_statistics() | {"ends": np.zeros(self.n_components)}

    def _accumulate_sufficient_statistics(self, stats: dict[str, Any], X: np.ndarray, lattice: np.ndarray,
                                          posteriors: np.ndarray, fwdlattice: np.ndarray,
                                          bwdlattice: np.ndarray) -> None:
        super()._accumulate_sufficient_statistics(stats, X, lattice, posteriors, fwdlattice, bwdlattice)
        stats["ends"] += posteriors[-1]

    def _do_mstep(self, stats: dict[str, Any]) -> None:
        super()._do_mstep(stats)
        self.ends_ = stats["ends"] / (stats["ends"] + stats["trans"].sum(axis=1))


class CountingHMM(EndingHMM):
    """The same, and counts the work of its fit."""

    def __init__(self, count: FitCount, **parameters: Any) -> None:
        super().__init__(**parameters)
        self.count, self.posteriors = count, []

    def _accumulate_sufficient_statistics(self, stats: dict[str, Any], X: np.ndarray, lattice: np.ndarray,
                                          posteriors: np.ndarray, fwdlattice: np.ndarray,
                                          bwdlattice: np.ndarray) -> None:
        super()._accumulate_sufficient_statistics(stats, X, lattice, posteriors, fwdlattice, bwdlattice)
        self.posteriors.append(posteriors)

    def _do_mstep(self, stats: dict[str, Any]) -> None:
        before = self.means_.copy()
        super()._do_mstep(stats)
        self.count.add_iteration(np.vstack(self.posteriors), np.linalg.norm((self.means_ - before)[:, 3:], axis=1))
        self.posteriors.clear()


def left_to_right(rng: np.random.Generator, waypoints: np.ndarray, spread: float) -> dict[str, Any]:
    """A model through these waypoints, shape (K, 4), where every state can stay, go on, be left out or end."""
    transition = 0.6 * np.eye(STATES) + 0.3 * np.eye(STATES, k=1) + 0.05 * np.eye(STATES, k=2)
    covariances = []
    for _ in range(STATES):
        mixed = np.eye(4) + 0.3 * rng.standard_normal((4, 4))
        scale = spread * np.diag([POSITION] * 3 + [ROTATION])
        covariances.append(LIFT @ scale @ mixed @ mixed.T @ scale @ LIFT.T + UNMOVED)
    return {"initial": np.array([0.8, 0.2] + [0.0] * (STATES - 2)), "transition": transition,
            "end": 1.0 - transition.sum(axis=1), "means": waypoints @ LIFT.T, "covariances": np.array(covariances)}


def some_waypoints(rng: np.random.Generator) -> np.ndarray:
    """K positions and angles, 8 cm and 0.3 rad from one to the next: so near that states overlap. Shape (K, 4)."""
    steps = rng.standard_normal((STATES, 3))
    steps *= 0.08 / np.linalg.norm(steps, axis=1, keepdims=True)
    return np.cumsum(np.column_stack([steps, 0.3 * rng.choice([-1.0, 1.0], STATES)]), axis=0)


def hmm_of(model: dict[str, Any], implementation: str, kind: Callable[..., GaussianHMM] = EndingHMM,
           covariance_prior: np.ndarray | float = NU0 * S0) -> Any:
    hmm = kind(
        n_components=STATES, covariance_type="full", min_covar=0.0, init_params="", params="stmc", n_iter=ITERATIONS,
        tol=-np.inf, covars_weight=NU0 + D, covars_prior=covariance_prior, means_weight=0.0,
        implementation=implementation)
    hmm.n_features = D
    hmm.startprob_, hmm.means_, hmm.covars_ = model["initial"], model["means"], model["covariances"]
    hmm.transmat_ = model["transition"] / model["transition"].sum(axis=1, keepdims=True)
    if isinstance(hmm, EndingHMM):
        hmm.ends_ = model["end"]
    return hmm


def fitted_values(frames: np.ndarray, lengths: list[int], hmm: GaussianHMM) -> Values:
    values = {
        "log_likelihoods": np.append(hmm.monitor_.history, hmm.score(frames, lengths)),
        "initial": hmm.startprob_,
        "transition": hmm.transmat_,
        "means": hmm.means_,
        "covariances": hmm.covars_,
    }
    if isinstance(hmm, EndingHMM):
        values |= {"transition": hmm.transmat_ * (1.0 - hmm.ends_)[:, None], "end": hmm.ends_}
    return values


def passes(rng: np.random.Generator, waypoints: np.ndarray, count: int) -> list[np.ndarray]:
    """Noisy passes by the waypoints, some frames at each, one in ten left out: about 20 frames each, shape (T, 6)."""
    made = []
    for _ in range(count):
        dwell = rng.integers(2, 6, STATES) * (rng.random(STATES) > 0.1)
        path = np.repeat(np.arange(STATES), dwell if dwell.any() else 1)
        noise = rng.standard_normal((len(path), 4)) * [0.03, 0.03, 0.03, 0.15]
        made.append((waypoints[path] + noise) @ LIFT.T)
    return made


def fit_case(sequences: int, counted: bool, programs: Programs) -> Case:
    rng = np.random.default_rng(20180610)
    waypoints = some_waypoints(rng)
    start = left_to_right(rng, waypoints + rng.standard_normal((STATES, 4)) * [0.01, 0.01, 0.01, 0.05], 2.0)
    shown = passes(rng, waypoints, sequences)
    frames, lengths = np.vstack(shown), [len(sequence) for sequence in shown]

    def prepare(implementation: str) -> Callable[[], EndingHMM]:
        hmm = hmm_of(start, implementation)
        return lambda: hmm.fit(frames, lengths)

    def count() -> FitCount:
        count = FitCount(len(frames), sequences, STATES, D, np.count_nonzero(start["transition"]))
        hmm_of(start, "scaling", partial(CountingHMM, count)).fit(frames, lengths)
        return count

    ways = [Way(f"implementation {name}", in_process(partial(prepare, name), partial(fitted_values, frames, lengths)))
            for name in IMPLEMENTATIONS]
    name = f"Gaussian HMM fit, K {STATES}, D {D}, full covariance, {ITERATIONS} iterations, {sequences} sequences"
    ours = programs.ours.measure({"fit": {
        "start": start, "sequences": shown, "iterations": ITERATIONS, "prior_weight": NU0, "position_floor": POSITION,
        "rotation_floor": ROTATION}})
    peers = [Peer("hmmlearn", ways), crate(programs.hmmlearn_rs, start, frames + unmoved_noise(len(frames)), lengths)]
    return Case(name, ours, peers, count if counted else None)


def unmoved_noise(frames: int) -> np.ndarray:
    """The noise of the crate's frames in the two directions in which they do not vary, shape (frames, 6)."""
    rng = np.random.default_rng(20180614)
    return rng.standard_normal((frames, D)) @ UNMOVED / ROTATION


def crate(program: Program, start: dict[str, Any], frames: np.ndarray, lengths: list[int]) -> Peer:
    """The crate hmmlearn-rs, whose values must be those of hmmlearn without ends."""
    plain = partial(hmm_of, start, "scaling", GaussianHMM, CRATE_PRIOR)
    start = {name: getattr(plain(), name) for name in ("startprob_", "transmat_", "means_", "covars_")}
    question = {
        "initial": start["startprob_"], "transition": start["transmat_"], "means": start["means_"],
        "covariances": start["covars_"], "frames": frames, "lengths": lengths, "iterations": ITERATIONS,
        "covariance_prior": CRATE_PRIOR, "covariance_weight": NU0 + D}
    ways = [Way(f"implementation {name}", program.measure(question | {"implementation": name}))
            for name in IMPLEMENTATIONS]
    return Peer("hmmlearn-rs", ways, lambda: fitted_values(frames, lengths, plain().fit(frames, lengths)))


def sampled(rng: np.random.Generator, model: dict[str, Any], length: int) -> np.ndarray:
    """Frames of a sequence that did not end before `length`, shape (length, 6)."""
    state, frames = int(rng.choice(STATES, p=model["initial"])), []
    for _ in range(length):
        frames.append(model["means"][state] + LIFT @ LIFT.T @ model["roots"][state] @ rng.standard_normal(D))
        onward = model["transition"][state]
        state = int(rng.choice(STATES, p=onward / onward.sum()))
    return np.array(frames)


def score_case(models: int, sequences: int, length: int, programs: Programs) -> Case:
    rng = np.random.default_rng(20180611)
    waypoints = some_waypoints(rng)
    siblings = [left_to_right(rng, waypoints + rng.standard_normal((STATES, 4)) * [0.02, 0.02, 0.02, 0.1], 1.0)
                for _ in range(models)]
    sets = []
    for model in siblings:
        rooted = model | {"roots": np.linalg.cholesky(model["covariances"])}
        sets.append([sampled(rng, rooted, length) for _ in range(sequences)])
    stacked, lengths = [np.vstack(one) for one in sets], [length] * sequences

    def prepare(implementation: str) -> Callable[[], np.ndarray]:
        hmms = [hmm_of(model, implementation) for model in siblings]
        return lambda: np.array([hmm.score(frames, lengths) for frames in stacked for hmm in hmms])

    ways = [Way(f"implementation {name}",
                in_process(partial(prepare, name), lambda scores: {"log_likelihoods": scores}))
            for name in IMPLEMENTATIONS]
    name = f"Monte Carlo KL, all pairs of {models} HMMs, {sequences} sequences of {length} frames of each, scoring"
    return Case(name, programs.ours.measure({"score": {"models": siblings, "sets": sets}}), [Peer("hmmlearn", ways)])
