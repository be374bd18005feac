"""The section with which the page on a log opens."""

import re

import numpy as np

from stickslip.evaluation.tracking import FEEDFORWARD, FRICTIONLESS, NONE, Tracking, TrackingError
from stickslip.presentation.page import Picture
from stickslip.studies.learn.page.tracking import tracking_section, window


def tracked(measured=None):
    """A sine whose velocity error is 2, 1 and 0.5 mm/s, and ten times as large for a while."""
    t = np.arange(2000) * 1e-3
    v_cmd = 0.02 * np.sin(5.0 * t)
    shape = np.where((t > 1.2) & (t < 1.25), 10.0, 1.0) * 1e-3
    sizes = {NONE: 2.0, FEEDFORWARD: 1.0, FRICTIONLESS: 0.5}
    velocity = {name: v_cmd + size * shape for name, size in sizes.items()}
    position = {name: size * 1e-5 * np.ones_like(t) for name, size in sizes.items()}
    words = ("the log's PI controller", "the log's own command")
    return Tracking(t, v_cmd, velocity, position, slice(0, None), *words, True, measured)


def words(section, picture=Picture.of):
    pictures = {name: picture(draw) for name, draw in section.figures.items()}
    return re.sub("<[^>]*>", "|", section.markup(pictures)).replace("\u00a0", " ")


def test_the_section_labels_measured_and_simulated_and_names_loop_and_command():
    measured = TrackingError(2.1e-3, 2.2e-2, 2e-5, 3e-5)
    text = words(tracking_section(tracked(measured), "linear"))
    for label in ("Measured, log", "Simulated, without", "Simulated, with", "50 %"):
        assert label in text
    assert "in the loop of the log’s PI controller" in text
    unmeasured = tracking_section(tracked(), "linear")
    assert "Measured" not in words(unmeasured, lambda _: Picture(b"", b"", 89.0))


def test_the_detail_is_where_compensation_changes_most():
    part = window(tracked())
    assert part.start / 1e3 < 1.25
    assert part.stop / 1e3 > 1.2
