"""What a bootstrap may say: the distribution of a statistic over resamples, and the percentiles that chance can give.

A published percentile is that of 2000 resamples by a generator that we do not have. Where few resamples differ, the
distribution is gone through whole, and the percentile must lie between quantiles of it that the order statistics of
2000 draws leave with a probability of `ERROR` at the most; and it must be a value that resamples have, or lie between
two of them as the rule of interpolation says. Where many differ, it must lie between order statistics of our own draws
that those of 2000 others leave with no greater probability.
"""

import itertools
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Generic, TypeVar

import summaries

T = TypeVar("T")

# Resamples of a published interval, and the tail that its end leaves out.
PUBLISHED = 2000
TAIL = 0.025
# Sign vectors that a published p-value is drawn of, where there are more than `WHOLE_FLIPS` units.
PUBLISHED_FLIPS = 100_000
WHOLE_FLIPS = 16
# Our own draws, and the number of resamples up to which all are gone through.
OWN = 4000
OWN_FLIPS = 20_000
WHOLE = 2000
# The probability of an error, for each value that was drawn.
ERROR = 1e-6
# The seed of our own draws.
SEED = 23
# Half a unit of the last of six decimals, and some rounding.
HALF = 0.5e-6 * (1 + 1e-6)


@dataclass(frozen=True)
class Statistic(Generic[T]):
    """A statistic of things: `part` is what a cluster of them adds, `whole` the statistic of such parts."""

    part: Callable[[Sequence[T]], Any]
    whole: Callable[[Sequence[Any]], float | None]


def near(one: float, other: float) -> bool:
    """Whether a number printed with six decimals is the other."""
    return abs(one - other) <= HALF + 1e-13 * abs(other)


@cache
def _ways(strata: tuple[int, ...]) -> int:
    return math.prod(math.comb(2 * size - 1, size) for size in strata)


@cache
def _all_resamples(strata: tuple[int, ...]) -> list[tuple[tuple[int, ...], float]]:
    """Every resample of these strata, and its probability."""
    found: list[tuple[tuple[int, ...], float]] = [((), 1.0)]
    first = 0
    for size in strata:
        own = []
        for drawn in itertools.combinations_with_replacement(range(first, first + size), size):
            ways = math.factorial(size)
            for one in set(drawn):
                ways //= math.factorial(drawn.count(one))
            own.append((drawn, ways / size**size))
        found = [(before + drawn, p * q) for before, p in found for drawn, q in own]
        first += size
    return found


@cache
def _some_resamples(strata: tuple[int, ...]) -> list[tuple[tuple[int, ...], float]]:
    """Resamples of these strata, drawn by a generator of our own."""
    generator, found = random.Random(SEED), []
    for _ in range(OWN):
        drawn: list[int] = []
        for size in strata:
            first = len(drawn)
            drawn.extend(first + generator.randrange(size) for _ in range(size))
        found.append((tuple(drawn), 1 / OWN))
    return found


def _log_choose(n: float, k: float) -> float:
    return math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1)


def _fewer(rank: int, of: int, share: float) -> float:
    """The probability that fewer than `rank` of `of` draws are in a set that has this share."""
    if share <= 0 or share >= 1:
        return float(share <= 0)
    return math.fsum(
        math.exp(_log_choose(of, k) + k * math.log(share) + (of - k) * math.log1p(-share)) for k in range(rank)
    )


@cache
def _shares(of: int, error: float) -> tuple[float, float]:
    """The shares between which the percentile of `of` draws is, but for errors of this probability."""
    first, second = _ranks(of)
    low = summaries.bisect(0.0, first / of, lambda share: 1 - _fewer(first, of, share) < error / 2)
    high = summaries.bisect(second / of, 1.0, lambda share: _fewer(second, of, share) > error / 2)
    return low, high


def _ranks(of: int) -> tuple[int, int]:
    """The ranks, from 1, of the two of `of` sorted draws that the lower percentile is between."""
    first = math.floor(TAIL * (of - 1)) + 1
    return first, min(first + 1, of)


