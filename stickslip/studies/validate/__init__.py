"""``stickslip validate``: what was learned, held against another log or a drive."""
