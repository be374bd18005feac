"""modelDescription.xml of FMI 1.0, 2.0 and 3.0: read, and checked as far as a run depends on it.

A description that contradicts itself or the standard raises ``DescriptionFault``.
"""

from stickslip.fmi.description.attributes import DescriptionFault
from stickslip.fmi.description.model import Description
from stickslip.fmi.description.reading import read_description

__all__ = ["Description", "DescriptionFault", "read_description"]
