"""``stickslip compare``: several learned drives beside each other."""
