"""The results as Markdown and CSV."""

import csv
import io
import os
import platform
import statistics
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

import numpy as np

from programs import crate_version
from rounds import Row, Share

PACKAGES = ("hmmlearn", "scikit-learn", "numpy", "scipy", "mujoco")
CRATES = ("hmmlearn-rs",)


def machine() -> dict[str, str]:
    """The machine, what else it is doing (the load average of the last minute) and the versions."""
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return {"cpu": cpu(), "cores": str(os.cpu_count()), "load": load, "python": platform.python_version()} | {
        package: version(package) for package in PACKAGES} | {crate: crate_version(crate) for crate in CRATES}


def cpu() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def digits(value: float) -> str:
    """Three significant digits, without an exponent."""
    return np.format_float_positional(float(f"{value:.3g}"), trim="-")


def spread(numbers: Iterable[float]) -> str:
    """The median and [least, greatest]."""
    numbers = list(numbers)
    return f"{digits(statistics.median(numbers))} [{digits(min(numbers))}, {digits(max(numbers))}]"


def markdown(rows: list[Row], shares: list[Share], about: dict[str, str], command: str) -> str:
    return "\n".join(peers(rows, about, command) + (peak(shares) if shares else [])) + "\n"


def peers(rows: list[Row], about: dict[str, str], command: str) -> list[str]:
    versions = ", ".join(f"{name} {about[name]}" for name in PACKAGES + CRATES if name != "mujoco")
    lines = [
        "## Peers: other libraries beside the kernels of situ", "",
        f"Made by `{command}`; do not edit.", "",
        f"{about['cpu']}, {about['cores']} cores, load average {about['load']} before; Python {about['python']}, "
        f"{versions}; one thread each. Times are wall-clock medians over the rounds; the ratio, peer over ours, is "
        "taken in each round: its median and [least, greatest]. Agreement is the greatest relative difference between "
        "the values of both; the values of hmmlearn-rs are held against hmmlearn's, for a model without ends. In the "
        "cases of these two, ours also takes the logarithms of rotations, which they do not; `bench/peers/hmm.py` and "
        "`bench/peers/classifiers.py` say how all are the same computation.", "",
        "| case | peer | peer ms | ours ms | ratio | rounds | agreement |",
        "| --- | --- | ---: | ---: | ---: | ---: | --- |",
    ]
    for row in rows:
        agreement = ", ".join(f"{label} {apart:.0e}" for label, apart in row.agreement.items())
        peer, ours = digits(statistics.median(row.peer)), digits(statistics.median(row.ours))
        lines.append(f"| {row.case} | {row.package} {about[row.package]}, {row.way} | {peer} | {ours} "
                     f"| {spread(row.ratios)} | {len(row.ratios)} | {agreement} |")
    return lines


def peak(shares: list[Share]) -> list[str]:
    lines = [
        "", "### The share of the core's peak", "",
        "Operations are the additions, multiplications and divisions of doubles that the computation needs, counted "
        "as `bench/peers/operations.py` says; Gflop/s are a thousand million of them a second of wall-clock time, ours "
        "by the median of a round's runs. The peak is what the core does in the same round where it does nothing but "
        "additions and multiplications, as many of each, in its widest vectors (`bench/examples/peers/peak.rs`), by "
        "the fastest run. Ours never fuses a multiplication with an addition, so that its bits are the same on every "
        "machine; the peak of fused ones stands beside. The median and [least, greatest] over the rounds.", "",
        "| case | operations | ours Gflop/s | peak Gflop/s | share of the peak | fused peak Gflop/s | rounds |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for share in shares:
        percent = spread(100 * part for part in share.shares)
        lines.append(f"| {share.case} | {share.operations} | {spread(share.reached)} | {spread(share.peak)} "
                     f"| {percent} % | {spread(share.fused_peak)} | {len(share.shares)} |")
    return lines


def comma_separated(head: list[str], lines: Iterable[list[object]]) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    table.writerows(lines)
    return text.getvalue()


def peers_csv(rows: list[Row], about: dict[str, str]) -> str:
    """One line for each case, peer and round."""
    head = ["case", "peer", "version", "way", "round", "peer_ms", "ours_ms", "ratio", "agreement", *about]
    lines = []
    for row in rows:
        worst = max(row.agreement.values())
        for index, (peer, ours, ratio) in enumerate(zip(row.peer, row.ours, row.ratios, strict=True), start=1):
            lines.append([row.case, row.package, about[row.package], row.way, index, f"{peer:.6g}", f"{ours:.6g}",
                          f"{ratio:.6g}", f"{worst:.1e}", *about.values()])
    return comma_separated(head, lines)


def peak_csv(shares: list[Share], about: dict[str, str]) -> str:
    """One line for each case and round."""
    head = ["case", "round", "operations", "ours_gflops", "peak_gflops", "share", "fused_peak_gflops", *about]
    lines = []
    for share in shares:
        rounds = zip(share.reached, share.peak, share.shares, share.fused_peak, strict=True)
        for index, rates in enumerate(rounds, start=1):
            numbers = [f"{rate:.6g}" for rate in rates]
            lines.append([share.case, index, share.operations, *numbers, *about.values()])
    return comma_separated(head, lines)