@cache
def _own_below(rank: int, of: int, own: int) -> list[float]:
    """The probability that at most k of `own` draws lie below the `rank`-th least of `of` others, for each k.

    The number of those is beta-binomial.
    """
    constant = math.lgamma(of + 1) - math.lgamma(rank) - math.lgamma(of + 1 - rank) - math.lgamma(own + of + 1)
    each = (
        math.exp(constant + _log_choose(own, k) + math.lgamma(k + rank) + math.lgamma(own - k + of + 1 - rank))
        for k in range(own + 1)
    )
    return list(itertools.accumulate(each))


@cache
def _own_ranks(of: int, own: int, error: float) -> tuple[int, int]:
    """How many of `own` draws are below the percentile of `of` others, at the least and at the most, but for errors."""
    first, second = (_own_below(rank, of, own) for rank in _ranks(of))
    least = next(k for k, below in enumerate(first) if below > error / 2)
    most = next(k for k, below in enumerate(second) if below >= 1 - error / 2)
    return least, most


@dataclass(frozen=True)
class Verdict:
    """What is found of a drawn value: what is accepted, whether it is, and how likely one is that is as far off."""

    accepted: str
    is_accepted: bool
    probability: float


class Distribution(Generic[T]):
    """The distribution of a statistic over resamples of clusters of things, each stratum drawn for itself."""

    def __init__(self, clusters: Sequence[Sequence[T]], strata: Sequence[int], statistic: Statistic[T]) -> None:
        self._parts = [statistic.part(cluster) for cluster in clusters]
        self._strata = tuple(strata)
        self._whole = statistic.whole
        self.is_whole = _ways(self._strata) <= WHOLE

    @cached_property
    def _values(self) -> list[tuple[float, float]]:
        """The values that the statistic has, from low to high, each with the probability of this one or a lower."""
        resamples = _all_resamples(self._strata) if self.is_whole else _some_resamples(self._strata)
        parts, found = self._parts, []
        for drawn, probability in resamples:
            value = self._whole([parts[index] for index in drawn])
            if value is not None:
                found.append((value, probability))
        found.sort()
        self._valid = math.fsum(probability for _, probability in found)
        below, values = 0.0, []
        for value, probability in found:
            below += probability / self._valid
            values.append((value, below))
        return values

    def _published(self) -> set[int]:
        """How many resamples the published percentile may be of: those of which the statistic is none are left out."""
        if self._valid > 1 - 1e-12:
            return {PUBLISHED}
        spread = 6 * math.sqrt(PUBLISHED * self._valid * (1 - self._valid)) + 20
        middle = PUBLISHED * self._valid
        return {max(1, math.floor(middle - spread)), min(PUBLISHED, math.ceil(middle + spread))}

    def _window(self, upper: bool) -> tuple[float, float]:
        """The bounds of what the percentile may be. The upper one is the lower one, counted from above."""
        values = self._values
        lows, highs = [], []
        for of in self._published():
            if self.is_whole:
                low, high = _shares(of, ERROR)
                low, high = (1 - high, 1 - low) if upper else (low, high)
                lows.append(self._at(low))
                highs.append(self._at(high))
            else:
                own = len(values)
                least, most = _own_ranks(of, own, ERROR)
                least, most = (own - most, own - least) if upper else (least, most)
                lows.append(values[least - 1][0] if least >= 1 else -math.inf)
                highs.append(values[most][0] if most < own else math.inf)
        return min(lows), max(highs)

    def _at(self, share: float) -> float:
        for value, below in self._values:
            if below >= share - 1e-12:
                return value
        return self._values[-1][0]

    def _probability(self, value: float, upper: bool) -> float:
        """The probability, two-sided, that the percentile of what was published is as far off as this value."""
        less = max((below for one, below in self._values if one < value - HALF), default=0.0)
        no_more = max((below for one, below in self._values if one <= value + HALF), default=0.0)
        if upper:
            less, no_more = 1 - no_more, 1 - less
        found = []
        for of in self._published():
            first, second = _ranks(of)
            if self.is_whole:
                found.append((1 - _fewer(first, of, no_more), _fewer(second, of, less)))
            else:
                own = len(self._values)
                fewer = _own_below(second, of, own)
                at = round(less * own)
                found.append((_own_below(first, of, own)[round(no_more * own)], 1 - fewer[at - 1] if at else 1.0))
        return min(1.0, 2 * min(max(low for low, _ in found), max(high for _, high in found)))

    def _can_be(self, value: float, low: float, high: float, upper: bool) -> bool:
        """Whether resamples have this value, or two of them that it lies between."""
        if not self.is_whole or self._published() != {PUBLISHED}:
            return True
        there = sorted({one for one, _ in self._values if low <= one <= high})
        if any(near(value, one) for one in there):
            return True
        rank = (1 - TAIL if upper else TAIL) * (PUBLISHED - 1)
        share = rank - math.floor(rank)
        return any(near(value, one + share * (other - one)) for one, other in itertools.combinations(there, 2))

    def judge(self, value: float, upper: bool) -> Verdict:
        """Whether a published percentile, the lower end of an interval or the upper one, may be."""
        low, high = self._window(upper)
        inside = low - HALF <= value <= high + HALF and self._can_be(value, low, high, upper)
        kind = "a value or a step between two" if self.is_whole else "any value"
        return Verdict(f"{kind} from {low:.6f} to {high:.6f}", inside, self._probability(value, upper))


