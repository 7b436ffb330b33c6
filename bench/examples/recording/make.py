"""Makes the example of a recording: an arm puts a cup on a saucer, told ten times a second.

    python3 make.py > saucer.csv

Episodes 0 and 1 are demonstrations. In episode 2 a policy has taken the cup and is on its way to where the saucer was;
the saucer stands elsewhere, and a person leads the hand there (the column `human`).
"""

import math
import sys

RATE = 10.0  # frames a second
SPEED = 0.25  # metres a second
OPEN, ROUND_CUP = 0.08, 0.06  # metres between the fingers
HEADER = "episode,t,x,y,z,qw,qx,qy,qz,width,cup_x,cup_y,cup_z,saucer_x,saucer_y,saucer_z,human"


class Arm:
    """The hand, the cup and the saucer, frame by frame."""

    def __init__(self, episode, cup, saucer):
        self.episode, self.cup, self.saucer = episode, list(cup), list(saucer)
        self.hand, self.turn, self.width, self.holds = [0.40, 0.00, 0.40], 0.0, OPEN, False
        self.human, self.frames = 0, []
        self.tell()

    def tell(self):
        half = self.turn / 2.0
        # The hand looks down, turned about the vertical.
        quaternion = [0.0, math.cos(half), math.sin(half), 0.0]
        row = [*self.hand, *quaternion, self.width, *self.cup, *self.saucer]
        numbers = ",".join(f"{value + 0.0:.4f}" for value in row)
        self.frames.append(f"{self.episode},{len(self.frames) / RATE:.1f},{numbers},{self.human}")

    def move(self, to, turn=None, share=1.0):
        start, first = list(self.hand), self.turn
        turn = first if turn is None else turn
        steps = max(1, round(math.dist(start, to) / SPEED * RATE))
        for step in range(1, round(steps * share) + 1):
            part = step / steps
            self.hand = [a + (b - a) * part for a, b in zip(start, to)]
            self.turn = first + (turn - first) * part
            if self.holds:
                self.cup = [self.hand[0], self.hand[1], self.hand[2] - 0.02]
            self.tell()

    def grip(self, width):
        start = self.width
        for step in range(1, 4):
            self.width = start + (width - start) * step / 3
            self.tell()
        self.holds = width < OPEN

    def take(self):
        x, y, z = self.cup
        self.move([x, y, z + 0.20], 0.3)
        self.move([x, y, z + 0.02])
        self.grip(ROUND_CUP)
        self.move([x, y, z + 0.22])

    def put(self):
        x, y, z = self.saucer
        self.move([x, y, z + 0.22], 0.0)
        self.move([x, y, z + 0.05])
        self.grip(OPEN)
        self.move([x, y, z + 0.25])


def recording():
    lines = [HEADER]
    starts = [((0.50, 0.15, 0.05), (0.45, -0.20, 0.01)), ((0.55, 0.10, 0.05), (0.50, -0.22, 0.01))]
    for episode, (cup, saucer) in enumerate(starts):
        arm = Arm(episode, cup, saucer)
        arm.take()
        arm.put()
        lines += arm.frames
    arm = Arm(2, (0.52, 0.12, 0.05), (0.62, -0.10, 0.01))
    arm.take()
    arm.move([0.47, -0.21, 0.23], 0.0, share=0.6)
    arm.human = 1
    arm.put()
    return "\n".join(lines + arm.frames) + "\n"


if __name__ == "__main__":
    sys.stdout.write(recording())
