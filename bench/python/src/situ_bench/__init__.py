"""Methods of one's own for situ-bench, the benchmark of learning from corrective demonstrations.

A method is a class; a program is a method that is served:

    from situ_bench import Method, serve

    class Mine(Method):
        ...

    if __name__ == "__main__":
        serve(Mine())

`situ-bench run --methods FILE.toml --method NAME` runs it. Nothing but the standard library is needed.
"""

from .demonstration import Demonstration, Gripper, Keyframe, Pose, Segment, read_demonstration, write_demonstration
from .ledger import read_ledger, rows, to_pandas
from .method import Child, Counters, Execution, Graph, Method, Node, RelativeKeyframe, Refused, Schema, Step
from .server import serve

__all__ = [
    "Child",
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
    "Step",
    "read_demonstration",
    "read_ledger",
    "rows",
    "serve",
    "to_pandas",
    "write_demonstration",
]
