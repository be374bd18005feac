"""The first lines of a child: ``python start.py SHARED SIZE TOKEN``.

``stickslip.cosim`` would import all it has, which takes longer than many a run; a child needs a
third of it. So it gets an empty package of that name, whose modules it imports one by one; so it
does for ``stickslip.cosim.control``, which would import python-control. An empty module also stands
for the docstrings that NumPy adds to what it has in C, 7 % of the time that its import takes.
"""

import sys
from pathlib import Path
from types import ModuleType

if __name__ == "__main__":
    folder = Path(__file__).parent.parent
    places = {"stickslip.cosim": folder, "stickslip.cosim.control": folder / "control"}
    for name, place in places.items():
        package = ModuleType(name)
        package.__path__ = [str(place)]
        sys.modules[name] = package
    sys.modules["numpy._core._add_newdocs"] = ModuleType("numpy._core._add_newdocs")
    from stickslip.cosim.isolation.child import main

    main(sys.argv[1], int(sys.argv[2]), bytes.fromhex(sys.argv[3]))
