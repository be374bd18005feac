"""All compensators on all drives under the same conditions: ``stickslip arena``.

    drives, entrants -> tuned from measured signals (``tuning.py``)
    -> validated on other commands (``validation.py``) -> cells, kept one by one (``protocol.py``)
    -> arena.csv.gz (``table.py``), arena.html (``page.py``)

Drives and entrants are data: ``drives.toml``, ``entrants.toml``, and every law and compensator of
``models`` that these do not name. What tunes sees the encoder and the motor force of a drive only;
the truth of a drive is in the start values of its FMU.
"""
