"""Explorations over a bank of readings, without simulating."""

from __future__ import annotations

import numpy as np
import pytest

from dynamics.objects import read_declared
from estimation.belief import Belief
from estimation.conclude import conclude
from estimation.measurement import Measurement
from estimation.network import Network
from estimation.size import SizeEstimate
from selection.trials.bank import Reading
from selection.trials.emulator_study import cubes, emulator_cells
from selection.trials.explore import Trace
from selection.trials.objects import trial_rng
from selection.trials.replay import POLICIES, STEPS, ReplayJob, explore_readings, material_of, run_job
from selection.trials.simulation_study import protocol_cells, replayed_explorations
from selection.trials.simulation_tables import object_table, policy_table, verdict
from selection.trials.specimens import EDGE, A, B, listed, novel, on_disk
from selection.trials.sweep import Machines

NETWORK = Network.from_file("soft-cubes")
SPECIMENS = {specimen.name: specimen for specimen in (*listed(), *novel())}


def bank_of(mass: float, modulus: float, count: int = 3) -> dict[str, tuple[Reading, ...]]:
    """Return readings as good as the simulated arm's."""
    rng = np.random.default_rng(int(1e6 * mass))
    weighs = [Measurement("mass", mass + 0.0015 * rng.standard_normal(), 0.0015, "kg") for _ in range(count)]
    squeezes = [
        Measurement("elasticity", modulus * (1 + 0.05 * rng.standard_normal()), 0.05 * modulus, "Pa")
        for _ in range(count)
    ]
    width = Measurement("width", EDGE, 0.0002, "m")
    return {
        "weigh": tuple(Reading((m,), 1, 68.0) for m in weighs),
        "squeeze": tuple(Reading((m, width), 1, 30.0) for m in squeezes),
    }


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize(
    ("name", "mass", "modulus"),
    [("soft-cube", 0.088, 45e3), ("medium", 0.191, 110e3), ("novel-dense-soft", 0.350, 60e3)],
)
def test_every_policy_finds_out(policy: str, name: str, mass: float, modulus: float) -> None:
    found = explore_readings(NETWORK, SPECIMENS[name], bank_of(mass, modulus), policy, np.random.default_rng(0))
    trace = Trace.of([{key: array[None] for key, array in found.items()}])
    assert trace.right[0, -1]
    assert trace.top[0, -1] > 0.9
    assert trace.novel[0] == name.startswith("novel")
    assert 1 <= np.sum(trace.choices >= 0) <= STEPS
    assert trace.seconds[0, -1] == pytest.approx(
        68.0 * np.sum(trace.choices == 0) + 30.0 * np.sum(trace.choices == 1)
    )


def test_the_belief_is_the_one_of_an_exploration() -> None:
    specimen, bank = SPECIMENS["soft-cube"], bank_of(0.088, 45e3, 1)
    found = explore_readings(NETWORK, specimen, bank, "fixed order", np.random.default_rng(0))
    with on_disk(specimen) as path:
        size = SizeEstimate.declared(read_declared(path)).with_edge(1, bank["squeeze"][0].measurements[1])
    measured = (bank["weigh"][0].measurements[0], bank["squeeze"][0].measurements[0])
    belief = conclude(Belief(NETWORK), size, measured)
    assert found["true"][2] == pytest.approx(belief.probabilities("material")["silicone-foam"], abs=1e-12)


def test_a_failed_action_is_not_tried_again() -> None:
    bank = bank_of(0.088, 45e3) | {"weigh": (Reading((), 0, 20.0, "dropped"),)}
    found = explore_readings(NETWORK, SPECIMENS["soft-cube"], bank, "fixed order", np.random.default_rng(0))
    assert np.sum(found["choices"] == 0) == 1
    assert found["seconds"][1] == 20.0


def test_repetitions_take_the_readings_in_orders_of_their_own() -> None:
    bank = tuple(bank_of(0.088, 45e3).items())
    job = ReplayJob(SPECIMENS["soft-cube"], "exact, material", 0, 4, 0, bank)
    whole, part = run_job(job), run_job(ReplayJob(SPECIMENS["soft-cube"], "exact, material", 2, 2, 0, bank))
    assert np.array_equal(whole["true"][2:], part["true"])
    orders = {tuple(trial_rng(0, 6, trial).permutation(3)) for trial in range(20)}
    assert len(orders) > 3


def test_materials_a_and_b() -> None:
    """Density tells A from B and elasticity hardly; Mode 2 squeezes first, as in the thesis' Table 4.4."""
    bank = {(A.name, name): readings for name, readings in bank_of(0.079, 30e3, 6).items()}
    bank |= {(B.name, name): readings for name, readings in bank_of(0.132, 36e3, 6).items()}
    cells = {(c.policy, c.prior, c.measurement): c for c in protocol_cells(bank, 6, 0)}
    assert cells["exact, material", "uniform", "proper"].first == (6, 0)
    assert cells["exact, material", "uniform", "proper"].correct == 6
    assert cells["thesis mode 2", "uniform", "proper"].first == (0, 6)
    assert cells["thesis mode 2", "uniform", "proper"].thesis == "2/0/1"


def test_the_real_protocol_over_readings() -> None:
    values = {"black-cube": (0.085, 17250.0), "white-cube": (0.039, 15350.0), "yellow-sponge": (0.004, 7180.0)}
    assert [cube.name for cube in cubes()] == list(values)
    bank = {(n, a): r for n, (mass, modulus) in values.items() for a, r in bank_of(mass, modulus).items()}
    cells = emulator_cells(bank, 6, 0)
    modes = [cell for cell in cells if cell.policy == "thesis mode 1"]
    assert [cell.thesis for cell in modes] == ["2/0/0"] * 3
    assert sum(cell.correct for cell in modes) == 18  # weighing tells these cubes apart


def test_the_tables_count(tmp_path: object) -> None:
    values = {"soft-cube": (0.088, 45e3), "novel-dense-soft": (0.350, 60e3)}
    found = {}
    for name, (mass, modulus) in values.items():
        arrays = run_job(
            ReplayJob(SPECIMENS[name], "exact, material", 0, 2, 0, tuple(bank_of(mass, modulus).items()))
        )
        found[name] = Trace.of([arrays])
    whole = Trace.of([trace.arrays() for trace in found.values()])
    assert "asked 95 %: met" in verdict("exact", whole)
    wrong = Trace.of([trace.arrays() | {"right": ~trace.right} for trace in found.values()])
    assert "asked 95 %: not met" in verdict("exact", wrong)
    assert policy_table("p", "", {"exact": found}, "").rows[0][1:3] == (2, 2)
    assert [row[:4] for row in object_table("o", "", found, "").rows] == [
        ("soft-cube", "listed", 2, 2),
        ("novel-dense-soft", "novel", 2, 2),
    ]


def test_truths_of_the_specimens() -> None:
    materials = [material_of(specimen, NETWORK) for specimen in listed()]
    assert set(materials) == set(NETWORK.materials)
    assert {material_of(specimen, NETWORK) for specimen in novel()} == {"unknown"}


def test_replays_of_everything_need_a_bank_of_everything() -> None:
    with pytest.raises(KeyError):
        replayed_explorations({}, 1, 0, machines=Machines(1))
