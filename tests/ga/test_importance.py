"""Importances of genes: the share of the cost's rank that each explains."""

import pandas as pd

from stickslip import ga


def test_the_gene_that_decides_is_the_important_one():
    table = pd.DataFrame({"a": range(64), "b": [k * 37 % 64 for k in range(64)]}, dtype=float)
    for scale in (lambda x: x, lambda x: 10.0**x):  # ranks do not depend on the scale
        table["cost"] = [scale(abs(a - 20.0) / 10.0) for a in table["a"]]
        shares = ga.importances(table, ["b", "a"])
        assert list(shares) == ["a", "b"]
        assert shares["a"] > 0.8
        assert shares["b"] < 0.2
