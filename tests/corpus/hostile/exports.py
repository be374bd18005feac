"""Names and forms in which nothing can be exported."""

from functools import partial

from tests.corpus.hostile.case import Case, python
from tests.corpus.hostile.sound import sound

_python = partial(python, 28)
_SYSTEM = 's = ss.System("s"); s.add("a", "a.fmu")\n'


def _container(name: str, about: str, says: str, arguments: str) -> Case:
    """Return a case of a system of one FMU that is to become an FMU."""
    code = f'{_SYSTEM}ss.write_fmu(s, "s.fmu", {arguments})'
    return _python(f"container-{name}", f"a container {about}", says, code, a_fmu=sound)


def _named(name: str, about: str, called: str, language: str = "c") -> Case:
    code = f'ss.write_compensator("out", "{language}", called="{called}")'
    return _python(
        f"source-{name}", f"code named {about}", "(?:cannot name a model|is a word of)", code
    )


CASES = [
    _named("up", "../x, outside its folder", "../x"),
    _named("blank", "a b, which is no C", "a b"),
    _named("word", "REAL, a type of structured text", "REAL", "st"),
    _container("iterative", "that would repeat steps, and would not have", "coupling is 'iterative', expected 'gauss_seidel' or 'jacobi'", 'step=0.1, coupling="iterative"'),
    _container("step", "with an infinite step", "step is inf s, expected a positive number", "step=np.inf"),
    _container("enumeration", "with an enumeration as parameter", "'a.mode' matches nothing that a container can expose", 'step=0.1, parameters=["a.mode"]'),
    _python("source-language", "code in a language that there is not", "language is 'fortran'; expected 'c', 'st', 'plcopen'", 'ss.write_compensator("out", "fortran")'),
    _python("fmu-up", "an FMU named ../../x", "'../../x' cannot name a model", 'ss.build_fmu("stage", "out", called="../../x")'),
    _python("fmu-version", "an FMU of FMI 1.0", "fmi is 1; expected 2 or 3", 'ss.build_fmu("stage", "out", fmi=1)'),
    _python("fmu-start", "an FMU whose mass is a list", "m: expected a number, got \\[1, 2\\]", 'ss.build_fmu("stage", "out", start={"m": [1, 2]})'),
]  # fmt: skip
