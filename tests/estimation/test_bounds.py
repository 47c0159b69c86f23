"""Lower bounds as measurements and as evidence: against numerical integrals, and by what must hold of them."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from dynamics.errors import InvalidInput, UnknownName
from estimation.belief import Belief
from estimation.bounds import ONE_SIDED, bound_of, condition_bound, elasticity_at_least
from estimation.conclude import conclude
from estimation.measurement import Measurement
from estimation.network import LINEAR, LOG, MATERIAL, Network, Property, Unknown
from estimation.size import SizeEstimate

VOLUME = SizeEstimate((0.056,) * 3, (0.0005,) * 3, "box")


def reference(scale):
    """Return a foam of 50 kPa, a rubber of 2 MPa, and something of any modulus."""
    means, sds = ((5e4, 2e6), (1e4, 4e5)) if scale == LINEAR else ((5e4, 2e6), (0.2 * 5e4, 0.2 * 2e6))
    prop = Property("elasticity", MATERIAL, "Pa", scale, means, sds)
    return Network("stiff-or-not", ("foam", "rubber"), (prop,), (0.5, 0.5), unknown=Unknown(0.05))


def test_a_bound_comes_back_from_its_measurement():
    reading = elasticity_at_least(6e5)
    assert reading.unit == "1/Pa"
    quantity, least, unit = bound_of(reading)
    assert (quantity, unit) == ("elasticity", "Pa")
    assert least == pytest.approx(6e5, rel=1e-12)
    assert bound_of(Measurement("elasticity", 6e5, 1e5, "Pa")) is None


@pytest.mark.parametrize("scale", [LINEAR, LOG])
@pytest.mark.parametrize("least", [0.01, 0.7, 1.0, 4.0, 300.0])
@pytest.mark.parametrize(("mean", "sd"), [(1.0, 0.2), (3.0, 2.0), (0.2, 0.01)])
def test_evidence_and_moments_are_the_integrals(scale, least, mean, sd):
    centre, spread = (np.log(mean), sd / mean) if scale == LOG else (mean, sd)

    def log(t):
        x = np.exp(t) if scale == LOG else t
        gaussian = -0.5 * ((t - centre) / spread) ** 2 - np.log(spread * np.sqrt(2 * np.pi))
        return gaussian - 0.5 * (ONE_SIDED * least / x) ** 2

    far = centre + 40 * spread + 2 * least if scale == LINEAR else max(centre, np.log(least)) + 40 * spread
    near = 1e-9 if scale == LINEAR else centre - 40 * spread
    found = minimize_scalar(lambda t: -log(t), bounds=(near, far), method="bounded", options={"xatol": 1e-12})
    peak, top = found.x, log(found.x)
    width = 1 / np.sqrt(max(-(log(peak + 1e-4) - 2 * top + log(peak - 1e-4)) / 1e-8, 1e-6))
    edges = (max(near, peak - 20 * width), peak, min(far, peak + 20 * width))

    def integral(power):
        weighted = lambda t: (t - peak) ** power * np.exp(log(t) - top)  # noqa: E731
        parts = [quad(weighted, a, b, epsabs=0, epsrel=1e-11, limit=400)[0] for a, b in pairwise(edges)]
        return sum(parts)

    mass, first, second = (integral(power) for power in range(3))
    evidence, mean_found, variance = (
        float(value[0]) for value in condition_bound(scale, np.array([centre]), np.array([spread**2]), least)
    )
    assert evidence == pytest.approx(top + np.log(mass), rel=1e-6, abs=1e-6)
    assert mean_found == pytest.approx(peak + first / mass, abs=1e-6 * width)
    assert variance == pytest.approx(second / mass - (first / mass) ** 2, rel=1e-5)


@pytest.mark.parametrize("scale", [LINEAR, LOG])
def test_what_does_not_give_way_is_not_soft(scale):
    blank = Belief(reference(scale))
    before = blank.probabilities("material")
    low = blank.update_bound("elasticity", 1e4, "Pa").probabilities("material")
    high = blank.update_bound("elasticity", 600.0, "kPa").probabilities("material")
    assert low["foam"] == pytest.approx(before["foam"], rel=0.05)
    assert high["foam"] < 1e-3 < 0.5 < high["rubber"]
    assert blank.update_bound("elasticity", 6e5, "Pa").marginal("elasticity").quantile(0.05) > 5e5


@pytest.mark.parametrize("scale", [LINEAR, LOG])
def test_order_does_not_matter_and_the_largest_bound_counts(scale):
    blank = Belief(reference(scale))
    reading = Measurement("elasticity", 1.5e6, 4e5, "Pa")
    one = blank.update(reading).update_bound("elasticity", 2e5, "Pa").update_bound("elasticity", 5e5, "Pa")
    other = blank.update_bound("elasticity", 5e5, "Pa").update_bound("elasticity", 2e5, "Pa").update(reading)
    assert one.probabilities("material") == other.probabilities("material")
    assert one.marginal("elasticity").mean == other.marginal("elasticity").mean
    assert one.bank.mean.tolist() == blank.update(reading).update_bound("elasticity", 5e5, "Pa").bank.mean.tolist()


def test_bounds_survive_a_file():
    belief = Belief(reference(LOG)).update_bound("elasticity", 5e5, "Pa")
    again = Belief.from_json(belief.to_json())
    assert again.probabilities("material") == belief.probabilities("material")
    assert again.to_json() == belief.to_json()


def test_conclusions_learn_from_bounds_where_the_reference_knows_elasticity():
    found = conclude(Belief(reference(LOG)), VOLUME, [elasticity_at_least(6e5)])
    assert found.probabilities("material") == Belief(reference(LOG)).update_bound(
        "elasticity", 6e5, "Pa"
    ).probabilities("material")
    density = Property("density", MATERIAL, "kg/m^3", LINEAR, (50.0, 900.0), (10.0, 90.0))
    other = Belief(Network("heavy-or-not", ("foam", "rubber"), (density,), (0.5, 0.5)))
    assert conclude(other, VOLUME, [elasticity_at_least(6e5)]).to_json() == other.to_json()


def test_bad_bounds_are_refused():
    blank = Belief(reference(LOG))
    for least in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInput, match="bound of elasticity"):
            blank.update_bound("elasticity", least, "Pa")
    with pytest.raises(InvalidInput):
        blank.update_bound("elasticity", 1.0, "kg")
    with pytest.raises(UnknownName):
        blank.update_bound("stiffness", 1.0, "Pa")
