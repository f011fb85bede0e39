# SPDX-License-Identifier: Apache-2.0
"""Picks in simulation, and with hands of your own: subclass palpate.Hand and give it to pick().

Built where the simulator is (`./dev build`); the base wheel does not hold it.
"""

try:
    from ._sim import (
        EvaluationResult,
        PhaseReport,
        PickResult,
        RelocateTasks,
        World,
        evaluate,
        install_hand,
        load_hand,
        pick,
        waiting_command,
    )
except ImportError as error:
    raise ImportError(f"palpate.sim needs a build with the simulator: {error}") from error

__all__ = [
    "EvaluationResult",
    "PhaseReport",
    "PickResult",
    "RelocateTasks",
    "World",
    "evaluate",
    "install_hand",
    "load_hand",
    "pick",
    "waiting_command",
]
