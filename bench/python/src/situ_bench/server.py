"""Serves a method: one question a line on the standard input, one answer a line on the standard output."""

from __future__ import annotations

import json
import os
import sys
import traceback
from typing import Any, TextIO

from .demonstration import Demonstration
from .method import Child, Graph, Method, Node, Refused, RelativeKeyframe, Schema, Step

#: The version of the questions and answers that this package speaks.
PROTOCOL = 1


def _edges(edges: list[tuple[Any, str]]) -> list[list[Any]]:
    return [[start, end] for start, end in edges]


def _is(what: str, value: Any, kind: type | tuple[type, ...], expected: str) -> Any:
    """The value, which a method has returned, where it is of this kind."""
    if not isinstance(value, kind):
        raise TypeError(f"{what} returned {value!r:.200}: expected {expected}")
    return value


def _plain(value: Any) -> Any:
    """A number or an array of numpy as JSON has it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{value!r:.200} of type {type(value).__name__} is nothing that JSON can hold")


def answer(method: Method, question: dict[str, Any]) -> dict[str, Any]:
    """The answer to a question, without its number."""
    do = question["do"]
    if do == "hello":
        if question["protocol"] != PROTOCOL:
            raise Refused(f"protocol {question['protocol']}: this package speaks {PROTOCOL}")
        hello: dict[str, Any] = {
            "summary": method.summary or (type(method).__doc__ or type(method).__name__).strip().splitlines()[0],
            "source": method.source or "no source is given",
            "role": method.role,
            "edits": method.edits,
        }
        return hello if method.original is None else {**hello, "original": method.original}
    if do == "teach":
        features = question["schema"]
        schema = Schema(
            [feature["name"] for feature in features],
            [feature["scale"] for feature in features],
            question.get("half_turn"),
        )
        segments = method.teach(schema, [Demonstration.of(shown) for shown in question["demonstrations"]], question["seed"])
        _is("teach", segments, (list, type(None)), "None, or a list of lists of numbers of keyframes")
        return {} if segments is None else {"segments": segments}
    if do == "correct":
        trail = [Step(step["place"], step["state"], step["ended"]) for step in question["trail"]]
        shown = Demonstration.of(question["demonstration"])
        told = method.correct(question["last"], question["interrupted"], trail, shown)
        return _is("correct", told, (dict, type(None)), "None, or a dict with edits, counters or segments") or {}
    if do == "next":
        children = _is("next", method.next(question["last"], question["state"]), (list, tuple), "a list of Child")
        for child in children:
            _is("next", child, Child, "a list of Child(place, probability), the likeliest first")
        return {"children": [{"place": child.place, "probability": child.probability} for child in children]}
    if do == "keyframes":
        performed = method.keyframes(
            question["place"], question["state"], question["execution"], question["attempt"], question["seed"]
        )
        expected = "the name of the reference object, and a list of RelativeKeyframe"
        if len(_is("keyframes", performed, (tuple, list), expected)) != 2:
            raise TypeError(f"keyframes returned {len(performed)} values: expected {expected}")
        reference, keyframes = performed
        for keyframe in _is("keyframes", keyframes, (list, tuple), expected):
            _is("keyframes", keyframe, RelativeKeyframe, expected)
        written = [
            {
                "position": list(keyframe.pose.position),
                "quaternion_wxyz": list(keyframe.pose.quaternion),
                "gripper": keyframe.gripper,
                "hold": keyframe.hold,
            }
            for keyframe in keyframes
        ]
        return {"reference": reference, "keyframes": written}
    if do == "graph":
        graph = _is("graph", method.graph(), Graph, "a Graph of nodes and edges")
        for node in graph.nodes:
            _is("graph", node, Node, "a Graph whose nodes are Node(place, segments)")
        nodes = [
            {"place": node.place, "segments": [[name, index] for name, index in node.segments], "ways": node.ways}
            for node in graph.nodes
        ]
        return {"nodes": nodes, "edges": _edges(graph.edges)}
    if do == "save":
        return {"model": method.save()}
    if do == "load":
        method.load(question["model"])
        return {}
    raise Refused(f"no question is called {do!r}")


def serve(method: Method, questions: TextIO | None = None, answers: TextIO | None = None) -> None:
    """Answers questions until there are no more.

    What the method prints goes to the standard error, which the benchmark keeps in a log. An exception ends the
    program, unless it is `Refused`: the benchmark records that the method broke off, and says why.
    """
    questions = sys.stdin if questions is None else questions
    if answers is None:
        # Whatever else is printed must not stand among the answers.
        answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        sys.stdout = sys.stderr
    for line in questions:
        question = json.loads(line)
        try:
            said = answer(method, question)
        except Refused as why:
            said = {"error": str(why)}
        except Exception:
            traceback.print_exc()
            sys.stderr.flush()
            raise SystemExit(1) from None
        try:
            line = json.dumps({"id": question["id"], **said}, default=_plain)
        except TypeError:
            traceback.print_exc()
            sys.stderr.flush()
            raise SystemExit(1) from None
        answers.write(line + "\n")
        answers.flush()
