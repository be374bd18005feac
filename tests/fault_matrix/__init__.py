"""What ``stickslip learn`` makes of faulty logs of drives with any friction law."""

from tests.fault_matrix.drives import DRIVES, Drive
from tests.fault_matrix.faults import FAULTS, Fault
from tests.fault_matrix.recordings import SOUND, Experiment, record

__all__ = ["DRIVES", "FAULTS", "SOUND", "Drive", "Experiment", "Fault", "record"]
