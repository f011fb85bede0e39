# SPDX-License-Identifier: Apache-2.0
"""Pick with a hand of your own: all that the pick knows of it is its description and step().

Here your hand is the simulated one with a worn thumb, which feels half of each force. A driver
would send the command to the robot instead, and wait for its sensors. hand_in_sapien.py is a hand
in another physics engine.
"""

import palpate
from palpate import sim


class WornThumb(palpate.Hand):
    def __init__(self, inner):
        super().__init__(inner.description)  # with a model file: sim.load_hand("hand.xml")
        self.inner = inner
        self.peak = 0.0

    def step(self, command):
        """Apply the command for one tick of 10 ms; return what was sensed at its end."""
        reading = self.inner.step(command)
        thumb, *others = reading.contacts
        worn = [palpate.TipContact(c.point, c.normal, 0.5 * c.force) for c in thumb]
        self.peak = max([self.peak, *(-c.force @ c.normal for tip in others for c in tip)])
        return palpate.HandReading(
            reading.time, reading.joints, reading.torques, reading.base_xyz, reading.base_ypr,
            reading.base_force, [worn, *others],
        )  # fmt: skip


world = sim.World("box", seed=3)
hand = WornThumb(world.hand)
result = sim.pick("box", hand, seed=3, options={"calibrate.touches": 4, "explore.touches": 2})
print(result)
for phase in result.phases:
    print(f"  {phase.name}: {phase.outcome}, {phase.robot_seconds:.1f} s")
print(f"largest force that a finger felt: {hand.peak:.1f} N")

# The truth is the world's; no hand knows it. It judges the estimate, in the world's frame.
error = result.posterior.error(world.truth())
if error:
    print(f"off the truth by {1e3 * error[1]:.1f} mm")
