"""All sides of a case, in turns."""

from dataclasses import dataclass

from cases import Case, Measure, Peer, Way
from programs import Programs
from values import compare


@dataclass(frozen=True)
class Row:
    """The results of a case for one peer. Times are milliseconds, one for each round."""

    case: str
    package: str
    way: str
    peer: list[float]
    ours: list[float]
    agreement: dict[str, float]

    @property
    def ratios(self) -> list[float]:
        return [peer / ours for peer, ours in zip(self.peer, self.ours, strict=True)]


@dataclass(frozen=True)
class Share:
    """The share of the core's peak that our side of a case reached. Rates are operations per nanosecond, one a round."""

    case: str
    operations: int
    reached: list[float]
    peak: list[float]
    """The peak of multiplications and additions, each by itself."""
    fused_peak: list[float]

    @property
    def shares(self) -> list[float]:
        return [reached / peak for reached, peak in zip(self.reached, self.peak, strict=True)]


def run(case: Case, programs: Programs, rounds: int, seconds: float) -> tuple[list[Row], Share | None]:
    """Checks the values of all sides, then times them in turns. Raises `Disagreement`."""
    chosen = [fastest(case, peer, seconds) for peer in case.peers]
    count = case.count() if case.count else None
    peer_times: list[list[float]] = [[] for _ in case.peers]
    our_times: list[float] = []
    run_peaks = [programs.ours.measure({"peak": {"fused": fused}}) for fused in (False, True)] if count else []
    peaks: list[list[float]] = [[] for _ in run_peaks]
    for _ in range(rounds):
        for (way, _), times in zip(chosen, peer_times, strict=True):
            times.append(way.measure(seconds).milliseconds)
        our_times.append(case.ours(seconds).milliseconds)
        for run_peak, rates in zip(run_peaks, peaks, strict=True):
            rates.append(rate(run_peak, seconds))
    rows = [Row(case.name, peer.package, way.name, times, our_times, agreement)
            for peer, (way, agreement), times in zip(case.peers, chosen, peer_times, strict=True)]
    if not count:
        return rows, None
    operations = count.operations()
    reached = [operations / (1e6 * time) for time in our_times]
    return rows, Share(case.name, operations, reached, *peaks)


def fastest(case: Case, peer: Peer, seconds: float) -> tuple[Way, dict[str, float]]:
    """The way of the peer that is fastest now, and the greatest differences by label of all its ways."""
    if peer.expected:
        sides, expected = (peer.package, "hmmlearn"), peer.expected()
    else:
        sides, expected = ("ours", peer.package), case.ours(0.0).values()
    trials: dict[str, float] = {}
    agreement: dict[str, float] = {}
    for way in peer.ways:
        measured = way.measure(seconds)
        trials[way.name] = measured.milliseconds
        # Where the peer is the reference for ours, its values are the expected ones.
        found, right = (measured.values(), expected) if peer.expected else (expected, measured.values())
        for label, apart in compare(f"{case.name} ({way.name})", sides, found, right).items():
            agreement[label] = max(apart, agreement.get(label, 0.0))
    return min(peer.ways, key=lambda way: trials[way.name]), agreement


def rate(peak: Measure, seconds: float) -> float:
    """Operations per nanosecond in the fastest run, which was disturbed least."""
    measured = peak(seconds)
    return float(measured.values()["operations"][0]) / (1e6 * min(measured.runs))
