"""What `situ-bench export` writes is what the packages of others read.

`SITU_BENCH` names the program; without it the newest build in `target` counts. The packages `mcap`, `pyarrow`,
`pandas`, `datasets` and `lerobot` are used where they are installed, and a test that lacks one says so.
"""

import csv
import json
import os
import pathlib
import runpy
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[3]
SHOWN = ROOT / "bench/examples/demonstrations"
RECORDING = ROOT / "bench/examples/recording"


def program() -> str:
    named = os.environ.get("SITU_BENCH")
    built = [ROOT / "target" / kind / "situ-bench" for kind in ("release", "debug")]
    there = [path for path in built if path.exists()]
    if not named and not there:
        pytest.skip("skipped: no situ-bench is built, and SITU_BENCH names none")
    return named or str(max(there, key=lambda path: path.stat().st_mtime))


def export(kind: str, out: pathlib.Path) -> None:
    shown = [str(SHOWN / f"{name}.json") for name in ("serve-1", "serve-2")]
    words = [program(), "export", "--format", kind, "--out", str(out), *shown]
    done = subprocess.run([*words, "--correct", str(SHOWN / "lid-first.json")], capture_output=True, text=True)
    if "unrecognized subcommand" in done.stderr:
        pytest.skip("skipped: the program that is built knows no export yet")
    assert done.returncode == 0, done.stderr


def imported(recording: pathlib.Path, mapping: str, folder: pathlib.Path) -> list[dict]:
    """The demonstrations of a recording, in order of their names."""
    (folder / "map.toml").write_text(mapping)
    words = ["--mapping", str(folder / "map.toml"), "--out", str(folder / "shown")]
    done = subprocess.run([program(), "import", str(recording), *words], capture_output=True, text=True)
    if "unrecognized subcommand" in done.stderr:
        pytest.skip("skipped: the program that is built knows no import yet")
    assert done.returncode == 0, done.stderr
    return [json.loads(path.read_text()) for path in sorted((folder / "shown").iterdir())]


def from_csv(folder: pathlib.Path) -> list[dict]:
    folder.mkdir()
    return imported(RECORDING / "saucer.csv", (RECORDING / "saucer.toml").read_text(), folder)


def rows() -> list[dict]:
    with open(RECORDING / "saucer.csv", newline="") as file:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def numbers(value) -> list[float]:
    """All numbers in a value of JSON, in its order."""
    if isinstance(value, dict):
        return [number for part in value.values() for number in numbers(part)]
    if isinstance(value, list):
        return [number for part in value for number in numbers(part)]
    return [float(value)] if isinstance(value, (int, float)) else []


def assert_same(one: list[dict], other: list[dict], slack: float) -> None:
    assert [demonstration["name"] for demonstration in one] == [demonstration["name"] for demonstration in other]
    for first, second in zip(one, other):
        for key in ("kind", "after", "carried_to_end", "half_turn"):
            assert first[key] == second[key], key
        references = [[keyframe["reference"] for keyframe in shown["keyframes"]] for shown in (first, second)]
        assert references[0] == references[1]
        assert numbers(first["keyframes"]) == pytest.approx(numbers(second["keyframes"]), abs=slack)
        assert numbers(first["final_world"]) == pytest.approx(numbers(second["final_world"]), abs=slack)


def test_a_dataset_that_another_program_wrote_gives_the_same_as_the_csv(tmp_path: pathlib.Path) -> None:
    arrow = pytest.importorskip("pyarrow", reason="skipped: the package pyarrow is not installed")
    parquet = pytest.importorskip("pyarrow.parquet", reason="skipped: the package pyarrow is not installed")
    hand = ["x", "y", "z", "qw", "qx", "qy", "qz", "width"]
    things = ["cup_x", "cup_y", "cup_z", "saucer_x", "saucer_y", "saucer_z"]
    root, recorded = tmp_path / "dataset", rows()
    (root / "meta").mkdir(parents=True)
    (root / "data/chunk-000").mkdir(parents=True)
    features = {"observation.state": {"dtype": "float32", "shape": [8], "names": {"motors": hand}}}
    (root / "meta/info.json").write_text(json.dumps({"codebase_version": "v3.0", "features": features}))

    def table(part: list[dict]):
        vector = lambda names, kind: arrow.array([[row[name] for name in names] for row in part], kind)
        return arrow.table(
            {
                "observation.state": vector(hand, arrow.list_(arrow.float32(), 8)),
                "things": vector(things, arrow.list_(arrow.float64())),
                "intervention": arrow.array([row["human"] > 0 for row in part]),
                "timestamp": arrow.array([row["t"] for row in part], arrow.float32()),
                "episode_index": arrow.array([int(row["episode"]) for row in part], arrow.int64()),
                "image": arrow.array([{"bytes": b"none", "path": "none"} for _ in part]),
            }
        )

    # Two files, of which the first has several groups of rows.
    for number, part in enumerate((recorded[:130], recorded[130:])):
        path = root / f"data/chunk-000/file-{number:03d}.parquet"
        parquet.write_table(table(part), path, row_group_size=50, compression=("snappy", "zstd")[number])
    state = lambda names: json.dumps([f"observation.state.{name}" for name in names])
    thing = lambda first: json.dumps([f"things[{index}]" for index in range(first, first + 3)])
    mapping = f"""
name = "saucer"
half_turn = "z"
quaternion_order = "wxyz"
[gripper]
position = {state(hand[:3])}
quaternion = {state(hand[3:7])}
[opening]
column = "observation.state.width"
unit = "m"
close_below = 0.065
open_above = 0.075
force = 20.0
[objects]
cup = {{position = {thing(0)}, orientation = "none"}}
saucer = {{position = {thing(3)}, orientation = "none"}}
"""
    assert_same(imported(root, mapping, tmp_path), from_csv(tmp_path / "csv"), 1e-4)


