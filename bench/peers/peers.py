"""Times hmmlearn, scikit-learn and numpy beside the kernels of situ, on the same numbers and in the same minute.

    python3.11 -m venv VENV && VENV/bin/pip install -r bench/peers/requirements.txt
    VENV/bin/python bench/peers/peers.py --out results/peers

Each case makes its numbers from a seed. The Rust side (bench/examples/peers.rs) reads them from a file. First both
sides compute the case once and their values must agree; otherwise the script names the first number that does not and
ends with exit status 1. Then they take turns, peer and ours, for some rounds, each on one thread; a round's time is
the median of its runs, and its ratio is the peer's time over ours. Where the peer has several ways to the same
values, all are checked, and the one that was fastest then is timed.

How the two are made the same computation:

* Poses. Ours are in R3 x S3 and hmmlearn's in R6. They are the same model where all rotations are about one axis:
  then the logarithm at a mean is the difference of the angles, at any angle. So a frame here is a position and an
  angle times a slanted axis: hmmlearn gets the position and the rotation vector, ours the pose. The angles are of the
  size of a task's (tenths of a radian), so that ours takes the same branch of the logarithm as it does for any pose.
  Covariances are full; in the two directions in which the frames do not vary, they are the prior's. Ours also takes
  the logarithms of rotations and the mean on the manifold, which hmmlearn does not.
* Ends. hmmlearn has none. `EndingHMM` puts the probability of going on, or of ending, at each frame beside the
  frame's density, and re-estimates it. That needs no state more and no frame more, and takes hmmlearn no time to
  speak of.
* Prior. hmmlearn divides a covariance by max(covars_weight - D, 0) + the state's frames, so covars_weight = nu0 + D
  and the matrix covars_prior = nu0 * S0 give the maximum a posteriori of situ.
* Iterations. Both make all of them. Ours has one expectation step more, for the likelihood of the last model.
* Logistic regression. Ours is the mean loss with the ridge lambda and targets inside (0, 1); scikit-learn has hard
  labels and C on the sum of the losses: C = 1 / (n lambda), and targets that are 0 and 1 but for the last bit. Both
  stop where no component of the gradient is above the same tolerance.
"""

import os

# Before numpy is imported: its libraries read these once.
for _pool in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMEXPR", "VECLIB_MAXIMUM", "RAYON"):
    os.environ[f"{_pool}_NUM_THREADS"] = "1"

import argparse
import csv
import gc
import json
import logging
import platform
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from time import perf_counter_ns
from typing import Any

import numpy as np
from hmmlearn.hmm import GaussianHMM
from sklearn.linear_model import LogisticRegression

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("hmmlearn", "scikit-learn", "numpy", "scipy")

Values = dict[str, np.ndarray]


class Disagreement(Exception):
    """A number of ours is not the peer's."""


@dataclass(frozen=True)
class Tolerance:
    """How near two numbers must be: relative to the greater of the peer's and `scale`, a typical one.

    Without a scale, relative to the peer's greatest.
    """

    label: str
    relative: float
    scale: float | None = 1.0


TOLERANCES = {
    "log_likelihoods": Tolerance("log likelihoods", 1e-9),
    "initial": Tolerance("parameters", 1e-9),
    "transition": Tolerance("parameters", 1e-9),
    "end": Tolerance("parameters", 1e-9),
    "means": Tolerance("parameters", 1e-9, 0.01),
    "covariances": Tolerance("parameters", 1e-9, 1e-4),
    # lbfgs stops where the loss no longer falls by 64 roundings: half a millionth of the greatest weight away.
    "weights": Tolerance("weights", 1e-6, None),
    "intercept": Tolerance("weights", 1e-6),
    "log_odds": Tolerance("log odds", 1e-12),
}


@dataclass(frozen=True)
class Way:
    """One way of the peer to compute a case."""

    name: str
    prepare: Callable[[], Callable[[], Any]]
    """Makes what is timed, anew for each run."""
    values: Callable[[Any], Values]
    """The numbers to compare, of what the run returned."""


@dataclass(frozen=True)
class Case:
    """One computation, asked of both sides."""

    name: str
    package: str
    ways: list[Way]
    question: dict[str, Any]
    """What the Rust side reads."""


@dataclass(frozen=True)
class Row:
    """What came out of a case. Times are milliseconds, one a round."""

    case: str
    package: str
    way: str
    peer: list[float]
    ours: list[float]
    agreement: dict[str, float]

    @property
    def ratios(self) -> list[float]:
        return [peer / ours for peer, ours in zip(self.peer, self.ours, strict=True)]


# Hidden Markov models.

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


