"""umax.fit: what the program fits."""
import os
import pathlib

import numpy as np
import pytest
import umax

MEASURED = pathlib.Path(os.environ["UMAX_SOURCE_DIR"]) / "scenes" / "measurements"


def test_a_stiffness_and_a_limit_are_found_again():
    stress = np.array([2.0, 4, 6, 8, 10, 14, 18])  # kPa
    stretch = np.minimum(stress / 100, 0.08) * 100  # of 100 kPa that ends at 8 %
    fit = umax.fit({"stretch [%]": stretch, "stress [kPa]": stress})
    assert fit.young == pytest.approx(1e5, rel=0.05) and fit.young_interval[0] <= fit.young <= fit.young_interval[1]
    assert fit.limit == pytest.approx(0.08, rel=0.05)
    assert fit.rms < 0.005 and "limit.stretch" in fit.toml and "young" in repr(fit)


def test_data_that_do_not_do_are_refused():
    for wrong, part in [({"stretch [%]": [1, 2]}, "stress|force|load"), ({"stretch [%]": [1], "stress [kPa]": [1, 2]}, "length"),
                        ({}, ""), ("nowhere.csv", "nowhere.csv")]:
        with pytest.raises(umax.Error, match=part):
            umax.fit(wrong)
    with pytest.raises(umax.Error, match="test"):
        umax.fit({"stretch [%]": [1, 2, 3], "stress [kPa]": [1, 2, 3]}, test="bend")
    with pytest.raises(umax.Error, match="length"):
        umax.fit({"displacement [mm]": [1, 2, 3], "stress [kPa]": [1, 2, 3]}, length="50 kg")
