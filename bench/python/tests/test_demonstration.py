"""Poses and demonstration files."""

import dataclasses
import json
import math
import pathlib
import random

import pytest

from situ_bench import Demonstration, Pose, read_demonstration, write_demonstration

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
FILES = sorted((EXAMPLES / "demonstrations").glob("*.json"))


def any_pose(draw: random.Random) -> Pose:
    quaternion = [draw.gauss(0.0, 1.0) for _ in range(4)]
    length = math.sqrt(sum(value * value for value in quaternion))
    w, x, y, z = (value / length for value in quaternion)
    return Pose((draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1)), (w, x, y, z))


def matrix(pose: Pose) -> list[list[float]]:
    """The rotation as a matrix, by the formula of the textbooks."""
    w, x, y, z = pose.quaternion
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


@pytest.mark.parametrize("seed", range(50))
def test_a_product_is_that_of_the_matrices(seed: int) -> None:
    draw = random.Random(seed)
    one, other = any_pose(draw), any_pose(draw)
    turned, product = matrix(one), one * other
    moved = [sum(row[k] * other.position[k] for k in range(3)) + one.position[i] for i, row in enumerate(turned)]
    assert product.position == pytest.approx(moved)
    expected = [[sum(turned[i][k] * matrix(other)[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    for row, own in zip(matrix(product), expected):
        assert row == pytest.approx(own)
    nothing = one.inverse() * one
    assert nothing.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert abs(nothing.quaternion[0]) == pytest.approx(1.0)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_file_is_read_and_written(path: pathlib.Path, tmp_path: pathlib.Path) -> None:
    shown = read_demonstration(path)
    write_demonstration(tmp_path / "again.json", shown)
    assert read_demonstration(tmp_path / "again.json") == shown
    said, again = (json.loads(file.read_text()) for file in (path, tmp_path / "again.json"))
    for keyframe in said["keyframes"]:
        keyframe.setdefault("hold", 0.0)
    assert again == said
    segments = shown.segments()
    assert sum(len(segment.keyframes) for segment in segments) == len(shown.keyframes)
    for segment in segments:
        first = segment.frame * segment.relative()[0]
        assert first.position == pytest.approx(segment.keyframes[0].gripper_pose.position)


def test_a_file_needs_its_schema(tmp_path: pathlib.Path) -> None:
    with pytest.raises(ValueError, match="schema"):
        write_demonstration(tmp_path / "x.json", Demonstration("x", "original", [], [], True))
    assert FILES, "the examples are there"


def test_a_file_of_poses_is_read_and_written_as_it_was(tmp_path: pathlib.Path) -> None:
    for path in sorted((EXAMPLES / "poses").glob("*.json")):
        shown = read_demonstration(path)
        write_demonstration(tmp_path / path.name, shown)
        before, after = (json.loads(each.read_text()) for each in (path, tmp_path / path.name))
        for keyframe in before["keyframes"]:
            keyframe.setdefault("hold", 0.0)
        assert after == before
        first = before["keyframes"][0]
        assert shown.segments()[0].frame == Pose.of(first["world"]["objects"][first["reference"]])
        with pytest.raises(ValueError, match="final_world"):
            others = {key: value for key, value in shown.others.items() if key != "final_world"}
            write_demonstration(tmp_path / "none.json", dataclasses.replace(shown, others=others))
