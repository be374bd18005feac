import pytest

from stickslip import ga


def test_the_preset_paper_is_table_3():
    paper = ga.PRESETS["paper"]
    assert (paper.population, paper.generations, paper.elites) == (10, 100, 2)
    assert (paper.mutation_rate, paper.resolution, paper.encoding) == (0.15, 1e-4, "linear")


def test_the_default_preset_is_the_default():
    assert ga.PRESETS["default"] == ga.DEFAULT == ga.Settings()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("population", 3),
        ("generations", 0),
        ("elite_rate", 1.0),
        ("elite_rate", -0.1),
        ("mutation_rate", 1.5),
        ("crossover_rate", float("nan")),
        ("k1", -1.0),
        ("near_share", 2.0),
        ("near_spread", 0.0),
        ("resolution", 0.0),
        ("threshold", -1.0),
        ("crossover", "magic"),
        ("encoding", "binary"),
        ("survival", "all"),
        ("mutation", "none"),
        ("patience", 0),
        ("restarts", -1),
    ],
)
def test_a_setting_out_of_range_is_named(field, value):
    with pytest.raises(ga.SettingsError, match=f"{field} must be .*, got"):
        ga.Settings(**{field: value})


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ((1.0, 1.0, 1.0), "lower must be below upper"),
        ((0.0, 1.0, 2.0), "start 2.0 is outside"),
        ((0.0, float("inf"), 1.0), "upper must be finite"),
    ],
)
def test_a_gene_of_impossible_bounds_is_named(bounds, message):
    with pytest.raises(ga.SettingsError, match=f"gene F_c: {message}"):
        ga.Gene("F_c", *bounds)


@pytest.mark.parametrize("names", [[], ["a", "a"]])
def test_genes_need_names_of_their_own(names):
    with pytest.raises(ga.SettingsError, match="each with its own name"):
        ga.GeneticAlgorithm([ga.Gene(name, 0.1, 1, 0.5) for name in names])
