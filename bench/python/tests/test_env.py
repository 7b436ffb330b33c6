"""The tasks as environments of Gymnasium, each of them; skipped where gymnasium or the program is not there."""

import gc
import json
import math
import os
import pathlib
import subprocess
import sys
import time
import warnings
from collections import Counter

import pytest

ROOT = pathlib.Path(__file__).parents[1]
BUILT = ROOT.parents[1] / "target/release/situ-bench"

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium is not installed: no environment is tested")
np = pytest.importorskip("numpy", reason="numpy is not installed: no environment is tested")
if "SITU_BENCH" not in os.environ and BUILT.is_file():
    os.environ["SITU_BENCH"] = str(BUILT)

from gymnasium.utils.env_checker import check_env  # noqa: E402

from situ_bench.client import Client, ServeError, find_program  # noqa: E402

try:
    find_program()
except ServeError as why:
    pytest.skip(f"no environment is tested: {why}", allow_module_level=True)

import situ_bench  # noqa: E402
from situ_bench.env import Env, register_all  # noqa: E402

NAMES = register_all()
ORIGINALS = [
    "bread_box", "clear_table", "drawer", "lunch", "pour", "press", "scoop", "sort_blocks", "stack",
]
#: Seeds from which the scripted policy tries each original.
SEEDS = range(5)
#: Seconds in which all environments are checked, on a machine that has other things to do besides.
PATIENCE = 300.0


def same(one, other) -> bool:
    """Whether two observations, with what is beside them, are equal in all bits."""
    return one[0].tobytes() == other[0].tobytes() and one[1:] == other[1:]


@pytest.fixture
def env():
    made = Env("stack", "bump")
    yield made
    made.close()


def test_every_family_and_variation_is_registered() -> None:
    assert len(NAMES) == len(set(NAMES)) > 30
    assert {f"situ_bench/{task}-v1" for task in ORIGINALS} <= set(NAMES) <= set(gymnasium.registry)
    assert "situ_bench/pour-lid-v1" in NAMES
    made = gymnasium.make("situ_bench/pour-lid-v1")
    assert (made.unwrapped.task, made.unwrapped.variation) == ("pour", "lid")
    made.close()
    assert situ_bench.Env is Env and not hasattr(situ_bench, "Nothing")


def test_gymnasium_finds_nothing_wrong_with_any_of_them() -> None:
    begun = time.monotonic()
    for name in NAMES:
        # Small pictures: Gymnasium looks at one of each.
        made = gymnasium.make(name, size=(64, 40))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # Metres, radians and a share are what a step is about: no box of them is symmetric.
            warnings.filterwarnings("ignore", message=".*we recommend using a symmetric and normalized space")
            check_env(made.unwrapped)
        made.close()
    seconds = time.monotonic() - begun
    print(f"check_env: {len(NAMES)} environments in {seconds:.1f} s")
    assert seconds < PATIENCE


@pytest.mark.parametrize("task", ORIGINALS)
def test_a_random_policy_runs_to_an_end(task: str) -> None:
    made = Env(task)
    made.action_space.seed(1)
    made.reset(seed=0)
    ends: Counter = Counter()
    over = False
    while not over:
        observation, reward, terminated, truncated, info = made.step(made.action_space.sample())
        assert made.observation_space.contains(observation)
        assert reward == float(terminated) == float(info["solved"])
        assert (info["abort"] is None) == (info["end"] in ("reached", "guarded"))
        ends[info["end"]] += 1
        over = terminated or truncated
    print(f"random policy on {task}: {dict(ends)}")
    assert ends["reached"] > ends.total() / 4
    assert info["seconds"] > made.limit["seconds"] or info["keyframes"] == made.limit["keyframes"]
    with pytest.raises(ServeError, match="the episode is over"):
        made.step(made.action_space.sample())
    made.close()


def test_an_abort_ends_an_episode_where_that_is_wanted() -> None:
    below = np.array([0.5, -0.5, 0.0, math.pi, 0.0, 0.0, 0.5])
    for ends_at_abort in (False, True):
        made = Env("press", ends_at_abort=ends_at_abort)
        before, _ = made.reset(seed=0)
        observation, _, terminated, truncated, info = made.step(below)
        assert info["abort"] in ("out of reach", "no plan") and not terminated
        assert truncated == ends_at_abort and observation.tobytes() == before.tobytes(), "nothing has moved"
        made.close()


def test_the_teachers_keyframes_solve_the_originals() -> None:
    solved = {}
    # One place of *lunch* is 2.5 cm beyond the positions of an action.
    within = [task for task in ORIGINALS if task != "lunch"]
    for task in within:
        made, solved[task] = Env(task), 0
        for seed in SEEDS:
            made.reset(seed=seed)
            terminated = truncated = False
            for action in made.actions(made.demonstrate()):
                assert made.action_space.contains(action), (task, seed, action)
                *_, terminated, truncated, _ = made.step(action)
                if terminated or truncated:
                    break
            solved[task] += terminated
        made.close()
    print("scripted policy:", {task: f"{count}/{len(SEEDS)}" for task, count in solved.items()})
    assert solved == dict.fromkeys(within, len(SEEDS))


