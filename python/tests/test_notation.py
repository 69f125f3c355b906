"""Scenes written as dictionaries: the text that the engine reads."""

import math

import numpy as np
import pytest
import sphecs
from scenes import channel
from sphecs._notation import scene_text, sets_of, text_of


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (np.bool_(False), "false"),
        (3, "3"),
        (np.int64(-2), "-2"),
        (0.1, "0.1"),
        (np.float32(0.5), "0.5"),
        (1e-5, "1e-05"),
        ("2*D", '"2*D"'),
        ('a "b" \\', '"a \\"b\\" \\\\"'),
        ((0, "L"), '(0, "L")'),
        ([1.5], "[1.5]"),
        (np.array([0.0, 1.0]), "(0.0, 1.0)"),
        (np.array([[0.0, 1.0], [2.0, 3.0]]), "[(0.0, 1.0), (2.0, 3.0)]"),
        ({"density": 1000.0, "left_out": None}, "(density: 1000.0)"),
        ({"WaveEquation": {}}, "WaveEquation()"),
        ({"WaveEquation": None}, "WaveEquation"),
        ({"Normal": 0.1}, "Normal(0.1)"),
        ({"Components": (0.1, 0.0)}, "Components((0.1, 0.0))"),
        ({"Union": [{"Box": {"min": (0, 0), "max": (1, 1)}}]}, "Union([Box(min: (0, 0), max: (1, 1))])"),
        (sphecs.variant("Off"), "Off()"),
        (sphecs.variant("Extrude", "z", 2), 'Extrude("z", 2)'),
        (sphecs.variant("Box", min=(0, 0), max=(1, 1)), "Box(min: (0, 0), max: (1, 1))"),
    ],
)
def test_values_have_their_text(value, text):
    assert text_of(value) == text


def test_capital_letters_name_constants_and_not_choices():
    assert 'constants: {"D": 0.04}' in scene_text({"constants": {"D": 0.04}})


def test_values_without_a_text_are_refused_with_their_place():
    with pytest.raises(TypeError, match=r"fluid.density: is of type object"):
        scene_text({"fluid": {"density": object()}})
    with pytest.raises(ValueError, match=r"fluid.density: is nan, must be finite"):
        scene_text({"fluid": {"density": math.nan}})
    with pytest.raises(ValueError, match="has a field `sound speed`"):
        scene_text({"fluid": {"sound speed": 1}})
    with pytest.raises(ValueError, match="one kind"):
        sphecs.variant("Box", 1, min=2)


def test_changes_take_text_as_the_command_line_does():
    assert sets_of({"precision": "F32", "fluid.sound_speed": 2, "body_force": (0.0, "-y")}) == [
        ("precision", "F32"),
        ("fluid.sound_speed", "2"),
        ("body_force", '(0.0, "-y")'),
    ]
    with pytest.raises(TypeError, match="dictionary"):
        sets_of([("spacing", 1)])


def test_a_dictionary_is_the_scene_of_its_text():
    by_dictionary = sphecs.Simulation(channel(), threads=1)
    by_text = sphecs.Simulation(
        """Scene(
            title: "Channel", dimensions: 2, spacing: 0.05, precision: F64, constants: {"U": 0.1},
            fluid: (density: 1000.0, viscosity: 0.001, sound_speed: 2.0),
            domain: Box(min: (0, 0), max: (1, 0.4)),
            walls: (slip: FreeSlip),
            inlets: [(at: (0, 0.2), towards: (1, 0), velocity: Normal("U"))],
            outlets: [(at: (1, 0.2), towards: (1, 0), condition: WaveEquation())],
            time: (end: 1), output: (every: 0.1),
        )""",
        threads=2,
    )
    for simulation in (by_dictionary, by_text):
        simulation.step(20)
    assert by_dictionary.time == by_text.time
    np.testing.assert_array_equal(by_dictionary.state.position, by_text.state.position)
    np.testing.assert_array_equal(by_dictionary.state.velocity, by_text.state.velocity)
