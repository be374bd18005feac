"""A drive in other units is the same drive."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.identification.criteria.motion import Scale, scale_of
from stickslip.logs import Recording


def test_common_drives_are_left_alone_and_others_brought_near():
    assert scale_of(np.full(9, 30.0), np.full(9, 0.04)) == Scale()
    scale = scale_of(np.full(9, 0.02), np.full(9, 60.0))
    assert scale.force * 0.02 == pytest.approx(10.0, rel=3.0)
    assert 1e-2 < scale.length * 60.0 < 0.2
    assert np.log10(scale.force) % 1.0 == 0.0
    values = {"m": 2e-4, "b": 1e-4, "F_c": 0.02}
    assert scale.restored(scale.values(values)) == pytest.approx(values)
    assert scale.values(values)["F_c"] == pytest.approx(0.02 * scale.force)


def test_a_recording_is_scaled_and_back():
    t = np.arange(5.0)
    lengths = ("position", "velocity", "position_command", "velocity_command", "added_velocity")
    forces = ("force", "friction", "force_command", "added_force")
    recording = Recording(t, **dict.fromkeys((*lengths, *forces), t + 1.0), encoder_step=0.1)
    there = Scale(10.0, 100.0).recording(recording)
    assert there.encoder_step == pytest.approx(10.0)
    for name in (*lengths, *forces):
        factor = 100.0 if name in lengths else 10.0
        np.testing.assert_allclose(getattr(there, name), factor * (t + 1.0))
    assert Scale(0.1, 0.01).recording(replace(there, force=None)).force is None
