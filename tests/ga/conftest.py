import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # friction_sweep and problems; workers import them
