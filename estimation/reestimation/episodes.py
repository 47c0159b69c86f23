"""The actions of a recording: which phases belong together, by its marks or by what the robot did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dynamics.errors import InvalidInput
from estimation.recording import Mark, Recorded, Recording, Samples

Array = NDArray[np.float64]

STILL = 0.02  # rad/s below which a joint stands
CREEP = 0.02  # rad that a joint may wander during a hold
LEAST_HOLD = 0.5  # s
SETTLING = 0.3  # s left out at the start of a hold, while the arm swings
CONTACT_SHARE = 0.3  # of the rise of the current, at which the pads have met the object
MUCH = 0.5  # of the way that pads close furthest after a grasp: those after which they close less only hold
GRIPPED = 0.002  # m by which pads close before an object is thought to be held


@dataclass(frozen=True)
class Episode:
    """One action as it happened.

    Attributes:
        action: its name.
        marks: its phases, in order.
        recorded: what was measured by it at the time.
    """

    action: str
    marks: tuple[Mark, ...]
    recorded: tuple[Recorded, ...] = ()


def episodes_of(recording: Recording) -> tuple[Episode, ...]:
    """Return the actions of a recording that is marked: one between two decisions."""
    rows = [entry.row for entry in recording.decisions]
    grouped: dict[tuple[int, str], list[Mark]] = {}
    for mark in recording.marks:
        grouped.setdefault((int(np.searchsorted(rows, mark.start, side="right")), mark.action), []).append(mark)
    measured: dict[tuple[int, str], list[Recorded]] = {}
    for one in recording.measurements:
        # A measurement comes after its action's samples and before the next decision, perhaps at its row: then
        # it is of the action that ends there, not of the one that begins, unless that is the only one.
        starts = {turn: marks[0].start for (turn, action), marks in grouped.items() if action == one.action}
        turns = [turn for turn, start in starts.items() if start < one.row]
        turns = turns or [turn for turn, start in starts.items() if start == one.row]
        measured.setdefault((max(turns, default=0), one.action), []).append(one)
    return tuple(
        Episode(action, tuple(marks), tuple(measured.get((turn, action), ())))
        for (turn, action), marks in grouped.items()
    )


def find_weighing(samples: Samples) -> tuple[Mark, ...]:
    """Find the tares and holds of a recording without marks, by where the arm stands and what the gripper holds.

    A stand of at least LEAST_HOLD is a hold if the gripper has closed on something, and a tare if not.
    Where the object is gripped or let go without a motion of the arm it may rest on something: no hold there.

    Raises:
        InvalidInput: if the arm never stands, or the log does not tell when something was held.
    """
    stretches = find_holds(samples)
    if np.isnan(samples.opening).any():
        raise InvalidInput(
            "recording without marks", "no opening of the gripper", "a log of the tare; option --tare"
        )
    held = _held(samples)
    stands = _stretches(_arm_stands(samples))
    names, kept = [], []
    for start, stop in stretches:
        holding = bool(np.median(held[start:stop]) > 0.5)
        around = next(slice(a, b) for a, b in stands if a <= start and stop <= b)
        if holding and not held[around].all():
            continue
        names.append("hold" if holding else "tare")
        kept.append((start, stop))
    if len(set(names)) < 2:
        found = f"{len(names)} stands, all {names[0]}" if names else "no stand that tells"
        raise InvalidInput("recording without marks", found, "stands with and without the object")
    return mark_all("weigh", names, kept)


def find_holds(samples: Samples) -> list[tuple[int, int]]:
    """Return the stretches in which arm and gripper stand, as rows from and to.

    Raises:
        InvalidInput: if there is none.
    """
    still = _arm_stands(samples)
    if not np.isnan(samples.opening).any():
        still &= ~_gripper_moves(samples)
    found = []
    for start, stop in _stretches(still):
        begin = int(np.searchsorted(samples.time, samples.time[start] + SETTLING))
        long = begin < stop and samples.time[stop - 1] - samples.time[begin] >= LEAST_HOLD
        if long and np.all(np.ptp(samples.q[begin:stop], axis=0) < CREEP):
            found.append((begin, stop))
    if not found:
        raise InvalidInput("recording", "an arm that never stands still", f"holds of at least {LEAST_HOLD} s")
    return found


def find_squeezes(samples: Samples) -> tuple[Mark, ...]:
    """Find the closing moves of the gripper: through air, and on an object where the current stays up at the end.

    Where an object is squeezed that is held already, the moves that met it, perhaps where it stood on a table, are
    grasps; and where it is grasped more than once, only the grasps count after which the pads closed much further.
    Returns no marks if the gripper never closes on anything, or the log has no current.
    """
    named: list[tuple[str, _Closing]] = []
    travel: list[float] = []  # of the pads after each grasp
    grasps: list[int] = []  # which one every move belongs to
    for one in _closings(samples):
        way = float(samples.opening[one.start] - samples.opening[one.stop - 1])
        meets = one.contact is not None and samples.opening[one.start] - one.contact > GRIPPED
        if meets or not travel:
            travel.append(0.0)
        if one.contact is not None and not meets:
            travel[-1] += way
        grasps.append(len(travel) - 1)
        named.append(("air" if one.contact is None else "grasp" if meets else "compress", one))
    most = max(travel, default=0.0)
    if most == 0.0:  # every squeeze began in the air
        named = [("compress" if name == "grasp" else name, one) for name, one in named]
    kept = [
        (name, one)
        for (name, one), grasp in zip(named, grasps, strict=True)
        if name == "air" or travel[grasp] >= MUCH * most
    ]
    names = [name for name, _ in kept]
    if "compress" not in names or "air" not in names:
        return ()
    return mark_all("squeeze", names, [(one.start, one.stop) for _, one in kept])


@dataclass(frozen=True)
class _Closing:
    """Rows of a closing move, and the opening at which the pads met something, if they did [m]."""

    start: int
    stop: int
    contact: float | None


def _closings(samples: Samples) -> list[_Closing]:
    """Return the closing moves; none if the log has no current."""
    if np.isnan(samples.effort).any() or np.isnan(samples.opening).any():
        return []
    closing = np.concatenate([[0.0], np.diff(samples.opening)]) < 0
    moves = _runs(closing, gap=max(int(0.1 / _step(samples)), 1))
    if not moves:
        return []
    free = float(np.median(samples.effort[slice(*moves[0])]))
    noise = float(np.median(np.abs(np.diff(samples.effort)))) + 1e-3
    found = []
    for start, stop in moves:
        if samples.opening[start] - samples.opening[stop - 1] < GRIPPED / 4:
            continue
        effort = samples.effort[start:stop]
        rise = float(np.quantile(effort[-max(int(0.2 / _step(samples)), 4) :], 0.75)) - free
        contact = None
        if rise > 5 * noise:
            below = np.flatnonzero(effort <= free + CONTACT_SHARE * rise)
            contact = float(samples.opening[start + (int(below[-1]) if len(below) else 0)])
        found.append(_Closing(start, stop, contact))
    return found


def mark_all(action: str, names: list[str], stretches: list[tuple[int, int]]) -> tuple[Mark, ...]:
    """Return marks with indices counted per name."""
    counts: dict[str, int] = {}
    marks = []
    for name, (start, stop) in zip(names, stretches, strict=True):
        marks.append(Mark(action, name, counts.get(name, 0), start, stop))
        counts[name] = counts.get(name, 0) + 1
    return tuple(marks)


def _held(samples: Samples) -> NDArray[np.bool_]:
    """Tell for every row whether the pads are closed on something.

    By the current: from the end of a closing move that met something until the pads are further apart than they
    were then. Without a current: when they are between fully closed and the open state.
    """
    opening = samples.opening
    closings = _closings(samples)
    if not closings:
        widest = float(np.max(opening))
        return np.asarray((opening < widest - GRIPPED) & (opening > float(np.min(opening)) * 0.5), bool)
    held = np.zeros(len(opening), bool)
    for one in closings:
        if one.contact is not None:
            wider = np.flatnonzero(opening[one.stop :] > one.contact + GRIPPED / 2)
            held[one.stop : one.stop + int(wider[0]) if len(wider) else None] = True
    return held


def _arm_stands(samples: Samples) -> NDArray[np.bool_]:
    return np.asarray(np.all(np.abs(samples.dq) < STILL, axis=1), bool)


def _gripper_moves(samples: Samples) -> NDArray[np.bool_]:
    """Tell for every row whether the opening changes by more than its last digits around it."""
    reach = max(int(0.1 / _step(samples)), 1)
    padded = np.pad(samples.opening, reach, mode="edge")
    return np.asarray(np.abs(padded[2 * reach :] - padded[: -2 * reach]) > GRIPPED / 2, bool)


def _step(samples: Samples) -> float:
    """Return the usual time between rows [s]."""
    return max(float(np.median(np.diff(samples.time))), 1e-4) if len(samples) > 1 else 1.0


def _stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the runs of true flags, as rows from and to."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _runs(flags: NDArray[np.bool_], gap: int) -> list[tuple[int, int]]:
    """Return runs of true flags, short gaps bridged."""
    rows = np.flatnonzero(flags)
    if not len(rows):
        return []
    breaks = np.flatnonzero(np.diff(rows) > gap)
    starts = rows[np.concatenate([[0], breaks + 1])]
    stops = rows[np.concatenate([breaks, [len(rows) - 1]])] + 1
    return [(max(int(a) - 1, 0), int(b)) for a, b in zip(starts, stops, strict=True)]
