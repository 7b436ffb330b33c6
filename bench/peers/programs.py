"""The Rust sides: programs that read a question from a file, and answer with values and the times of their runs."""

import json
import subprocess
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cases import Measure, Measured

ROOT = Path(__file__).resolve().parents[2]
CRATE = Path(__file__).resolve().parent / "hmmlearn_rs"


class ProgramFailed(Exception):
    """A program ended without an answer."""


@dataclass(frozen=True)
class Program:
    """A built program, and the folder for its questions."""

    binary: Path
    folder: Path

    def measure(self, question: dict[str, Any]) -> Measure:
        """Measures the program on a question."""
        path = self.folder / f"{sum(1 for _ in self.folder.iterdir())}.json"
        path.write_text(json.dumps(question, default=lambda numbers: numbers.tolist()))

        def measure(seconds: float) -> Measured:
            # Messages go into a file that is read only where the program failed: a falling likelihood prints one.
            with tempfile.TemporaryFile() as said:
                done = subprocess.run([self.binary, path, str(seconds)], stdout=subprocess.PIPE, stderr=said)
                said.seek(0)
                if done.returncode != 0:
                    raise ProgramFailed(f"{self.binary.name}: exit status {done.returncode}: {said.read().decode()}")
            answer = json.loads(done.stdout)
            values = {name: np.array(numbers, dtype=float) for name, numbers in answer["values"].items()}
            return Measured([nanoseconds / 1e6 for nanoseconds in answer["nanoseconds"]], lambda: values)

        return measure


@dataclass(frozen=True)
class Programs:
    """Both Rust sides."""

    ours: Program
    """The example `peers` of situ-bench."""
    hmmlearn_rs: Program
    """The package in `hmmlearn_rs`."""


def built_ours() -> Path:
    """Builds our side. Returns where cargo put it."""
    return built(["--package", "situ-bench", "--example", "peers"], ROOT, "peers")


def built_hmmlearn_rs() -> Path:
    """Builds the peer that is a crate. Returns where cargo put it."""
    return built([], CRATE, "peer-hmmlearn-rs")


def built(asked: list[str], folder: Path, name: str) -> Path:
    command = ["cargo", "build", "--release", "--locked", *asked, "--message-format", "json"]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, check=True, text=True)
    made = [message.get("executable") for message in map(json.loads, done.stdout.splitlines())
            if message.get("target", {}).get("name") == name]
    return Path(next(path for path in made if path))


def crate_version(name: str) -> str:
    """The version of a crate that the peer's program is built of."""
    locked = tomllib.loads((CRATE / "Cargo.lock").read_text())
    return next(package["version"] for package in locked["package"] if package["name"] == name)