def test_a_correction_is_from_here_and_leads_to_the_goal(env) -> None:
    env.reset(seed=3)
    first = env.actions(env.demonstrate())[0]
    *_, info = env.step(first)
    assert info["events"] == 1, "somebody has bumped into the cube"
    corrected = env.correct()
    assert corrected.kind == "corrective" and corrected.others["after"] is None
    for action in env.actions(corrected):
        *_, terminated, truncated, info = env.step(action)
        assert not truncated
    assert terminated and info["solved"]


@pytest.mark.parametrize("task, variation", [("stack", "drop"), ("pour", None)])
def test_a_snapshot_goes_on_bit_for_bit(task: str, variation: "str | None") -> None:
    made = Env(task, variation)
    made.reset(seed=5)
    actions = made.actions(made.demonstrate())
    half = len(actions) // 2
    for action in actions[:half]:
        made.step(action)
    kept = made.snapshot()
    gone = [made.step(action) for action in actions[half:]]
    here = made.restore(kept)
    assert all(same(made.step(action), before) for action, before in zip(actions[half:], gone))
    other = Env(task, variation)
    assert other.pid != made.pid and same(other.restore(kept), here)
    assert all(same(other.step(action), before) for action, before in zip(actions[half:], gone))
    with pytest.raises(ServeError, match="expected one of the same program"):
        changed = json.loads(kept)
        changed["seed"] += 1
        other.restore(json.dumps(changed))
    assert same(other.restore(kept), here), "what was refused has changed nothing"
    made.close()
    other.close()


def test_the_seed_is_that_of_the_program(env) -> None:
    one, info = env.reset(seed=7)
    with Client() as client:
        begun = client.ask("reset", task="stack", variation="bump", seed=7)
    assert one.tolist() == begun["scaled"] and info["seed"] == 7
    drawn = [env.reset()[1]["seed"] for _ in range(2)]
    env.reset(seed=7)
    assert drawn == [env.reset()[1]["seed"] for _ in range(2)] and drawn[0] != drawn[1]


def test_a_step_to_where_the_hand_is_waits(env) -> None:
    _, info = env.reset(seed=1)
    hand = info["hand"].position
    action = np.array([*hand[:2], hand[2] - 0.05, 0.0, 0.0, math.pi / 2, 0.5])
    *_, before = env.step(action)
    *_, after = env.step(action)
    assert after["seconds"] - before["seconds"] == pytest.approx(0.5, abs=0.01)
    assert after["opening"] == pytest.approx(0.5 * env.stroke, abs=1e-3)
    w, x, y, z = after["hand"].quaternion
    assert abs(w) == pytest.approx(math.sqrt(0.5), abs=1e-6) and abs(z) == pytest.approx(math.sqrt(0.5), abs=1e-6)


def test_several_at_once() -> None:
    made = gymnasium.make_vec("situ_bench/stack-v1", num_envs=2, vectorization_mode="sync")
    made.action_space.seed(3)
    observations, _ = made.reset(seed=[3, 3])
    assert observations[0].tobytes() == observations[1].tobytes()
    action = made.action_space.sample()
    observations, *_, info = made.step(action)
    assert observations[0].tobytes() != observations[1].tobytes() and len(info["end"]) == 2
    made.close()


def test_a_picture_is_an_array() -> None:
    made = gymnasium.make("situ_bench/press-v1", render_mode="rgb_array", size=(64, 40))
    made.reset(seed=1)
    picture = made.render()
    assert picture.shape == (40, 64, 3) and picture.dtype == np.uint8 and picture.std() > 5
    made.close()


def test_what_is_wrong_is_said(env) -> None:
    with pytest.raises(ServeError, match="expected `reset`"):
        env.snapshot()
    before = env.reset(seed=1)
    for action in (np.zeros(6), np.full(7, np.nan), np.full(7, np.inf)):
        with pytest.raises(ValueError, match="7 finite numbers"):
            env.step(action)
    with pytest.raises(ServeError, match="expected the text"):
        env.restore("nothing")
    assert env.restore(env.snapshot())[0].tobytes() == before[0].tobytes(), "what was refused has changed nothing"
    with pytest.raises(ServeError, match="no variation 'lid': expected one of occupied"):
        Env("stack", "lid")
    with pytest.raises(ServeError, match="expected one of bread_box"):
        Env("teapot")
    with pytest.raises(ServeError, match="cannot be started"):
        Env("stack", program="nowhere/situ-bench")
    with pytest.raises(ValueError, match="rgb_array"):
        Env("stack", render_mode="human")


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_nothing_is_left_running() -> None:
    made = Env("press")
    made.reset(seed=1)
    first = made.pid
    made.close()
    made.close()
    assert not is_running(first) and made.pid is None
    made.reset(seed=1)
    second = made.pid
    assert second != first and is_running(second), "whoever resets starts another"
    del made
    gc.collect()
    assert not is_running(second)
    program = "from situ_bench import Env; made = Env('press'); made.reset(seed=1); print(made.pid)"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT / "src", check=True)
    assert not is_running(int(run.stdout))


def test_the_example_of_the_page_runs() -> None:
    text = (ROOT.parent / "docs/serve.md").read_text()
    example = text.split("```python\n")[1].split("```")[0]
    assert len(example.splitlines()) <= 20
    run = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True, cwd=ROOT / "src", check=True)
    assert "True" in run.stdout
