# SPDX-License-Identifier: Apache-2.0
"""Pick with a hand of your own: all that the pick knows of it is its description and step().

Here your hand is the simulated one with a worn thumb, which senses half of each force. A driver
would send the command to the robot instead, and wait for its sensors. hand_in_sapien.py is a hand
in another physics engine.

usage: own_hand.py [--figure FILE]
"""

import argparse

import palpate
from palpate import sim


class WornThumb(palpate.Hand):
    def __init__(self, inner):
        super().__init__(inner.description)  # with a model file: sim.load_hand("hand.xml")
        self.inner = inner
        self.sensed = []  # time, s, and each finger's normal force, N

    def step(self, command):
        """Apply the command for one tick of 10 ms; return what was sensed at its end."""
        reading = self.inner.step(command)
        thumb, *others = reading.contacts
        worn = [palpate.TipContact(c.point, c.normal, 0.5 * c.force) for c in thumb]
        forces = [sum(-c.force @ c.normal for c in tip) for tip in (worn, *others)]
        self.sensed.append((reading.time, *forces))
        return palpate.HandReading(
            reading.time, reading.joints, reading.torques, reading.mount_xyz, reading.mount_ypr,
            reading.mount_force, [worn, *others],
        )  # fmt: skip


arguments = argparse.ArgumentParser()
arguments.add_argument("--figure", help="draw phases and forces into this file, with matplotlib")
given = arguments.parse_args()
world = sim.World("box", seed=3)
hand = WornThumb(world.hand)
result = sim.pick("box", hand, seed=3, options={"calibrate.touches": 4, "explore.touches": 2})
print(result)
for phase in result.phases:
    print(f"  {phase.name}: {phase.outcome}, {phase.robot_seconds:.1f} s")
peak = max(max(forces) for _, *forces in hand.sensed)
print(f"largest force that a finger sensed: {peak:.1f} N")

# The truth is the world's; no hand knows it. It judges the estimate, in the world's frame.
error = result.posterior.error(world.truth())
if error:
    print(f"off the truth by {1e3 * error[1]:.1f} mm")


def draw(file):
    """When each finger sensed what, and in which phase."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(10, 4), layout="constrained")
    time, *forces = zip(*hand.sensed)
    for finger, force in zip(hand.description.fingers, forces):
        axes.plot(time, force, label=finger.name, linewidth=0.8)
    begin = 0.0
    for number, phase in enumerate(phase for phase in result.phases if phase.robot_seconds > 1):
        end = begin + phase.robot_seconds
        axes.axvspan(begin, end, color="black", alpha=0.04 + 0.06 * (number % 2), linewidth=0)
        axes.text(begin, peak, phase.name, rotation=90, va="top", fontsize=8)
        begin = end
    axes.set(xlabel="time, s", ylabel="normal force, N", title=repr(result))
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    figure.savefig(file, dpi=120)


if given.figure:
    draw(given.figure)
