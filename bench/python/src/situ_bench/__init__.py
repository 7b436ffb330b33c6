"""Methods of one's own for situ-bench, the benchmark of learning from corrective demonstrations.

A method is a class; a program is a method that is served:

    from situ_bench import Method, serve

    class Mine(Method):
        ...

    if __name__ == "__main__":
        serve(Mine())

`situ-bench run --methods FILE.toml --method NAME` runs it. Nothing but the standard library is needed.

`Env` is a task as an environment of Gymnasium, which needs gymnasium and numpy; `Client` asks `situ-bench serve`, and
needs neither.
"""

from __future__ import annotations

from typing import Any

from .client import Client, ServeError

from .demonstration import Demonstration, Gripper, Keyframe, Pose, Segment, read_demonstration, write_demonstration
from .ledger import read_ledger, rows, to_pandas
from .method import Child, Counters, Execution, Graph, Method, Node, RelativeKeyframe, Refused, Schema, Step
from .server import serve

__all__ = [
    "Child",
    "Client",
    "Counters",
    "Demonstration",
    "Execution",
    "Graph",
    "Gripper",
    "Keyframe",
    "Method",
    "Node",
    "Pose",
    "Refused",
    "RelativeKeyframe",
    "Schema",
    "Segment",
    "ServeError",
    "Step",
    "read_demonstration",
    "read_ledger",
    "rows",
    "serve",
    "to_pandas",
    "write_demonstration",
]


def __getattr__(name: str) -> Any:
    """`Env` is imported when it is asked for: the rest of the package needs no gymnasium."""
    if name == "Env":
        from .env import Env

        return Env
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
