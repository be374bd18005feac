"""Arguments of the wrong shape, kind and value in Python."""

from tests.corpus.hostile.case import Case, python
from tests.corpus.hostile.sound import sound


def _python(name: str, about: str, says: str, code: str) -> Case:
    return python(26, name, about, says, code, **{"a_fmu": sound} if "a.fmu" in code else {})


_TIMES = '"a.fmu", step=0.1, stop=1.0'
_SYSTEM = 's = ss.System("s"); s.add("a", "a.fmu"); s.expose("u", "a.u")\n'


def _driven(name: str, about: str, says: str, signal: str) -> Case:
    code = f'ss.simulate({_TIMES}, inputs={{"u": {signal}}})'
    return _python(f"input-{name}", f"an input that is {about}", says, code)


def _swept(name: str, about: str, says: str, parameters: str, figures: str) -> Case:
    code = f"ss.sweep({_TIMES.replace(',', f', {parameters}, {figures},', 1)})"
    return _python(f"sweep-{name}", f"a sweep {about}", says, code)


def _optimised(name: str, about: str, says: str, ranges: str, cost: str, more: str = "") -> Case:
    times = _TIMES.replace(",", f", {ranges}, {cost},", 1)
    code = f"ss.optimise({times}, evaluations=20{more})"
    return _python(f"search-{name}", f"a search {about}", says, code)


_ONE = '{"f": lambda result: 1.0}'
CASES = [
    _python("table-text", "a table of words", "values of a table: expected numbers, got", 'ss.Table([0, 1], ["on", "off"])'),
    _python("inputs-file", "a file's name in place of inputs", "inputs: expected a dictionary .*read_tables .* or a data frame, got", f'ss.simulate({_TIMES}, inputs="in.csv")'),
    _python("inputs-frame", "a DataFrame with NaN as inputs", "the data frame: a table holds a time or value that is not finite", f'ss.simulate({_TIMES}, inputs=pd.DataFrame({{"time": [0.0, 1.0], "u": [1.0, np.nan]}}))'),
    _driven("frame", "a DataFrame", "expected a signal, .*got a DataFrame; give the data frame itself", 'pd.DataFrame({"time": [0, 1], "u": [1, 2]})'),
    _driven("column", "a column of 11 rows of one value", r"has the shape \(11, 1\)", "np.ones((11, 1))"),
    _driven("fall", "a trapezoid of negative slope, whose times would fall", "expected a slope above 0", "ss.Trapezoid(1.0, -1.0, 0.1)"),
    _driven("back", "a sweep of -1 s, which would be silent", "a positive duration", "ss.SineSweep((1.0, 2.0), (1.0, 1.0), -1.0)"),
    _python("stop-text", "a stop that is text", "stop is '1', expected a number", 'ss.simulate("a.fmu", step=0.1, stop="1")'),
    _swept("scalar", "of a number in place of values", "k: expected its values in a list, got 5", '{"k": 5}', _ONE),
    _swept("text", "of a word", "k: expected a value of type Real, got 'a'", '{"k": [1, "a"]}', _ONE),
    _swept("twice", "of one parameter under two names", "a parameter comes twice", '{"k": [1], "reference.k": [2]}', _ONE),
    _swept("column", "with a figure named as a parameter, which would replace its column", "figure 'k': has the name of another column", '{"k": [1]}', '{"k": lambda result: 1.0}'),
    _swept("figure", "with a figure that is a vector", "figure 'f': expected a number, got array", '{"k": [1]}', '{"f": lambda result: result["reference.y"]}'),
    _optimised("none", "for a cost that is nothing", "the cost: expected a number, got None", '{"k": (0, 1, 2)}', "lambda result: None"),
    _optimised("range", "between words", "k: expected a number, got 'a'", '{"k": ("a", 1, 2)}', "lambda result: 1.0"),
    _optimised("seed", "with a seed of -1", "seed = -1: expected whole numbers", '{"k": (0, 1, 2)}', "lambda result: 1.0", ", seed=-1"),
    _python("law-nan", "a law that runs for NaN s", "stop = nan s and step = 0.0001 s: expected positive numbers", 'ss.run_law("lugre", velocity=1.0, stop=np.nan)'),
    _python("law-years", "a law that runs for 30 years", "at most 1e\\+08 steps", 'ss.run_law("lugre", position=1.0, stop=1e9)'),
    _python("law-text", "a parameter of a law that is text", "F_s: expected a number, got 'much'", 'ss.run_law("lugre", velocity=1.0, stop=1.0, parameters={"F_s": "much"})'),
    _python("frequencies-none", "a response at no frequency", "frequencies: expected one or more, got none", f'{_SYSTEM}ss.measure_response(s, "u", ["a.y"], [], 1.0, step=0.1)'),
    _python("axis-text", "a mass that is text", "m is '5'; expected a number", 'ss.Axis("5", 20.0)'),
    _python("limits-one", "a range that is one number", "frequency = 5.0: expected two numbers", "ss.Limits(frequency=5.0)"),
    _python("plan-letters", "one parameter, of which each letter would be one", "cannot show 'F_c': expected a list of", 'ss.plan(ss.Limits(), show="F_c")'),
    _python("description-column", "a column that is a number", "columns: time: expected a Column, got 5", 'ss.Description(columns={"time": 5})'),
    _python("description-span", "a span of words", "span = .* expected begin and end, in s", 'ss.Description(span=("a", "b"))'),
]  # fmt: skip
