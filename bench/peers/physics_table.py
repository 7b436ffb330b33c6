"""The scenes of rigid bodies as Markdown and CSV."""

import math
import statistics

import table
from physics import PLAIN, Oracle, Result, Trial, limits


def short(value: float | None) -> str:
    """Three significant digits; what is below a thousandth is told as such."""
    if value is None or not math.isfinite(value):
        return "–"
    if value != 0 and abs(value) < 1e-3:
        return "< 0.001"
    return table.digits(value)


def line(names: list[str], values: list[float | None]) -> str:
    return f"| {' | '.join([*names, *map(short, values)])} |"


def markdown(scenes: list[Result], known: list[Oracle], about: dict[str, str], command: str) -> str:
    lines = [
        "## Physics: MuJoCo beside our world", "", f"Made by `{command}`; do not edit.", "",
        f"{about['cpu']}, {about['cores']} cores, load average {about['load']} before; Python {about['python']}, "
        f"mujoco {about['mujoco']}; one thread each. The same scenes, dimensions, masses, friction, motions and "
        "simulated seconds; MuJoCo with our step of 1/240 s and with its own of 2 ms, by the fastest of its ways that "
        "gets the scene right. Ours is the world as the tasks use it, its hand always there and always awake; MuJoCo "
        "has a hand only where one is needed. Both put away what rests, MuJoCo after 10 steps below 1 mm/s, ours later. "
        "So a phase that nothing disturbs shows what rest costs, and one in which something is moved shows what "
        "contacts cost. `bench/peers/physics.py` says how, `bench/peers/mujoco_world.py` what differs.", "",
    ]
    if scenes:
        lines += timed(scenes) + ahead(scenes) + compared(scenes)
    if known:
        lines += on_paper(known)
    if scenes:
        lines += tried(scenes)
    return "\n".join(lines) + "\n"


def timed(scenes: list[Result]) -> list[str]:
    lines = [
        "### Time", "",
        "Times are wall-clock medians over the rounds; the ratio, MuJoCo over ours, is taken in each round: its median "
        "and [least, greatest]. Above 1, ours is faster.", "",
        "| scene | phase | simulated s | MuJoCo | MuJoCo ms | ours ms | ratio | ours, × real time | rounds |",
        "| --- | --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for scene in scenes:
        for phase, seconds, row in scene.rows:
            peer, ours = statistics.median(row.peer), statistics.median(row.ours)
            way = row.way if chosen(scene, row.way).right else f"{row.way} (no way gets it right)"
            lines.append(f"| {scene.scene.title} | {phase} | {table.digits(seconds)} | {way} | {table.digits(peer)} "
                         f"| {table.digits(ours)} | {table.spread(row.ratios)} | {table.digits(1e3 * seconds / ours)} "
                         f"| {len(row.ratios)} |")
    return [*lines, ""]


def chosen(scene: Result, way: str) -> Trial:
    return next(trial for trial in scene.chosen if trial.way.name == way)


def ahead(scenes: list[Result]) -> list[str]:
    """Where MuJoCo is ahead, in words."""
    faster = [f"{scene.scene.title}, {phase} ({row.way}, {table.digits(statistics.median(row.ratios))})"
              for scene in scenes for phase, _, row in scene.rows if statistics.median(row.ratios) < 1]
    better = []
    for scene in scenes:
        for name in limits(scene.scene.name):
            least = min(trial.figures[name] for trial in scene.chosen)
            if least < 0.99 * scene.ours[name] and short(least) != short(scene.ours[name]):
                better.append(f"{scene.scene.title}: {name} ({short(least)} against {short(scene.ours[name])})")
    return [f"MuJoCo is the faster in: {'; '.join(faster) or 'none of these'}.", "",
            f"MuJoCo is nearer to what is right in: {'; '.join(better) or 'none of these'}.", ""]


def compared(scenes: list[Result]) -> list[str]:
    lines = [
        "### What each gets right", "",
        "Made of poses, by the same code for all (`bench/peers/figures.py`). A figure without a limit only describes.",
        "",
        "| scene | figure | MuJoCo, 1/240 s | MuJoCo, 2 ms | ours | limit |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for scene in scenes:
        for name, ours in scene.ours.items():
            peers = [trial.figures[name] for trial in scene.chosen]
            lines.append(line([scene.scene.title, name], [*peers, ours, limits(scene.scene.name).get(name)]))
    return [*lines, ""]


def on_paper(known: list[Oracle]) -> list[str]:
    lines = [
        "### What is known on paper", "",
        "MuJoCo with elliptic cones and Newton's method. Falling in steps adds up to half a step's way at the last "
        "speed; nothing is to rebound.", "",
        "| figure | paper | MuJoCo, 1/240 s | MuJoCo, 2 ms | ours |", "| --- | ---: | ---: | ---: | ---: |",
    ]
    for oracle in known:
        lines.append(line([oracle.name], [oracle.paper, *oracle.peers, oracle.ours]))
    return [*lines, ""]


def tried(scenes: list[Result]) -> list[str]:
    lines = [
        "### MuJoCo's ways, each tried once", "",
        "Milliseconds of all timed phases together, recording included. A way that takes about a third longer than one "
        "that is right is given up. `physics_figures.csv` has the figures of all that were not.", "",
        "| scene | gets it right, ms | gets it wrong: first figure beyond its limit | given up |",
        "| --- | --- | --- | ---: |",
    ]
    for scene in scenes:
        right = [f"{trial.way.name}: {short(trial.milliseconds)}" for trial in scene.trials if trial.right]
        wrong = [f"{trial.way.name}: {trial.beyond} ({short(trial.figures[trial.beyond])})"
                 for trial in scene.trials if trial.figures and not trial.right]
        given_up = sum(not trial.figures for trial in scene.trials)
        lines.append(f"| {scene.scene.title} | {'; '.join(right) or '–'} | {'; '.join(wrong) or '–'} | {given_up} |")
    return lines


def times(scenes: list[Result], about: dict[str, str]) -> str:
    """One line for each scene, phase, way and round."""
    head = ["scene", "phase", "simulated_s", "way", "right", "round", "mujoco_ms", "ours_ms", "ratio", *about]
    lines = []
    for scene in scenes:
        for phase, seconds, row in scene.rows:
            right = "yes" if chosen(scene, row.way).right else "no"
            for index, (peer, ours, ratio) in enumerate(zip(row.peer, row.ours, row.ratios, strict=True), start=1):
                lines.append([scene.scene.name, phase, f"{seconds:.6g}", row.way, right, index, f"{peer:.6g}",
                              f"{ours:.6g}", f"{ratio:.6g}", *about.values()])
    return table.comma_separated(head, lines)


def figures(scenes: list[Result], known: list[Oracle], about: dict[str, str]) -> str:
    """One line for each scene, side and figure. For what is known on paper, the limit is what is so."""
    lines = []
    for scene in scenes:
        sides = [("ours", scene.ours), *((trial.way.name, trial.figures) for trial in scene.trials)]
        for side, of_side in sides:
            for name, value in of_side.items():
                limit = limits(scene.scene.name).get(name, "")
                lines.append([scene.scene.name, side, name, f"{value:.6g}", limit, about["mujoco"]])
    for oracle in known:
        names = ("ours", *(way.name for way in PLAIN))
        sides = zip(names, (oracle.ours, *oracle.peers), strict=True)
        lines += [["on paper", side, oracle.name, f"{value:.6g}", f"{oracle.paper:.6g}", about["mujoco"]]
                  for side, value in sides]
    return table.comma_separated(["scene", "side", "figure", "value", "limit_or_paper", "mujoco"], lines)
