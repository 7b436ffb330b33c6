"""Times other libraries beside the kernels of situ, on the same numbers and in the same minute.

    python3.11 -m venv VENV && VENV/bin/pip install -r bench/peers/requirements.txt
    VENV/bin/python bench/peers/peers.py --out results/peers

The libraries are hmmlearn, the crate hmmlearn-rs, scikit-learn, numpy and MuJoCo. Each case makes its numbers from a
seed. The Rust sides (bench/examples/peers, and bench/peers/hmmlearn_rs for the crate) read them from files. First all
sides compute the case once and their values must agree; otherwise the script names the first number that does not and
ends with exit status 1. Then they take turns, the peers and ours, for some rounds, each on one thread; a round's
time is the
median of its runs, and its ratio is the peer's time over ours. Where a peer has several ways to the same values, all
are checked, and the fastest of them is timed. For the fit of 500 sequences, the same rounds also measure the peak of
the core.

hmm.py and classifiers.py are the cases and say how all sides are the same computation; operations.py counts what a fit
needs.

The cases named physics-… are scenes of rigid bodies, in MuJoCo and in our world. There are no values in which both
must agree, so physics.py holds figures of both against limits: what overlaps, slips, drifts and gains energy.
"""

import os

# This stands before the import of numpy, because numpy's libraries read these variables once.
for _pool in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMEXPR", "VECLIB_MAXIMUM", "RAYON"):
    os.environ[f"{_pool}_NUM_THREADS"] = "1"

import argparse
import logging
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import physics
import physics_table
import table
from cases import Case
from classifiers import regress_case, screen_case
from hmm import fit_case, score_case
from programs import Program, ProgramFailed, Programs, built_hmmlearn_rs, built_ours
from rounds import Row, Share, run
from values import Disagreement

CASES: dict[str, Callable[[Programs], Case]] = {
    "fit-20": partial(fit_case, 20, False),
    "fit-500": partial(fit_case, 500, True),
    "score-100": partial(score_case, 10, 100, 10),
    "score-1000": partial(score_case, 10, 1000, 10),
    "logistic-50": partial(regress_case, 50, 13, 0.8),
    "logistic-5000": partial(regress_case, 5000, 40, 0.2),
    "screen-13": partial(screen_case, 10_000, 13),
    "screen-80": partial(screen_case, 10_000, 80),
}
SLOW = {"score-1000"}
"""Cases that run only where they are asked for: hmmlearn takes most of a minute for one run."""

PHYSICS = {f"physics-{name}": name for name in physics.SCENES}
ON_PAPER = "physics-on-paper"
"""Scenes whose course is known without a computer. They are not timed."""


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path,
                        help="folder for peers, peak and physics, as .md and .csv (default: only print the tables)")
    parser.add_argument("--binary", type=Path, help="the built example `peers` (default: build it by cargo)")
    parser.add_argument("--hmmlearn-rs", type=Path,
                        help="the built program of bench/peers/hmmlearn_rs (default: build it by cargo)")
    parser.add_argument("--rounds", type=int, default=7, help="turns of peer and ours a case (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=0.1,
                        help="each side's runs in a round take this long together (default: %(default)s)")
    parser.add_argument("--case", action="append", choices=[*CASES, *PHYSICS, ON_PAPER],
                        help=f"only this case; can be repeated (default: all but {', '.join(sorted(SLOW))})")
    asked = parser.parse_args()
    if asked.rounds < 1:
        parser.error("--rounds must be at least 1")
    return asked


def measure(asked: argparse.Namespace, programs: Programs) -> tuple[list[Row], list[Share]]:
    """The kernels of situ and their peers."""
    rows, shares = [], []
    for name in asked.case or CASES:
        if name not in CASES or (name in SLOW and not asked.case):
            continue
        of_case, share = run(CASES[name](programs), programs, asked.rounds, asked.seconds)
        rows += of_case
        shares += [share] if share else []
        for row in of_case:
            print(f"{name}: {row.package} {table.digits(statistics.median(row.ratios))} ×", file=sys.stderr)
    return rows, shares


def write(out: Path, texts: dict[str, str]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (out / name).write_text(text)


def main() -> int:
    asked = arguments()
    # hmmlearn warns where the likelihood falls. Only the sum of likelihood and log prior must climb.
    logging.getLogger("hmmlearn").setLevel(logging.ERROR)
    command = "python bench/peers/peers.py --out results/peers"
    try:
        binaries = asked.binary or built_ours(), asked.hmmlearn_rs or built_hmmlearn_rs()
        about = table.machine()
        with tempfile.TemporaryDirectory() as folder:
            programs = Programs(*(Program(binary.resolve(), Path(folder)) for binary in binaries))
            rows, shares = measure(asked, programs)
            scenes = [physics.run(scene, programs.ours, asked.rounds, asked.seconds)
                      for name, scene in PHYSICS.items() if name in (asked.case or PHYSICS)]
            known = physics.oracles(programs.ours) if ON_PAPER in (asked.case or [ON_PAPER]) else []
        texts = {}
        if rows:
            texts |= {"peers.md": table.markdown(rows, shares, about, command),
                      "peers.csv": table.peers_csv(rows, about), "peak.csv": table.peak_csv(shares, about)}
        if scenes or known:
            texts |= {"physics.md": physics_table.markdown(scenes, known, about, command),
                      "physics.csv": physics_table.times(scenes, about),
                      "physics_figures.csv": physics_table.figures(scenes, known, about)}
        print("\n".join(text for name, text in texts.items() if name.endswith(".md")), end="")
        if asked.out:
            write(asked.out, texts)
    except (Disagreement, ProgramFailed, OSError, subprocess.CalledProcessError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
