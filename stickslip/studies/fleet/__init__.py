"""Many drives learned at once: a table of logs or drive variants becomes a table of parameters.

table -> a job a drive, run whole in a worker -> learned.json, written as soon as it is there ->
one table and one figure. The truth of variants is joined to what was learned, at the very end.
"""
