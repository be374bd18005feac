import subprocess
import sys


def test_the_core_needs_neither_cosim_nor_scipy():
    code = "import ga, sys; ga.GeneticAlgorithm; assert not {'cosim', 'scipy'} & {*sys.modules}"
    subprocess.run([sys.executable, "-c", code], check=True)
