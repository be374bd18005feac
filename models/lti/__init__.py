"""Linear systems of python-control as FMUs."""
