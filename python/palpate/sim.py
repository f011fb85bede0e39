# SPDX-License-Identifier: Apache-2.0
"""Picks in simulation, and with hands of your own: subclass palpate.Hand and give it to pick().

`pip install palpate[sim]` adds it, or `./dev build` in a checkout; the base wheel does without.
"""

import importlib.util as _util
import os as _os
import pathlib as _pathlib

_assets = _pathlib.Path(__file__).parent / "assets"  # of an installed palpate-sim
if _assets.is_dir():
    _os.environ.setdefault("PALPATE_ASSETS", str(_assets))
_hands = _util.find_spec("palpate_hands")  # models of palpate[hands]
if _hands and _hands.submodule_search_locations:
    _os.environ.setdefault("PALPATE_HANDS", _hands.submodule_search_locations[0])

try:
    from ._sim import (
        CollisionScene,
        EvaluationResult,
        PhaseReport,
        PickResult,
        PlaceResult,
        Plan,
        RelocateTasks,
        World,
        evaluate,
        install_hand,
        load_arm,
        load_hand,
        pick,
        plan,
        waiting_command,
    )
except ImportError as error:
    raise ImportError(f"palpate.sim needs palpate[sim] or a build with the simulator: {error}") from error

#: Options of a world that is as the robot believes, but for noisy readings and 2 mm of error per
#: link, as configs/ideal.toml has them: `sim.pick(options=sim.IDEAL | {"lift.height": 0.15})`.
IDEAL = {
    "start.uncertainty": 0.02,
    "world.hand_friction": 0.8,
    "world.table_friction": 0.5,
    "world.noise.load": 0.02,
    "expert.world.noise.mount": 0.0,
    "expert.world.noise.mount_angle": 0.0,
    "expert.world.noise.mount_delay": 0.0,
    "expert.world.noise.touch_delay": 0.0,
    "expert.world.noise.touch_threshold": 0.0,
    "expert.world.error.mount": 0.0,
    "expert.world.error.mount_angle": 0.0,
    "expert.world.error.table_height": 0.0,
    "expert.world.error.table_tilt": 0.0,
    "expert.world.error.load_bias": 0.0,
    "expert.world.error.load_drift": 0.0,
    "expert.world.error.hand_weight": 0.0,
    "expert.world.error.torque": 0.0,
    "expert.world.error.torque_friction": 0.0,
    "expert.world.error.friction": 0.0,
    "expert.world.error.mass": 0.0,
    "expert.world.error.center": 0.0,
    "expert.world.error.scale": 0.0,
    "expert.world.error.surface": 0.0,
}

__all__ = [
    "IDEAL",
    "CollisionScene",
    "EvaluationResult",
    "PhaseReport",
    "PickResult",
    "PlaceResult",
    "Plan",
    "RelocateTasks",
    "World",
    "evaluate",
    "install_hand",
    "load_arm",
    "load_hand",
    "pick",
    "plan",
    "waiting_command",
]
