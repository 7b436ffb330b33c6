"""Nearest-neighbour replay that breaks off once it is corrected, in a way that is named on the command line."""

import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "examples"))

from nearest import Nearest  # noqa: E402
from situ_bench import Child, Graph, Refused, serve  # noqa: E402


class Faulty(Nearest):
    """Breaks off."""

    fault = sys.argv[1]
    # An heir takes over what `none` was taught; a modest one says less than it can.
    original = "none" if fault == "heir" else None
    edits = ["edge_addition"] if fault == "modest" else Nearest.edits
    corrected = False

    def correct(self, last, interrupted, trail, demonstration):
        if self.fault == "deaf":
            return None
        if self.fault == "refuse":
            raise Refused("it does not like\nthis one")
        if self.fault == "crash":
            print("about to crash", file=sys.stderr)
            raise ValueError("a mistake of mine")
        if self.fault == "exit":
            os._exit(0)
        if self.fault == "hang":
            # Somebody else's child, who would outlive it.
            subprocess.Popen(["sleep", "1000"])
            time.sleep(1000)
        if self.fault == "counter":
            return {"counters": {"hmm_fits": -1}}
        if self.fault == "edit":
            return {"edits": ["somersault"]}
        super().correct(last, interrupted, trail, demonstration)
        self.corrected = True
        return None

    def next(self, last, state):
        children = super().next(last, state)
        if not self.corrected:
            return children
        if self.fault == "late":
            time.sleep(20)
        if self.fault == "nan":
            return [Child(children[0].place, float("nan"))]
        if self.fault == "improbable":
            return [Child(children[0].place, 1.5)]
        if self.fault == "nowhere":
            return [Child("nowhere", 0.9)]
        if self.fault == "unsorted":
            return [Child(children[0].place, 0.1), Child("end", 0.9)]
        return children

    def keyframes(self, place, state, execution, attempt, seed):
        reference, keyframes = super().keyframes(place, state, execution, attempt, seed)
        if self.corrected and self.fault == "keyframes":
            return reference, [key for key in keyframes] * 5000
        return reference, keyframes

    def graph(self):
        if self.corrected and self.fault == "graph":
            return Graph([], [("p77", "end")])
        return super().graph()

    def save(self):
        if self.fault == "unsaved":
            raise Refused("it does not save")
        return super().save()


if __name__ == "__main__":
    serve(Faulty())
