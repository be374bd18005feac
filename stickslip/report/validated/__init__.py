"""The pages of ``stickslip validate --log``: lists of sections, as all pages."""

from stickslip.report.validated.comparison import comparison_sections
from stickslip.report.validated.log import log_sections

__all__ = ["comparison_sections", "log_sections"]
