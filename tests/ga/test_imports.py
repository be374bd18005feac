import subprocess
import sys


def test_the_core_needs_no_cosim():
    code = "import ga, sys; ga.GeneticAlgorithm; assert 'cosim' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
