"""A process of `situ-bench serve`, without gymnasium; skipped where the program is not there."""

import os
import pathlib
import subprocess
import sys

import pytest

from situ_bench import Client, ServeError
from situ_bench.client import find_program

ROOT = pathlib.Path(__file__).parents[1]
BUILT = ROOT.parents[1] / "target/release/situ-bench"
if "SITU_BENCH" not in os.environ and BUILT.is_file():
    os.environ["SITU_BENCH"] = str(BUILT)


@pytest.fixture
def client():
    try:
        find_program()
    except ServeError as why:
        pytest.skip(f"nothing is asked: {why}")
    with Client("--plant", "hand") as made:
        yield made


def test_the_package_needs_the_standard_library_alone() -> None:
    program = "import sys, situ_bench; print({'numpy', 'gymnasium'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT / "src", check=True)
    assert run.stdout.strip() == "set()"


def test_what_cannot_be_done_is_said_and_the_episode_goes_on(client: Client) -> None:
    with pytest.raises(ServeError, match="expected `reset`"):
        client.ask("observe")
    before = client.ask("reset", task="press", seed=1)
    for do, keys, expected in (
        ("move", {"position": [0, 0], "quaternion_wxyz": [1, 0, 0, 0]}, "key `position"),
        ("move", {"position": [0, 0, float("nan")], "quaternion_wxyz": [1, 0, 0, 0]}, "expected finite numbers"),
        ("reset", {"task": "press", "seed": 2**64}, "seed"),
        ("dance", {}, "nothing is called `dance`"),
    ):
        with pytest.raises(ServeError, match=expected):
            client.ask(do, **keys)
    assert client.ask("observe") == before


def test_a_process_that_has_ended_is_told(client: Client) -> None:
    assert client.ask("bye") == {}
    with pytest.raises(ServeError, match="has ended"):
        client.ask("observe")
    assert client.is_closed
    with pytest.raises(ServeError, match="has been ended"):
        client.ask("observe")
    client.close()


def test_a_program_that_is_none_is_told(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ServeError, match="cannot be started"):
        Client(program=str(tmp_path / "nothing"))
    with pytest.raises(ServeError, match="has ended"):
        Client(program=sys.executable)
    monkeypatch.setenv("SITU_BENCH", "mine")
    assert find_program() == "mine"
    monkeypatch.delenv("SITU_BENCH")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(ServeError, match="install the wheel"):
        find_program()
