"""The numbers that two sides computed, and how near to each other they must be."""

from dataclasses import dataclass

import numpy as np

Values = dict[str, np.ndarray]


class Disagreement(Exception):
    """A number of one side differs from that of the other."""


@dataclass(frozen=True)
class Tolerance:
    """How near two numbers must be: relative to the greater of the expected one and `scale`, a typical one.

    Without a scale, relative to the greatest of those expected.
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
    "passing": Tolerance("passing", 0.0),
}


def compare(case: str, sides: tuple[str, str], found: Values, expected: Values) -> dict[str, float]:
    """The greatest relative difference by label. Raises `Disagreement` at the first number that is too far off.

    `sides` names who found and who expected.
    """
    finder, expecter = sides
    if found.keys() != expected.keys():
        raise Disagreement(f"{case}: {finder} has {sorted(found)}, {expecter} {sorted(expected)}")
    agreement: dict[str, float] = {}
    for name, right in expected.items():
        right, given, tolerance = np.ravel(right), np.ravel(found[name]), TOLERANCES[name]
        if given.shape != right.shape:
            raise Disagreement(f"{case}: {name}: {finder} has {given.size} numbers, {expecter} {right.size}")
        scale = np.abs(right).max() if tolerance.scale is None else tolerance.scale
        apart = np.abs(given - right) / np.maximum(np.abs(right), scale)
        # This form of the condition is false for NaN, which is then too far off.
        for index in np.flatnonzero(~(apart <= tolerance.relative))[:1]:
            raise Disagreement(f"{case}: {name} {index}: {finder} has {given[index]}, {expecter} {right[index]}, "
                               f"apart by {apart[index]:.1e} where {tolerance.relative:.0e} is allowed")
        agreement[tolerance.label] = max(agreement.get(tolerance.label, 0.0), float(apart.max()))
    return agreement
