"""Nearest-neighbour replay: what was shown in the state nearest to the present one is done again.

The same as the method `nearest` of the program, number for number, and without a call into it.
"""

from situ_bench import Child, Graph, Method, Node, RelativeKeyframe, serve


class Nearest(Method):
    """Replays the demonstrated segment whose start state is nearest."""

    source = "an example of the Python package"

    def teach(self, schema, demonstrations, seed):
        self.scales, self.shown = schema.scales, []
        for demonstration in demonstrations:
            self.remember(demonstration, None)

    def correct(self, last, interrupted, trail, demonstration):
        self.remember(demonstration, last)

    def remember(self, demonstration, after):
        first = sum(len(segments) for _, _, segments, _ in self.shown)
        segments = [(f"p{first + index}", segment) for index, segment in enumerate(demonstration.segments())]
        end = demonstration.final_state if demonstration.carried_to_end else None
        self.shown.append((demonstration.name, after, segments, end))

    def next(self, last, state):
        starts = [(place, segment.start) for _, _, segments, _ in self.shown for place, segment in segments]
        ends = [("end", end) for _, _, _, end in self.shown if end is not None]
        best, least = None, None
        for place, shown in starts + ends:
            far = 0.0
            for here, there, scale in zip(shown, state, self.scales):
                far += ((here - there) / scale) * ((here - there) / scale)
            # Of two that are equally near, the one that was shown later.
            if least is None or far <= least:
                best, least = place, far
        return [Child(best, 1.0)]

    def keyframes(self, place, state, execution, attempt, seed):
        segment = next(own for _, _, segments, _ in self.shown for name, own in segments if name == place)
        poses = zip(segment.relative(), segment.keyframes)
        return segment.reference, [RelativeKeyframe(pose, own.gripper, own.hold) for pose, own in poses]

    def graph(self):
        graph = Graph()
        for name, before, segments, end in self.shown:
            for index, (place, _) in enumerate(segments):
                graph.nodes.append(Node(place, [(name, index)]))
                graph.edges.append((before, place))
                before = place
            if end is not None:
                graph.edges.append((before, "end"))
        return graph


if __name__ == "__main__":
    serve(Nearest())