class EndingHMM(GaussianHMM):
    """hmmlearn's model with an end after each state: `transmat_` is the chain of those sequences that go on."""

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


def hmm_of(model: dict[str, Any], implementation: str) -> EndingHMM:
    hmm = EndingHMM(
        n_components=STATES, covariance_type="full", min_covar=0.0, init_params="", params="stmc", n_iter=ITERATIONS,
        tol=-np.inf, covars_weight=NU0 + D, covars_prior=NU0 * S0, means_weight=0.0, implementation=implementation)
    hmm.n_features = D
    hmm.startprob_, hmm.ends_ = model["initial"], model["end"]
    hmm.transmat_ = model["transition"] / model["transition"].sum(axis=1, keepdims=True)
    hmm.means_, hmm.covars_ = model["means"], model["covariances"]
    return hmm


def fitted_values(frames: np.ndarray, lengths: list[int], hmm: EndingHMM) -> Values:
    return {
        "log_likelihoods": np.append(hmm.monitor_.history, hmm.score(frames, lengths)),
        "initial": hmm.startprob_,
        "transition": hmm.transmat_ * (1.0 - hmm.ends_)[:, None],
        "end": hmm.ends_,
        "means": hmm.means_,
        "covariances": hmm.covars_,
    }


def passes(rng: np.random.Generator, waypoints: np.ndarray, count: int) -> list[np.ndarray]:
    """Noisy passes by the waypoints, some frames at each, one in ten left out: about 20 frames each, shape (T, 6)."""
    made = []
    for _ in range(count):
        dwell = rng.integers(2, 6, STATES) * (rng.random(STATES) > 0.1)
        path = np.repeat(np.arange(STATES), dwell if dwell.any() else 1)
        noise = rng.standard_normal((len(path), 4)) * [0.03, 0.03, 0.03, 0.15]
        made.append((waypoints[path] + noise) @ LIFT.T)
    return made


def fit_case(sequences: int) -> Case:
    rng = np.random.default_rng(20180610)
    waypoints = some_waypoints(rng)
    start = left_to_right(rng, waypoints + rng.standard_normal((STATES, 4)) * [0.01, 0.01, 0.01, 0.05], 2.0)
    shown = passes(rng, waypoints, sequences)
    frames, lengths = np.vstack(shown), [len(sequence) for sequence in shown]

    def prepare(implementation: str) -> Callable[[], EndingHMM]:
        hmm = hmm_of(start, implementation)
        return lambda: hmm.fit(frames, lengths)

    ways = [Way(f"implementation {name}", partial(prepare, name), partial(fitted_values, frames, lengths))
            for name in ("log", "scaling")]
    name = f"Gaussian HMM fit, K {STATES}, D {D}, full covariance, {ITERATIONS} iterations, {sequences} sequences"
    return Case(name, "hmmlearn", ways, {"fit": {
        "start": start, "sequences": shown, "iterations": ITERATIONS, "prior_weight": NU0, "position_floor": POSITION,
        "rotation_floor": ROTATION}})


def sampled(rng: np.random.Generator, model: dict[str, Any], length: int) -> np.ndarray:
    """Frames of a sequence that did not end before `length`, shape (length, 6)."""
    state, frames = int(rng.choice(STATES, p=model["initial"])), []
    for _ in range(length):
        frames.append(model["means"][state] + LIFT @ LIFT.T @ model["roots"][state] @ rng.standard_normal(D))
        onward = model["transition"][state]
        state = int(rng.choice(STATES, p=onward / onward.sum()))
    return np.array(frames)


def score_case(models: int, sequences: int, length: int) -> Case:
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

    ways = [Way(f"implementation {name}", partial(prepare, name), lambda scores: {"log_likelihoods": scores})
            for name in ("log", "scaling")]
    name = f"Monte Carlo KL, all pairs of {models} HMMs, {sequences} sequences of {length} frames of each, scoring"
    return Case(name, "hmmlearn", ways, {"score": {"models": siblings, "sets": sets}})


# Classifiers.

RIDGE, GRADIENT = 0.002, 1e-9


def regress_case(samples: int, features: int, apart: float) -> Case:
    rng = np.random.default_rng([20180612, samples])
    labels = rng.random(samples) < 0.3
    rows = rng.standard_normal((samples, features)) + apart * labels[:, None]

    def prepare(solver: str) -> Callable[[], LogisticRegression]:
        model = LogisticRegression(C=1.0 / (samples * RIDGE), solver=solver, tol=GRADIENT, max_iter=1000)
        return lambda: model.fit(rows, labels)

    ways = [Way(f"solver {solver}", partial(prepare, solver),
                lambda model: {"weights": model.coef_[0], "intercept": model.intercept_})
            for solver in ("lbfgs", "newton-cholesky")]
    return Case(f"logistic regression, {samples} × {features}", "scikit-learn", ways, {"regress": {
        "rows": rows, "labels": labels, "ridge": RIDGE, "tolerance": GRADIENT}})


