"""What ``stickslip learn`` makes of faulty logs of drives with any friction law."""

from campaigns.fault_matrix.drives import DRIVES, Drive
from campaigns.fault_matrix.faults import FAULTS, Fault
from campaigns.fault_matrix.recordings import SOUND, Experiment, record

__all__ = ["DRIVES", "FAULTS", "SOUND", "Drive", "Experiment", "Fault", "record"]
