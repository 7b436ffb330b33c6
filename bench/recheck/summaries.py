"""Statistics of numbers that are given: nothing here is drawn at random."""

import math
from collections.abc import Callable, Sequence

Numbers = Sequence[float]

# The 97.5th percentile of the standard normal distribution.
NORMAL = 1.959963984540054
# Sums that differ by less than this share of the largest one are equal but for rounding.
ROUNDING = 1e-12


def mean(values: Numbers) -> float | None:
    """The arithmetic mean."""
    return math.fsum(values) / len(values) if values else None


def median(values: Numbers) -> float | None:
    """The middle value, or the mean of the two middle ones."""
    ordered, half = sorted(values), len(values) // 2
    if not ordered:
        return None
    return ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2


def quantile(values: Numbers, share: float) -> float | None:
    """The value at this share of the ranks from the least to the greatest, linear between two."""
    if not values:
        return None
    ordered, rank = sorted(values), share * (len(values) - 1)
    below = math.floor(rank)
    above = min(below + 1, len(ordered) - 1)
    return (above - rank) * ordered[below] + (rank - below) * ordered[above] if above > below else ordered[below]


def interquartile_mean(values: Numbers) -> float | None:
    """The mean without the lowest quarter and the highest one, each rounded down."""
    cut = len(values) // 4
    return mean(sorted(values)[cut:len(values) - cut])


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """The Wilson 95 % interval: the roots p of (successes/trials − p)² = z² p (1 − p) / trials."""
    if not trials:
        return 0.0, 1.0
    share, width = successes / trials, NORMAL**2 / trials
    middle, root = 2 * share + width, math.sqrt(width * (4 * share * (1 - share) + width))
    low, high = (middle - root) / (2 * (1 + width)), (middle + root) / (2 * (1 + width))
    return max(0.0, low), min(1.0, high)


def improvement(tasks: Sequence[tuple[Numbers, Numbers]]) -> float | None:
    """The probability that a score of the first is greater than one of the second, ties half, averaged over tasks."""
    shares = []
    for first, second in tasks:
        if not first or not second:
            return None
        won = sum((one > other) + 0.5 * (one == other) for one in first for other in second)
        shares.append(won / (len(first) * len(second)))
    return mean(shares)


def sequence(rates: Sequence[Numbers]) -> tuple[float, float | None, float]:
    """FWT, NBT and AUC of a sequence. `rates[m][n]` is success on stage n after stage m, n at most m."""
    count = len(rates)
    forward = sum(rates[n][n] for n in range(count)) / count
    lost = []
    for n in range(count - 1):
        later = [rates[n][n] - rates[m][n] for m in range(n + 1, count)]
        lost.append(sum(later) / len(later))
    area = sum(sum(rates[m][n] for m in range(n, count)) / (count - n) for n in range(count)) / count
    return forward, mean(lost), area


def holm(p_values: Numbers) -> list[float]:
    """The p-values corrected by Holm: the k-th least of n, times n − k + 1; no less than the one before, at most 1."""
    corrected, least = [0.0] * len(p_values), 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=lambda index: p_values[index])):
        least = min(1.0, max(least, (len(p_values) - rank) * p_values[index]))
        corrected[index] = least
    return corrected


def sign_flip(differences: Numbers) -> float:
    """The share of all sign vectors under which the sum is as far from 0 as it is, or farther."""
    sums = [0.0]
    for difference in differences:
        sums = [total + sign * difference for total in sums for sign in (1, -1)]
    enough = abs(math.fsum(differences)) - ROUNDING * math.fsum(map(abs, differences))
    return sum(abs(total) >= enough for total in sums) / len(sums)


def _incomplete_beta(x: float, a: float, b: float) -> float:
    """The regularised incomplete beta function, by its continued fraction (Lentz's method)."""
    if x <= 0 or x >= 1:
        return float(x >= 1)
    if x > (a + 1) / (a + b + 2):
        return 1 - _incomplete_beta(1 - x, b, a)
    logs = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    tiny = 1e-300
    c, d = 1.0, 1 / (1 - (a + b) * x / (a + 1))
    fraction = d
    for m in range(1, 500):
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1 / (1 + term * d or tiny)
            c = 1 + term / c or tiny
            fraction *= c * d
        if abs(c * d - 1) < 1e-16:
            break
    return math.exp(logs) * fraction / a


def bisect(low: float, high: float, is_below: Callable[[float], bool]) -> float:
    """Where a condition that holds from `low` on no longer holds, to the last bit."""
    for _ in range(200):
        middle = (low + high) / 2
        if is_below(middle):
            low = middle
        else:
            high = middle
    return (low + high) / 2


def student(freedom: int) -> float:
    """The 97.5th percentile of Student's distribution."""

    def tail(t: float) -> float:
        return _incomplete_beta(freedom / (freedom + t * t), freedom / 2, 0.5) / 2

    return bisect(0.0, 1e4, lambda t: tail(t) > 0.025)


def power_law(points: Sequence[tuple[float, float]]) -> tuple[float, float, float] | None:
    """The least-squares line of ln y over ln x: slope, half its 95 % interval, and intercept.

    Nothing where there are fewer than three points, a coordinate is not above 0, or all x are one.
    """
    if len(points) < 3 or any(x <= 0 or y <= 0 for x, y in points):
        return None
    logs, n = [(math.log(x), math.log(y)) for x, y in points], len(points)
    x, y = (math.fsum(part) / n for part in zip(*logs))
    spread = math.fsum((one - x) ** 2 for one, _ in logs)
    if spread == 0:
        return None
    slope = math.fsum((one - x) * (other - y) for one, other in logs) / spread
    left = math.fsum((other - y - slope * (one - x)) ** 2 for one, other in logs)
    return slope, student(n - 2) * math.sqrt(left / (n - 2) / spread), y - slope * x
