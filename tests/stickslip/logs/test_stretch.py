"""The stretch of a long log that is learned from."""

import numpy as np

from stickslip.logs import Recording, shortened
from tests.stickslip.logs.rigid_drive import rigid_drive

N, T_s = 400_000, 1e-3


def test_a_long_log_is_cut_to_where_the_drive_moves_and_a_short_one_is_not() -> None:
    telling = rigid_drive(n=4000)
    position = np.zeros(N)
    position[250_000:254_000] = telling.position
    recording = Recording(np.arange(N) * T_s, position, np.arange(N) * 1.0, source="long.csv")
    cut, (note,) = shortened(recording)
    begin = int(cut.force[0])
    assert len(cut.t) == len(cut.position) == 100_000
    assert begin <= 250_000 <= 254_000 <= begin + len(cut.t)
    assert cut.source == "long.csv"
    assert cut.t[0] == 0.0
    assert f"{begin * T_s:.4g} s" in note.figure
    assert shortened(telling) == (telling, ())
