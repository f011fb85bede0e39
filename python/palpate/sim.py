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
        EvaluationResult,
        PhaseReport,
        PickResult,
        RelocateTasks,
        World,
        evaluate,
        install_hand,
        load_arm,
        load_hand,
        pick,
        waiting_command,
    )
except ImportError as error:
    raise ImportError(f"palpate.sim needs palpate[sim] or a build with the simulator: {error}") from error

__all__ = [
    "EvaluationResult",
    "PhaseReport",
    "PickResult",
    "RelocateTasks",
    "World",
    "evaluate",
    "install_hand",
    "load_arm",
    "load_hand",
    "pick",
    "waiting_command",
]
