"""The application: learns a friction compensator for a servo drive, and reproduces the paper.

StickslipError(Exception)         drawn in ``stickslip/errors.py``
"""