def test_an_mcap_file_that_another_program_wrote_gives_the_same_as_the_csv(tmp_path: pathlib.Path) -> None:
    writing = pytest.importorskip("mcap.writer", reason="skipped: the package mcap is not installed")
    schema = json.dumps({"type": "object"}).encode()
    for number in range(3):
        with open(tmp_path / f"{number}.mcap", "wb") as stream:
            writer = writing.Writer(stream)
            writer.start()

            def topic(name: str, of: str) -> int:
                return writer.register_channel(name, "json", writer.register_schema(of, "jsonschema", schema))

            hand, things = topic("/hand", "foxglove.PoseInFrame"), topic("/things", "foxglove.PosesInFrame")
            arm = topic("/arm", "own.Arm")
            for row in [row for row in rows() if row["episode"] == number]:
                time = round(row["t"] * 1e9)
                vector = lambda name: {axis: row[f"{name}{axis}"] for axis in "xyz"}
                turned = {part: row[f"q{part}"] for part in "wxyz"}
                still = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
                poses = [{"position": vector(f"{name}_"), "orientation": still} for name in ("cup", "saucer")]
                pose = {"position": vector(""), "orientation": turned}
                for channel, message in (
                    (hand, {"frame_id": "base", "pose": pose}),
                    (things, {"frame_id": "base", "poses": poses}),
                    (arm, {"fingers": [{"width": row["width"]}], "human": row["human"] > 0}),
                ):
                    writer.add_message(channel, time, json.dumps(message).encode(), time)
            writer.finish()
    mapping = """
name = "saucer"
half_turn = "z"
[columns]
intervention = "/arm.human"
[gripper]
topic = "/hand"
[opening]
column = "/arm.fingers.0.width"
unit = "m"
close_below = 0.065
open_above = 0.075
force = 20.0
[objects]
cup = {topic = "/things", index = 0}
saucer = {topic = "/things", index = 1}
"""
    (tmp_path / "map.toml").write_text(mapping)
    recordings = [str(tmp_path / f"{number}.mcap") for number in range(3)]
    words = ["--mapping", str(tmp_path / "map.toml"), "--out", str(tmp_path / "shown")]
    done = subprocess.run([program(), "import", *recordings, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    shown = [json.loads(path.read_text()) for path in sorted((tmp_path / "shown").iterdir())]
    assert_same(shown, from_csv(tmp_path / "csv"), 1e-9)


def keyframes(name: str) -> list[dict]:
    return json.loads((SHOWN / f"{name}.json").read_text())["keyframes"]


def test_the_example_of_a_recording_is_made_by_its_script() -> None:
    made = runpy.run_path(str(RECORDING / "make.py"))["recording"]()
    assert made == (RECORDING / "saucer.csv").read_text()


def test_an_mcap_file_is_read_by_the_package_mcap(tmp_path: pathlib.Path) -> None:
    reader = pytest.importorskip("mcap.reader", reason="skipped: the package mcap is not installed")
    export("mcap", tmp_path / "all.mcap")
    with open(tmp_path / "all.mcap", "rb") as stream:
        messages = list(reader.make_reader(stream).iter_messages())
    kinds = {channel.topic: (schema.name, schema.encoding) for schema, channel, _ in messages}
    assert kinds["/gripper"] == ("foxglove.PoseInFrame", "jsonschema")
    assert kinds["/objects"] == ("foxglove.FrameTransforms", "jsonschema")
    assert {channel.message_encoding for _, channel, _ in messages} == {"json"}
    for schema, _, _ in messages[:3]:
        assert json.loads(schema.data)["type"] == "object"
    said = [(channel.topic, message.log_time, json.loads(message.data)) for _, channel, message in messages]
    marked = [(time, each) for topic, time, each in said if topic == "/demonstration" and each["keyframe"]]
    hands = {time: each["pose"] for topic, time, each in said if topic == "/gripper"}
    shown = [keyframe for name in ("serve-1", "serve-2", "lid-first") for keyframe in keyframes(name)]
    assert [each["reference"] for _, each in marked] == [keyframe["reference"] for keyframe in shown]
    for (time, _), keyframe in zip(marked, shown):
        pose = hands[time]
        assert [pose["position"][axis] for axis in "xyz"] == keyframe["gripper_pose"]["position"]
        assert [pose["orientation"][part] for part in "wxyz"] == keyframe["gripper_pose"]["quaternion"]
    led = {each["name"]: each["intervention"] for topic, _, each in said if topic == "/demonstration"}
    assert led == {"serve-1": False, "serve-2": False, "lid-first": True}


def test_a_dataset_has_the_published_layout(tmp_path: pathlib.Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="skipped: the package pyarrow is not installed")
    root = tmp_path / "dataset"
    export("lerobot", root)
    info = json.loads((root / "meta/info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    data = parquet.read_table(root / info["data_path"].format(chunk_index=0, file_index=0))
    episodes = parquet.read_table(root / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert data.column_names == list(info["features"])
    assert data.num_rows == info["total_frames"] and len(episodes) == info["total_episodes"] == 3
    kinds = {"float32": "float", "int64": "int64", "bool": "bool", "string": "string"}
    rows = data.to_pylist()
    for name, feature in info["features"].items():
        kind, (width,) = str(data.schema.field(name).type), feature["shape"]
        assert kind == kinds[feature["dtype"]] or kind == f"list<element: {kinds[feature['dtype']]}>", name
        if kind.startswith("list"):
            assert {len(row[name]) for row in rows} == {width == len(feature["names"]) and width}, name
    for number, episode in enumerate(episodes):
        own = rows[episode["dataset_from_index"] : episode["dataset_to_index"]]
        assert len(own) == episode["length"] and {row["episode_index"] for row in own} == {number}
        assert [row["frame_index"] for row in own] == list(range(len(own)))
        assert all(abs(row["timestamp"] - row["frame_index"] / info["fps"]) < 1e-4 for row in own)
        assert episode["tasks"] == ["the demonstrated task"]
        assert episode["stats/keyframe/count"] == [len(own)]
        highest = [max(row["observation.state"][part] for row in own) for part in range(8)]
        assert episode["stats/observation.state/max"] == highest
    statistics = json.loads((root / "meta/stats.json").read_text())
    numbers = {name for name, feature in info["features"].items() if feature["dtype"] != "string"}
    assert set(statistics) == numbers
    assert set(statistics["action"]) == {"min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99"}
    assert statistics["action"]["count"] == [len(rows)] and len(statistics["action"]["mean"]) == 8
    mean = sum(row["action"][2] for row in rows) / len(rows)
    assert statistics["action"]["mean"][2] == pytest.approx(mean)


def test_the_tasks_are_those_of_pandas(tmp_path: pathlib.Path) -> None:
    pandas = pytest.importorskip("pandas", reason="skipped: the package pandas is not installed")
    pytest.importorskip("pyarrow", reason="skipped: the package pyarrow is not installed")
    export("lerobot", tmp_path / "dataset")
    tasks = pandas.read_parquet(tmp_path / "dataset/meta/tasks.parquet")
    assert tasks.iloc[0].name == "the demonstrated task" and list(tasks.columns) == ["task_index"]
    assert tasks.loc["the demonstrated task"].task_index == 0


def test_a_dataset_is_read_by_the_package_datasets(tmp_path: pathlib.Path) -> None:
    datasets = pytest.importorskip("datasets", reason="skipped: the package datasets is not installed")
    export("lerobot", tmp_path / "dataset")
    info = json.loads((tmp_path / "dataset/meta/info.json").read_text())

    def feature(of: dict):
        value, (width,) = datasets.Value(of["dtype"]), of["shape"]
        return value if width == 1 else datasets.Sequence(value, length=width)

    features = datasets.Features({name: feature(of) for name, of in info["features"].items()})
    path = str(tmp_path / "dataset/data/chunk-000/file-000.parquet")
    read = datasets.Dataset.from_parquet(path, features=features, cache_dir=str(tmp_path / "cache"))
    assert read.features == features and len(read) == info["total_frames"]


def test_a_dataset_is_read_by_the_package_lerobot(tmp_path: pathlib.Path) -> None:
    name = "lerobot.datasets.lerobot_dataset"
    lerobot = pytest.importorskip(name, reason="skipped: the package lerobot is not installed", exc_type=ImportError)
    export("lerobot", tmp_path / "dataset")
    dataset = lerobot.LeRobotDataset("one/own", root=tmp_path / "dataset")
    assert dataset.num_episodes == 3
    first = dataset[0]
    assert first["task"] == "the demonstrated task" and first["observation.state"].shape == (8,)
