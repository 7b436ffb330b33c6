"""Ratios of sums over runs, each with its 95 % interval by units: families and seeds, drawn again within families."""

import random
from collections.abc import Sequence

from ledger import Run
from measures import grouped

RESAMPLES = 2000
SEED = 23

# What a run adds to the two sums of a ratio.
Terms = tuple[float, float]


def quotient(of: Sequence[Terms]) -> float | None:
    """The ratio of the sums."""
    below = sum(one[1] for one in of)
    return sum(one[0] for one in of) / below if below else None


def interval(known: Sequence[tuple[Run, Terms]]) -> tuple[float, float] | None:
    """The 2.5th and the 97.5th percentile of the ratio over resamples of units; none where no family has two units."""
    units = grouped((run.unit(), terms) for run, terms in known)
    families = list(grouped((unit[0], unit) for unit in units).values())
    if all(len(family) == 1 for family in families):
        return None
    generator, drawn = random.Random(SEED), []
    for _ in range(RESAMPLES):
        chosen = [generator.choice(family) for family in families for _ in family]
        found = quotient([one for unit in chosen for one in units[unit]])
        drawn += [] if found is None else [found]
    if not drawn:
        return None
    drawn.sort()
    return drawn[round(0.025 * (len(drawn) - 1))], drawn[round(0.975 * (len(drawn) - 1))]


def ratio(known: Sequence[tuple[Run, Terms]]) -> str:
    """The ratio and its interval, if it has one, or a dash where there is no ratio."""
    middle, ends = quotient([terms for _, terms in known]), interval(known)
    if middle is None:
        return "–"
    return f"{middle:.2f}" if ends is None else f"{middle:.2f} [{ends[0]:.2f}, {ends[1]:.2f}]"
