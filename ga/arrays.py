"""The array type that all of this package speaks: float64."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