@dataclass(frozen=True)
class FlipTest:
    """A sign-flip test: its p-value and the least that it could be; where it is drawn, what it may be instead."""

    p: float
    least: float
    low: float
    high: float
    is_drawn: bool


def _drawn_p(found: int) -> float:
    """The p-value where so many of the published sign vectors are as far from 0: the observed one is among them."""
    return (found + 1) / (PUBLISHED_FLIPS + 1)


def _few(draws: int, found: int, other_draws: int, other_found: int) -> float:
    """The probability of `found` or fewer in these draws, all that were found being spread by chance: Fisher's test."""
    both, tail = found + other_found, 0.0
    for k in range(found, max(0, both - other_draws) - 1, -1):
        logs = _log_choose(draws, k) + _log_choose(other_draws, both - k) - _log_choose(draws + other_draws, both)
        tail += math.exp(logs)
        if math.exp(logs) < 1e-12 * tail:
            break
    return tail


def flip_test(differences: Sequence[float]) -> FlipTest:
    """The two-sided sign-flip test of these differences, one of each unit. Those that are 0, but for rounding, decide nothing."""
    rounding = summaries.ROUNDING * max(map(abs, differences), default=0)
    differences = [one for one in differences if abs(one) > rounding]
    if not differences:
        return FlipTest(1.0, 1.0, 1.0, 1.0, False)
    if len(differences) <= WHOLE_FLIPS:
        p = summaries.sign_flip(differences)
        return FlipTest(p, 2 / 2 ** len(differences), p, p, False)
    generator = random.Random(SEED)
    enough = abs(math.fsum(differences)) - summaries.ROUNDING * math.fsum(map(abs, differences))
    own = 0
    for _ in range(OWN_FLIPS):
        signs = generator.getrandbits(len(differences))
        total = sum(one if signs >> k & 1 else -one for k, one in enumerate(differences))
        own += abs(total) >= enough

    def is_too_few(found: int) -> bool:
        return _few(PUBLISHED_FLIPS, found, OWN_FLIPS, own) < ERROR / 2

    def is_too_many(found: int) -> bool:
        return _few(OWN_FLIPS, own, PUBLISHED_FLIPS, found) < ERROR / 2

    expected = own * PUBLISHED_FLIPS // OWN_FLIPS
    least, most = _first(0, expected, lambda k: not is_too_few(k)), _first(expected, PUBLISHED_FLIPS + 1, is_too_many)
    return FlipTest(_drawn_p(expected), 1 / (PUBLISHED_FLIPS + 1), _drawn_p(least), _drawn_p(most - 1), True)


def _first(low: int, high: int, holds: Callable[[int], bool]) -> int:
    """The first number from `low` on for which a condition holds, as it does from there on; `high` where none is."""
    while low < high:
        middle = (low + high) // 2
        if holds(middle):
            high = middle
        else:
            low = middle + 1
    return low
