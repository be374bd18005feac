"""Contacts of the LuGre law that the tests share."""

from hypothesis import strategies as st

TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
"""The paper's."""

_factor = st.floats(-1.0, 2.0).map(lambda e: 10.0**e)
contacts = st.fixed_dictionaries(dict.fromkeys(TABLE_2, _factor)).map(
    lambda factors: {name: factors[name] * value for name, value in TABLE_2.items()}
)
"""Those of 0.1 to 100 times its parameters."""
