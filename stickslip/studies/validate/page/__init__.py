"""The pages of ``stickslip validate --log``: lists of sections, as all pages."""
