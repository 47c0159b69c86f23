"""What is said beside the tables: which of the thesis' entries are reproduced, which are not, and why."""

from __future__ import annotations

from collections.abc import Sequence

from selection.trials.cells import Cell
from selection.trials.statistics import fisher

COMPATIBLE = 0.05
"""P of Fisher's exact test below which two counts are said to differ."""

_OPEN = (
    "The thesis leaves open which material was the truth, the numbers of its priors, the joker's density, and "
    "whether ceramic's density sd was the printed 50 or the 500 that its Table 3.3 needs (used here). "
)
_VIRTUAL_OTHER = (
    "Why: "
    + _OPEN
    + "With a joker that integrates to one over the window and a normalised Mode 2, its modes converge "
    "nearly always, whatever they choose: ten perturbed readings lie far closer to the truth than the error "
    "they claim, and the thesis' update counts each as a fresh draw of the material. Rates near zero, as "
    "printed, come out, in all settings tried, only when one property is measured over and over and the joker "
    "is made heavier than uniform; nothing in the text says that this was so. "
)
_VIRTUAL_SAME = (
    "That the counts agree says little of the criterion: nearly every trial converges here, whatever is chosen. "
    + _OPEN
)
_NO_LETTER = "U (wrong, but below P = 0.6) has no letter in the thesis and counts as a failure here."
_SIMULATION = (
    "Materials A and B are ours: the thesis plots them without numbers. It ran three tests a cell, so its own "
    "intervals reach over forty points and more. All policies meet the same simulated readings: a bank was "
    "simulated once with full physics and default noise, and is replayed. "
)
_SQUEEZING = (
    "As in the thesis, Mode 2 squeezes first under a uniform prior, where squeezing hardly tells A from B. "
    "Where its counts differ, it is that it goes on squeezing when errors are large: a Gaussian's gain by Mode "
    "2 does not depend on what is measured, only on the ratio of its sd to the error. "
)
_EMULATOR = (
    "The thesis had two tests a cell on a real arm, and lays the failures of its Modes 2 and 3 to squeezing. "
    "Here a simulated arm squeezes behind the arm's own protocol, more exactly than the thesis' gripper did; "
    "nothing was measured on a real arm. "
)
OTHERS = {
    "virtual": (
        "No counterpart in the thesis. The same readings, learnt from exactly: repeated readings of one object "
        "share its true value, so that ten of them leave the doubt that their claimed errors demand. Under a "
        "wrong prior with errors of 3.5 reference sds that is, for ceramic with its density sd of 500, most of "
        "the doubt there was: a correct posterior keeps to its prior there. The thesis' update overcomes it by "
        "counting too much, which pays here only because the true perturbations are far smaller than the errors "
        "claimed."
    ),
    "simulation": (
        "No counterpart in the thesis. The same readings, learnt from exactly. The target elasticity squeezes "
        "alone, as it should, and so leaves the material open: A and B hardly differ there."
    ),
    "emulator": "No counterpart in the thesis. The same readings, learnt from exactly.",
}


def mode_note(cells: Sequence[Cell]) -> str:
    """Return the note beside a table of one thesis mode.

    Args:
        cells: of the mode, in one environment.
    """
    said, environment = agreement(cells) + " ", cells[0].environment
    different = any(one_rate(cell) < COMPATIBLE for cell in cells)
    if environment == "virtual":
        return said + (_VIRTUAL_OTHER if different else _VIRTUAL_SAME) + _NO_LETTER
    if environment == "simulation":
        return said + _SIMULATION + (_SQUEEZING if cells[0].policy.endswith("2") else "") + _NO_LETTER
    return said + _EMULATOR + _NO_LETTER


def agreement(cells: Sequence[Cell]) -> str:
    """Say which entries of the thesis are reproduced."""
    same: list[str] = []
    other: list[str] = []
    for cell in cells:
        place = f"{cell.prior}/{cell.measurement}" if cell.measurement else cell.prior
        (same if one_rate(cell) >= COMPATIBLE else other).append(place)
    said = f"Compatible with the printed counts (Fisher's P >= {COMPATIBLE}): {len(same)} of {len(cells)} entries"
    said += f" ({', '.join(same)})" if same else ""
    return said + (f". Not reproduced: {', '.join(other)}." if other else ".")


def one_rate(cell: Cell) -> float:
    """Return Fisher's P that the thesis' counts and ours have one rate of convergence."""
    counts = [int(part) for part in cell.thesis.split("/")]
    return fisher((counts[0], sum(counts)), (cell.correct, cell.trials))
