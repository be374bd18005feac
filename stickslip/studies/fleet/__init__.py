"""Many drives learned at once: a table of logs or drive variants becomes a table of parameters.

table -> a job a drive, run whole in a worker -> learned.json, written as soon as it is there ->
one table and one figure. The truth of variants is joined to what was learned, at the very end.
"""

from stickslip.studies.fleet.study import Fleet, learn_fleet
from stickslip.studies.fleet.table import Drive, LogSource, Variant, read_fleet
from stickslip.studies.fleet.writing import fleet_table

__all__ = ["Drive", "Fleet", "LogSource", "Variant", "fleet_table", "learn_fleet", "read_fleet"]
