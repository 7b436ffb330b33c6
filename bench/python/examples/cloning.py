"""Behaviour cloning of the next keyframe, retrained on everything after each correction. Needs scikit-learn.

The neural family on low-dimensional states: a network chooses the kind of the next keyframe (an object, and whether the
gripper is opened or closed there) from the state and the kind before, and another one of each kind gives its pose.
There is no automaton and no primitive beyond a keyframe.
"""

import warnings

import numpy
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPClassifier, MLPRegressor

from situ_bench import Child, Graph, Method, Node, Pose, RelativeKeyframe, serve

warnings.simplefilter("ignore", ConvergenceWarning)

#: Hidden units of each of the two layers.
HIDDEN = (64, 64)
#: Weight of the squared weights.
DECAY = 1e-3
#: The most passes over the data; the optimiser (L-BFGS) mostly ends before.
PASSES = 500


def command(gripper):
    """What the gripper is told: a word, and a number."""
    return next(iter(gripper.items())) if isinstance(gripper, dict) else ("opening", gripper)


class Cloning(Method):
    """Behaviour cloning of the next keyframe by two small networks, retrained on everything."""

    source = "an example of the Python package; the neural family on low-dimensional states"

    def teach(self, schema, demonstrations, seed):
        self.scales, self.seed, self.shown = numpy.array(schema.scales), seed % 2**32, []
        segments = [self.remember(demonstration, None) for demonstration in demonstrations]
        self.train()
        return segments

    def correct(self, last, interrupted, trail, demonstration):
        segments = self.remember(demonstration, last)
        self.train()
        return {"segments": segments}

    def remember(self, demonstration, before):
        """Cuts a demonstration at every keyframe; returns the lengths of the segments."""
        steps = []
        for segment in demonstration.segments():
            for pose, keyframe in zip(segment.relative(), segment.keyframes):
                word, number = command(keyframe.gripper)
                # A later keyframe finds the object where it then is.
                pose = keyframe.reference_pose.inverse() * keyframe.gripper_pose
                steps.append((f"{segment.reference}:{word}", keyframe.state, pose, number, keyframe.hold))
        end = demonstration.final_state if demonstration.carried_to_end else None
        self.shown.append((demonstration.name, before, steps, end))
        return [1] * len(steps)

    def seen(self, last, state):
        """What a network sees: the state in units of its scales, and the kind before."""
        before = [1.0 if kind == last else 0.0 for kind in self.kinds]
        return numpy.concatenate([(numpy.array(state) / self.scales - self.middle), before])

    def train(self):
        samples = [(before, *step) for _, before, step in self.pairs()]
        self.kinds = sorted({kind for _, kind, *_ in samples})
        states = numpy.array([state for _, _, state, *_ in samples]) / self.scales
        self.middle = states.mean(axis=0)
        ends = [(steps[-1][0], end) for _, _, steps, end in self.shown if end is not None]
        inputs = [self.seen(before, state) for before, _, state, *_ in samples]
        inputs += [self.seen(last, state) for last, state in ends]
        labels = [kind for _, kind, *_ in samples] + ["end"] * len(ends)
        options = {"hidden_layer_sizes": HIDDEN, "alpha": DECAY, "max_iter": PASSES, "solver": "lbfgs"}
        # One class alone needs no network.
        self.chooser = None
        if len(set(labels)) > 1:
            self.chooser = MLPClassifier(random_state=self.seed, **options).fit(inputs, labels)
        self.movers = {}
        for kind in self.kinds:
            # The kind before is not told when it is performed.
            own = [(self.seen(None, state), pose, number, hold)
                   for _, other, state, pose, number, hold in samples if other == kind]
            first = numpy.array(own[0][1].quaternion)
            targets = []
            for _, pose, number, hold in own:
                turn = numpy.array(pose.quaternion)
                # A rotation has two quaternions: the one near the first.
                turn = turn if turn @ first >= 0 else -turn
                targets.append([*pose.position, *turn, number, hold])
            targets = numpy.array(targets)
            mean, spread = targets.mean(axis=0), targets.std(axis=0) + 1e-9
            mover = MLPRegressor(random_state=self.seed, **options)
            self.movers[kind] = (mover.fit([seen for seen, *_ in own], (targets - mean) / spread), mean, spread)

    def pairs(self):
        """Every keyframe, with the kind of the one before it."""
        for name, before, steps, _ in self.shown:
            for index, step in enumerate(steps):
                yield name, before, step
                before = step[0]

    def next(self, last, state):
        if self.chooser is None:
            return [Child(self.kinds[0], 1.0)]
        likely = self.chooser.predict_proba([self.seen(last, state)])[0]
        ranked = sorted(zip(likely, self.chooser.classes_), key=lambda pair: -pair[0])
        return [Child(str(place), min(1.0, float(probability))) for probability, place in ranked]

    def keyframes(self, place, state, execution, attempt, seed):
        mover, mean, spread = self.movers[place]
        found = mover.predict([self.seen(None, state)])[0] * spread + mean
        position, turn = found[:3], found[3:7] / numpy.linalg.norm(found[3:7])
        reference, word = place.rsplit(":", 1)
        number, hold = max(0.0, float(found[7])), max(0.0, float(found[8]))
        gripper = min(1.0, number) if word == "opening" else {word: number}
        pose = Pose(tuple(map(float, position)), tuple(map(float, turn)))
        return reference, [RelativeKeyframe(pose, gripper, hold)]

    def graph(self):
        held = {kind: [] for kind in self.kinds}
        edges = []
        for name, before, steps, end in self.shown:
            for index, step in enumerate(steps):
                held[step[0]].append((name, index))
                edges.append((before, step[0]))
                before = step[0]
            if end is not None:
                edges.append((before, "end"))
        edges = sorted(set(edges), key=lambda edge: (edge[0] or "", edge[1]))
        return Graph([Node(kind, held[kind]) for kind in self.kinds], edges)


if __name__ == "__main__":
    serve(Cloning())
