"""The pages of ``stickslip validate --log``: lists of sections, as all pages."""

from stickslip.studies.validate.page.comparison import comparison_sections
from stickslip.studies.validate.page.log import log_sections

__all__ = ["comparison_sections", "log_sections"]
