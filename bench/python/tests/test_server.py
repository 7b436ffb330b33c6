"""A method that is served answers line by line."""

import io
import json
import pathlib
import subprocess
import sys

import pytest

from nearest import Nearest
from situ_bench import Method, Refused, read_demonstration, serve

ROOT = pathlib.Path(__file__).parents[1]
SHOWN = [read_demonstration(path) for path in sorted((ROOT.parent / "examples/demonstrations").glob("serve-*.json"))]


def asked(method: Method, *questions: dict) -> list[dict]:
    lines = "".join(json.dumps({"id": number, **question}) + "\n" for number, question in enumerate(questions, 1))
    answers = io.StringIO()
    serve(method, io.StringIO(lines), answers)
    said = [json.loads(line) for line in answers.getvalue().splitlines()]
    assert [answer.pop("id") for answer in said] == list(range(1, len(questions) + 1))
    return said


def teach() -> dict:
    keys = [shown.keys() for shown in SHOWN]
    return {"do": "teach", "schema": SHOWN[0].others["schema"], "half_turn": None, "demonstrations": keys, "seed": 1}


def test_a_model_that_is_saved_and_loaded_answers_the_same() -> None:
    state = SHOWN[0].keyframes[0].state
    questions = [{"do": "next", "last": None, "state": state}, {"do": "graph"}]
    _, saved, *first = asked(Nearest(), teach(), {"do": "save"}, *questions)
    _, *again = asked(Nearest(), {"do": "load", "model": saved["model"]}, *questions)
    assert first == again
    assert first[0]["children"] == [{"place": "p0", "probability": 1.0}]
    assert [None, "p0"] in first[1]["edges"]


def test_what_is_refused_is_said_and_the_loop_goes_on() -> None:
    class Refuses(Nearest):
        def correct(self, *_):
            raise Refused("not today")

    correct = {"do": "correct", "last": None, "interrupted": None, "trail": [], "demonstration": SHOWN[0].keys()}
    _, refused, graph, unknown = asked(Refuses(), teach(), correct, {"do": "graph"}, {"do": "dance"})
    assert refused == {"error": "not today"} and len(graph["nodes"]) == sum(len(shown.segments()) for shown in SHOWN)
    assert "dance" in unknown["error"]
    assert "protocol 7" in asked(Nearest(), {"do": "hello", "protocol": 7})[0]["error"]


def test_what_a_method_prints_is_no_answer_and_a_mistake_ends_the_program() -> None:
    program = (
        "from situ_bench import Method, serve\n"
        "class Mine(Method):\n"
        "    'Mine.'\n"
        "    def graph(self):\n"
        "        print('hello there')\n"
        "        raise ValueError('a mistake')\n"
        "serve(Mine())\n"
    )
    lines = '{"id": 1, "do": "hello", "protocol": 1}\n{"id": 2, "do": "graph"}\n{"id": 3, "do": "graph"}\n'
    run = subprocess.run([sys.executable, "-c", program], input=lines, capture_output=True, text=True, cwd=ROOT / "src")
    assert run.returncode == 1 and len(run.stdout.splitlines()) == 1
    assert json.loads(run.stdout)["summary"] == "Mine."
    assert "hello there" in run.stderr and "a mistake" in run.stderr


def test_what_is_returned_in_another_form_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    class Mine(Nearest):
        def next(self, last, state):
            return [("p0", 1.0)]

        def keyframes(self, *_):
            return "cup"

        def graph(self):
            return {"nodes": []}

        def correct(self, *_):
            return ["node_addition"]

    state, shown = SHOWN[0].keyframes[0].state, SHOWN[0].keys()
    place = {"place": "p0", "state": state, "execution": "mean", "attempt": 0, "seed": 1}
    correction = {"last": None, "interrupted": None, "trail": [], "demonstration": shown}
    for question, expected in [
        ({"do": "next", "last": None, "state": state}, "next returned ('p0', 1.0): expected a list of Child(place"),
        ({"do": "keyframes", **place}, "keyframes returned 'cup': expected the name of the reference object"),
        ({"do": "graph"}, "graph returned {'nodes': []}: expected a Graph"),
        ({"do": "correct", **correction}, "correct returned ['node_addition']: expected None, or a dict"),
    ]:
        with pytest.raises(SystemExit):
            asked(Mine(), teach(), question)
        assert expected in capsys.readouterr().err


def test_numbers_of_numpy_are_numbers() -> None:
    numpy = pytest.importorskip("numpy", reason="skipped: the package numpy is not installed")

    class Mine(Nearest):
        def save(self):
            return {"mean": numpy.arange(3, dtype=numpy.float32), "best": numpy.float32(0.5)}

    assert asked(Mine(), teach(), {"do": "save"})[1] == {"model": {"mean": [0.0, 1.0, 2.0], "best": 0.5}}


def test_what_is_not_written_is_not_answered() -> None:
    with pytest.raises(SystemExit):
        asked(Method(), {"do": "graph"})