def screen_case(classifiers: int, features: int) -> Case:
    rng = np.random.default_rng(20180613)
    weights, intercepts = rng.standard_normal((classifiers, features)), rng.standard_normal(classifiers)
    row, odds = rng.standard_normal(features), np.empty(classifiers)

    def screen() -> np.ndarray:
        np.dot(weights, row, out=odds)
        np.add(odds, intercepts, out=odds)
        return odds

    ways = [Way("matrix product", lambda: screen, lambda odds: {"log_odds": odds})]
    name = f"screening: log odds of one state under {classifiers} classifiers of {features} features"
    return Case(name, "numpy", ways, {"screen": {"weights": weights, "intercepts": intercepts, "row": row}})


CASES: dict[str, Callable[[], Case]] = {
    "fit-20": partial(fit_case, 20),
    "fit-500": partial(fit_case, 500),
    "score-100": partial(score_case, 10, 100, 10),
    "score-1000": partial(score_case, 10, 1000, 10),
    "logistic-50": partial(regress_case, 50, 13, 0.8),
    "logistic-5000": partial(regress_case, 5000, 40, 0.2),
    "screen": partial(screen_case, 10_000, 13),
}
SLOW = {"score-1000"}
"""Only where asked for: hmmlearn takes most of a minute for one run."""


# Both sides, in turns.


def ask(binary: Path, question: Path, seconds: float) -> tuple[Values, float]:
    """Our values, and the milliseconds of a run."""
    done = subprocess.run([binary, question, str(seconds)], stdout=subprocess.PIPE, check=True)
    answer = json.loads(done.stdout)
    values = {name: np.array(numbers, dtype=float) for name, numbers in answer["values"].items()}
    return values, statistics.median(answer["nanoseconds"]) / 1e6


def measure(way: Way, seconds: float) -> tuple[float, Any]:
    """The median milliseconds of the peer's runs, as many as the seconds hold; and what the last one returned."""
    taken: list[int] = []
    gc.collect()
    gc.disable()
    while not taken or sum(taken) < seconds * 1e9:
        work = way.prepare()
        start = perf_counter_ns()
        result = work()
        taken.append(perf_counter_ns() - start)
    gc.enable()
    return statistics.median(taken) / 1e6, result


def compare(case: str, ours: Values, peers: Values) -> dict[str, float]:
    """The greatest relative difference by label. Raises `Disagreement` at the first number that is too far off."""
    if ours.keys() != peers.keys():
        raise Disagreement(f"{case}: ours has {sorted(ours)}, the peer {sorted(peers)}")
    agreement: dict[str, float] = {}
    for name, expected in peers.items():
        expected, found, tolerance = np.ravel(expected), ours[name], TOLERANCES[name]
        if found.shape != expected.shape:
            raise Disagreement(f"{case}: {name}: ours are {found.size} numbers, the peer's {expected.size}")
        scale = np.abs(expected).max() if tolerance.scale is None else tolerance.scale
        apart = np.abs(found - expected) / np.maximum(np.abs(expected), scale)
        # Written so that what is not a number is too far off.
        for index in np.flatnonzero(~(apart <= tolerance.relative))[:1]:
            raise Disagreement(f"{case}: {name} {index}: ours is {found[index]}, the peer's {expected[index]}, "
                               f"apart by {apart[index]:.1e} where {tolerance.relative:.0e} is allowed")
        agreement[tolerance.label] = max(agreement.get(tolerance.label, 0.0), float(apart.max()))
    return agreement


def run(case: Case, binary: Path, folder: Path, rounds: int, seconds: float) -> Row:
    question = folder / "question.json"
    question.write_text(json.dumps(case.question, default=lambda numbers: numbers.tolist()))
    values = ask(binary, question, 0.0)[0]
    trials: dict[str, float] = {}
    agreement: dict[str, float] = {}
    for way in case.ways:
        trials[way.name], result = measure(way, seconds)
        for label, apart in compare(f"{case.name} ({way.name})", values, way.values(result)).items():
            agreement[label] = max(apart, agreement.get(label, 0.0))
    fastest = min(case.ways, key=lambda way: trials[way.name])
    peer, ours = [], []
    for _ in range(rounds):
        peer.append(measure(fastest, seconds)[0])
        ours.append(ask(binary, question, seconds)[1])
    return Row(case.name, case.package, fastest.name, peer, ours, agreement)


