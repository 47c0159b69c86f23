"""The calibration of the fidelity with indentation: stored values are the computed ones, and do their work."""

import math
from dataclasses import replace

import numpy as np
import pytest

import sim.calibration
from dynamics.bench import Stroke
from dynamics.compression import geometry_of
from dynamics.gripper import robotiq_2f85
from models import objects
from sim.bench import Bench
from sim.calibrate import about, calibrated
from sim.calibration import (
    BENCH_DEPTH,
    DEPTHS,
    SHALLOW,
    TABLE,
    bench_factor,
    compute,
    depth_reached,
    factors_of,
    height_above,
    key_of,
    modulus_factor,
    rows_of,
    shorter_side,
    stored,
)
from sim.press import press
from sim.truth import read_truth
from tests.sim.objects import soap, thing

REPRODUCED = 0.02  # relative; a table that is off by more, say by another law of contact, is to be computed anew
TOLERANCE = 0.10  # of a modulus that comes back
DIFFERENT_FIT = 0.06  # by what another way of fitting the same curve differs


def test_table_is_whole_and_says_how_it_was_computed():
    table = stored()
    assert set(table) == {key for key, _ in calibrated()}
    assert all(0.5 < factor < 25 for f in table.values() for factor in (f.bench, *f.hand))
    text = TABLE.read_text()
    assert [line for line in text.splitlines() if line.startswith("#")] == about()
    rows = [",".join(row) for row in rows_of(table.items())]
    assert text.splitlines()[-len(rows) :] == rows


@pytest.mark.parametrize("name", ["soft-cube", "foam-cylinder"])
def test_stored_values_are_reproduced(name):
    truth = read_truth(objects.locate(name))
    check_reproduced(key_of(truth, shorter_side(truth)), truth)


@pytest.mark.slow
def test_every_stored_value_is_reproduced():
    for key, truth in calibrated():
        check_reproduced(key, truth)


def check_reproduced(key, truth):
    found, known = compute(truth, shorter_side(truth)), stored()[key]
    assert found.bench == pytest.approx(known.bench, rel=REPRODUCED)
    assert found.hand == pytest.approx(known.hand, rel=REPRODUCED)


def test_what_is_not_stored_is_pressed_once(monkeypatch):
    truth, pressed = thing("box", size=(0.041, 0.0433, 0.03)), []
    monkeypatch.setattr(sim.calibration, "compute", lambda *a: pressed.append(a) or compute(*a))
    factor = modulus_factor(truth)
    assert modulus_factor(replace(truth, mass=0.3, friction=0.5)) == factor
    assert len(pressed) == 1
    held = press(truth, 0, height_above(truth, 0))
    depth = depth_reached(truth)
    assert depth == DEPTHS[-1]
    assert factor == pytest.approx(held.factor(SHALLOW * depth, depth))


@pytest.mark.parametrize("poisson", [0.0, 0.3])
@pytest.mark.parametrize(
    "size", [(0.056, 0.056, 0.056), (0.08, 0.08, 0.08), (0.06, 0.03, 0.08), (0.03, 0.06, 0.05)]
)
def test_a_box_softens_under_pads_as_the_law_says(size, poisson):
    """Fit F / A = k (e - b e^2) to what is simulated; 0.1 of b are 2 % of the slope a tenth of strain deeper."""
    truth = thing("box", size=size, poisson=poisson)
    pressed = press(truth, shorter_side(truth))
    rows = pressed.strain > 0.02  # in contact with all of the pads
    strain, stress = pressed.strain[rows], pressed.load[rows] / pressed.geometry.area
    offset, slope, bend = np.polynomial.polynomial.polyfit(strain, stress, 2)
    assert abs(offset) < 0.02 * stress[-1]
    assert -bend / slope == pytest.approx(pressed.geometry.softening, abs=0.1)


def test_lengths_poisson_and_surface_make_the_key():
    one = thing("box", poisson=0.3)
    assert key_of(one, 0) == key_of(replace(one, young_modulus=9e5, mass=0.2), 0)
    assert len({key_of(one, 0), key_of(one, 1), key_of(replace(one, poisson=0.2), 0)}) == 3
    mesh = thing("mesh")
    other = replace(mesh, declared=replace(mesh.declared, mesh=soap(mesh.size, 5)))
    assert key_of(mesh, 1) != key_of(other, 1)


def test_a_hand_reaches_as_deep_as_its_force_by_theory():
    soft, hard = thing("sphere", 5e3), thing("sphere", 1e6)
    assert depth_reached(soft) == DEPTHS[-1]
    depth = depth_reached(hard)
    # Two Hertzian contacts, Johnson (1985) eq. 4.23.
    force = 4 / 3 * 1e6 * math.sqrt(0.03) * (depth * 0.06 / 2) ** 1.5
    assert force == pytest.approx(sim.calibration.FORCE, rel=0.03)


def test_factor_is_the_one_where_the_hand_takes_hold():
    """A tall cylinder, held above its middle, under pads at that height: theory gives back its modulus."""
    truth = thing("cylinder", 5e4, poisson=0.3)
    above = height_above(truth, 1)
    assert above > 0.01
    factor, depth = modulus_factor(truth), depth_reached(truth)
    assert factor < 0.9 * factors_of(truth, 1).bench
    bench = Bench(truth, "pads", fidelity="indentation", edge=1, factor=factor, above=above)
    assert fitted(bench, SHALLOW * depth, depth) == pytest.approx(truth.young_modulus, rel=DIFFERENT_FIT)


@pytest.mark.parametrize("young", [5e3, 1e6])
@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere", "ellipsoid", "mesh"])
def test_force_is_that_of_the_theory_for_pads(shape, young):
    """Fitted as the calibration is, at other moduli and masses than its own."""
    truth = replace(thing(shape, young, 0.05 if young < 1e5 else 0.5), poisson=0.3)
    bench = Bench(truth, "pads", fidelity="indentation", edge=1)
    assert fitted(bench, 0.0, BENCH_DEPTH) == pytest.approx(young, rel=TOLERANCE)


@pytest.mark.parametrize("steps", [4, 6])
def test_coarse_meshes_show_no_force_that_is_not_there(steps):
    mesh = thing("mesh", 5e4, poisson=0.3)
    truth = replace(mesh, declared=replace(mesh.declared, mesh=soap(mesh.size, steps)))
    bench = Bench(truth, "pads", fidelity="indentation", edge=1, factor=bench_factor(mesh, 1))
    pressed = bench.press(Stroke(0.02, 0.9 * bench.width))
    force = pressed.force[pressed.rows("compress")]
    assert np.max(force) < 1.05 * force[-1]
    assert pressed.imbalance < 0.05 * force[-1]


def fitted(bench, low, high):
    """Return the modulus that a stroke shows by theory over a range of strains, least squares with an onset."""
    pressed = bench.press(Stroke(0.02, (1 - high) * bench.width))
    rows = pressed.rows("compress")
    strain, force = 1 - pressed.opening[rows] / bench.width, pressed.force[rows]
    strain, force = strain[strain > low], force[strain > low]
    truth = bench.truth
    geometry = geometry_of(
        truth.shape,
        (bench.width, truth.size[1 - bench.edge], truth.size[2]),
        robotiq_2f85("pad"),
        poisson=truth.poisson,
        fill=truth.declared.fill,
    )
    best = (math.inf, 0.0)
    for onset in np.linspace(-0.2 * high, 0.4 * high, 201):
        law = geometry.area * geometry.law_of(strain - onset)
        modulus = float(law @ force / (law @ law))
        best = min(best, (float(np.sum((force - modulus * law) ** 2)), modulus))
    return best[1]
