"""Many drives learned at once: a table of logs becomes a table of parameters.

table -> a job a drive, run whole in a worker -> learned.json, written as soon as it is there ->
one table and one figure.
"""
