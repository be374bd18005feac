"""The pages of ``stickslip validate --log``: lists of sections, as all pages."""

from stickslip.report.validated.log import FIGURES, log_sections

__all__ = ["FIGURES", "log_sections"]
