"""The block diagram of a system: all is drawn, nothing lies upon another."""

from __future__ import annotations

import itertools
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from stickslip import cosim

SVG = "{http://www.w3.org/2000/svg}"


def system(seed: int) -> cosim.System:
    """Return components in random circles and chains, with exposed inputs and outputs."""
    rng = np.random.default_rng(seed)
    names = [f"part{k}" for k in range(rng.integers(1, 9))]
    made = cosim.System(f"s{seed}")
    for name in names:
        inputs, outputs = ({f"{way}{k}": None for k in range(3)} for way in ("in", "out"))
        made.add(name, cosim.Function(lambda t, u: dict.fromkeys(outputs, t), inputs, outputs))  # noqa: ARG005, B023
    for name, k in itertools.product(names, range(3)):
        if rng.random() < 0.5:
            made.connect(f"{rng.choice(names)}.out{rng.integers(3)}", f"{name}.in{k}")
        elif rng.random() < 0.5:
            made.expose(f"<{name}&{k}>", f"{name}.in{k}")
    made.expose_output("last", f"{names[-1]}.out0")
    return made


@pytest.mark.parametrize("seed", range(20))
def test_every_box_and_wire_is_drawn_and_boxes_are_apart(seed):
    made = system(seed)
    drawing = ET.fromstring(made.diagram())  # noqa: S314 - our own
    titles = {one.text for one in drawing.iter(f"{SVG}title")}
    wires = {f"{source} to {target}" for target, source in made.connections.items()}
    wires |= {f"{name} to {one}" for name, targets in made.inputs.items() for one in targets}
    wires |= {f"{source} to {name}" for name, source in made.outputs.items()}
    assert titles == wires
    boxes = [
        {key: float(box.get(key)) for key in ("x", "y", "width", "height")}
        for box in drawing.iter(f"{SVG}rect")
    ]
    assert len(boxes) == len(made.components) + len(made.inputs) + len(made.outputs)
    for one, other in itertools.combinations(boxes, 2):
        beside = one["x"] + one["width"] <= other["x"] or other["x"] + other["width"] <= one["x"]
        above = one["y"] + one["height"] <= other["y"] or other["y"] + other["height"] <= one["y"]
        assert beside or above
    _, _, width, height = (float(x) for x in drawing.get("viewBox").split())
    assert all(b["x"] + b["width"] <= width and b["y"] + b["height"] <= height for b in boxes)
    assert made.diagram() in made._repr_html_()


def test_an_empty_system_has_a_diagram():
    ET.fromstring(cosim.System().diagram())  # noqa: S314 - our own
