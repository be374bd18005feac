"""What ``stickslip learn`` makes of faulty logs of drives with any friction law."""

from campaigns.fault_matrix.drives import DRIVES, SOUND, Drive, Experiment, record
from campaigns.fault_matrix.faults import FAULTS, Fault

__all__ = ["DRIVES", "FAULTS", "SOUND", "Drive", "Experiment", "Fault", "record"]
