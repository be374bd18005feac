import subprocess
import sys


def test_the_core_needs_neither_cosim_nor_scipy():
    code = (
        "import sys; from stickslip import ga; ga.GeneticAlgorithm; "
        "assert not {'stickslip.cosim', 'scipy'} & {*sys.modules}"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
