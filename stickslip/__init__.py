"""The application: learns a friction compensator for a servo drive, and reproduces the paper.

StickslipError                    drawn in ``stickslip/errors.py``
"""
