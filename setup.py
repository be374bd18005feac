"""Which folder is which package; all else is in pyproject.toml.

The folders lie side by side in the checkout. Installed, all of them are below ``stickslip``.
"""

import warnings

from setuptools import find_namespace_packages, setup

# A new pip shows this warning about folders named as packages, which here are the packages.
warnings.filterwarnings("ignore", "Editable installation")
FOLDERS = ("cosim", "fmi", "fmucheck", "ga", "models")
BELOW = find_namespace_packages(include=[f"{folder}*" for folder in FOLDERS])

setup(
    package_dir={f"stickslip.{folder}": folder for folder in FOLDERS},
    packages=[
        *find_namespace_packages(include=["stickslip*"]),
        *(f"stickslip.{name}" for name in BELOW),
    ],
)