# The table.


def machine() -> dict[str, str]:
    """The machine, what else it is doing (the load average of the last minute) and the versions."""
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return {"cpu": cpu(), "cores": str(os.cpu_count()), "load": load, "python": platform.python_version()} | {
        package: version(package) for package in PACKAGES}


def cpu() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def digits(value: float) -> str:
    """Three significant digits, without an exponent."""
    return np.format_float_positional(float(f"{value:.3g}"), trim="-")


def markdown(rows: list[Row], about: dict[str, str], command: str) -> str:
    versions = ", ".join(f"{name} {about[name]}" for name in PACKAGES)
    lines = [
        "## Peers: other libraries beside the kernels of situ", "",
        f"Made by `{command}`; do not edit.", "",
        f"{about['cpu']}, {about['cores']} cores, load average {about['load']} before; Python {about['python']}, "
        f"{versions}; one thread each. Times are wall-clock medians over the rounds; the ratio, peer over ours, is "
        "taken in each round: its median and [least, greatest]. Agreement is the greatest relative difference between "
        "the values of both. In the cases of hmmlearn, ours also takes the logarithms of rotations, which hmmlearn "
        "does not; `bench/peers/peers.py` says how both are the same computation.", "",
        "| case | peer | peer ms | ours ms | ratio | rounds | agreement |",
        "| --- | --- | ---: | ---: | ---: | ---: | --- |",
    ]
    for row in rows:
        ratios = row.ratios
        agreement = ", ".join(f"{label} {apart:.0e}" for label, apart in row.agreement.items())
        spread = f"{digits(statistics.median(ratios))} [{digits(min(ratios))}, {digits(max(ratios))}]"
        peer, ours = digits(statistics.median(row.peer)), digits(statistics.median(row.ours))
        lines.append(f"| {row.case} | {row.package} {about[row.package]}, {row.way} | {peer} | {ours} | {spread} "
                     f"| {len(ratios)} | {agreement} |")
    return "\n".join(lines) + "\n"


def write_csv(path: Path, rows: list[Row], about: dict[str, str]) -> None:
    """One line a case and round."""
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", "peer", "version", "way", "round", "peer_ms", "ours_ms", "ratio", "agreement", *about])
        for row in rows:
            worst = max(row.agreement.values())
            for index, (peer, ours, ratio) in enumerate(zip(row.peer, row.ours, row.ratios, strict=True), start=1):
                table.writerow([row.case, row.package, about[row.package], row.way, index, f"{peer:.6g}", f"{ours:.6g}",
                                f"{ratio:.6g}", f"{worst:.1e}", *about.values()])


def built() -> Path:
    """Builds the Rust side; where cargo put it."""
    command = ["cargo", "build", "--release", "-p", "situ-bench", "--example", "peers", "--message-format", "json"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
    made = [message.get("executable") for message in map(json.loads, done.stdout.splitlines())
            if message.get("target", {}).get("name") == "peers"]
    return Path(next(path for path in made if path))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, help="folder for peers.md and peers.csv (default: only print the table)")
    parser.add_argument("--binary", type=Path, help="the built example `peers` (default: build it by cargo)")
    parser.add_argument("--rounds", type=int, default=7, help="turns of peer and ours a case (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=0.1,
                        help="each side's runs in a round take this long together (default: %(default)s)")
    parser.add_argument("--case", action="append", choices=CASES,
                        help=f"only this case; can be repeated (default: all but {', '.join(sorted(SLOW))})")
    asked = parser.parse_args()
    if asked.rounds < 1:
        parser.error("--rounds must be at least 1")
    return asked


def main() -> int:
    asked = arguments()
    # hmmlearn warns where the likelihood falls; what climbs is its sum with the log prior.
    logging.getLogger("hmmlearn").setLevel(logging.ERROR)
    try:
        binary = asked.binary or built()
        about, rows = machine(), []
        with tempfile.TemporaryDirectory() as folder:
            for name in asked.case or [name for name in CASES if name not in SLOW]:
                rows.append(run(CASES[name](), binary, Path(folder), asked.rounds, asked.seconds))
                print(f"{name}: {digits(statistics.median(rows[-1].ratios))} ×", file=sys.stderr)
        table = markdown(rows, about, "python bench/peers/peers.py --out results/peers")
        print(table, end="")
        if asked.out:
            asked.out.mkdir(parents=True, exist_ok=True)
            (asked.out / "peers.md").write_text(table)
            write_csv(asked.out / "peers.csv", rows, about)
    except (Disagreement, OSError, subprocess.CalledProcessError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
