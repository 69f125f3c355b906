"""Scenes that the tests of the package share."""

from pathlib import Path

import sphecs

ROOT = Path(__file__).resolve().parents[2]
QUICKSTART = ROOT / "scenes" / "quickstart.ron"


def channel(**changes):
    """Returns a channel of 160 fluid particles as a dictionary, with other fields."""
    scene = {
        "title": "Channel",
        "dimensions": 2,
        "spacing": 0.05,
        "precision": "F64",
        "constants": {"U": 0.1},
        "fluid": {"density": 1000.0, "viscosity": 1e-3, "sound_speed": 2.0},
        "domain": {"Box": {"min": (0, 0), "max": (1, 0.4)}},
        "walls": {"slip": "FreeSlip"},
        "inlets": [{"at": (0, 0.2), "towards": (1, 0), "velocity": {"Normal": "U"}}],
        "outlets": [{"at": (1, 0.2), "towards": (1, 0), "condition": sphecs.variant("WaveEquation")}],
        "time": {"end": 1},
        "output": {"every": 0.1},
    }
    return scene | changes


def box(**changes):
    """Returns a box of fluid at rest, periodic in both directions."""
    return channel(inlets=None, outlets=None, walls=None, periodic=["x", "y"], **changes)
