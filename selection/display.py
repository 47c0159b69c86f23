"""What a person sees while the robot explores: a live table on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from estimation.belief import Belief
from estimation.bounds import bound_of
from estimation.measurement import Measurement
from estimation.mixture import Mixture
from estimation.network import UNKNOWN
from selection.exploration import Exploration, Step
from selection.planner import Decision
from selection.robots import Truth

if TYPE_CHECKING:
    from rich.console import RenderableType

SHOWN_CLASSES = 5
_BAR = 20
# What a person reads: unit, and how many of it there are in one SI unit.
DISPLAY_UNITS = {"kg": ("g", 1e3), "Pa": ("kPa", 1e-3), "m": ("mm", 1e3), "m^3": ("cm^3", 1e6)}


def spoken(mean: float, sd: float, unit: str) -> str:
    """Return a quantity in the unit that a person would use, with its standard deviation."""
    name, factor = DISPLAY_UNITS.get(unit, (unit if unit != "1" else "", 1.0))
    return f"{mean * factor:.4g} +- {sd * factor:.2g} {name}".rstrip()


def measured(measurement: Measurement) -> str:
    """Return a measurement as a person would say it."""
    bound = bound_of(measurement)
    if bound is not None:
        quantity, least, unit = bound
        name, factor = DISPLAY_UNITS.get(unit, (unit, 1.0))
        return f"{quantity} at least {least * factor:.3g} {name}"
    return f"{measurement.property} {spoken(measurement.mean, measurement.sd, measurement.unit)}"


def believed(marginal: Mixture) -> str:
    """Return a belief about a quantity as a person would say it: the median and the middle 90 %."""
    name, factor = DISPLAY_UNITS.get(marginal.unit, (marginal.unit if marginal.unit != "1" else "", 1.0))
    low, high = (factor * bound for bound in marginal.interval(0.9))
    return f"{marginal.quantile(0.5) * factor:.4g} ({low:.3g} to {high:.3g}) {name}".rstrip()


def likeliest(belief: Belief, variable: str = "material") -> list[tuple[str, float]]:
    """Return the most probable classes with their probabilities, the first first."""
    found = belief.probabilities(variable)
    return sorted(found.items(), key=lambda item: -item[1])[:SHOWN_CLASSES]


def gains(decision: Decision) -> str:
    """Return what the planner expects of every action, on one line."""
    parts = []
    for score in decision.scores:
        worth = (
            f"{score.name} {score.bits:.2f} bit - {decision.price * score.seconds:.2f} for {score.seconds:.0f} s"
        )
        parts.append(worth if score.feasible else f"{score.name} {score.bits:.2f} bit ({score.reason})")
    return "; ".join(parts)


def report(exploration: Exploration, truth: Truth | None, directory: Path, out: TextIO) -> None:
    """Write what the object was found to be, next to what it is if that is known."""
    name, probability = likeliest(exploration.belief)[0]
    really = f" (truth: {truth.material})" if truth else ""
    verdict = f"most likely {name}" if name != UNKNOWN else "most likely of no listed material"
    lines = [f"It is {verdict}, P = {probability:.3f}{really}; {exploration.seconds:.0f} s of robot time."]
    if name == UNKNOWN:
        lines += [f"  measured: {measured(m)}" for step in exploration.steps for m in step.measurements]
    for quantity in exploration.belief.network.quantities:
        found = believed(exploration.belief.marginal(quantity))
        if truth and quantity in truth.properties:
            unit, factor = DISPLAY_UNITS.get(truth.units[quantity], (truth.units[quantity], 1.0))
            found += (
                f"   (truth: {truth.properties[quantity] * factor:.4g} {unit if unit != '1' else ''}".rstrip()
                + ")"
            )
        lines.append(f"  {quantity:<11} {found}")
    print("", *lines, f"Kept in {directory}", sep="\n", file=out)


class Silent:
    """Shows nothing."""

    def begins(self, belief: Belief) -> None:
        """Show nothing."""

    def decides(self, decision: Decision) -> None:
        """Show nothing."""

    def learns(self, step: Step) -> None:
        """Show nothing."""

    def close(self) -> None:
        """Show nothing."""


class Lines:
    """Writes a few plain lines a step.

    Args:
        out: where to.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = out

    def begins(self, belief: Belief) -> None:
        """Show what is believed beforehand."""
        self._say(f"believed  {_listed(likeliest(belief))}")

    def decides(self, decision: Decision) -> None:
        """Show the expected gain of each action, and the choice."""
        self._say(f"expected  {gains(decision)}")
        self._say(f"next      {decision.choice}" if decision.choice else f"stop      {decision.stop}")

    def learns(self, step: Step) -> None:
        """Show what an action brought."""
        outcome = "; ".join([measured(m) for m in step.measurements] + list(step.notes))
        self._say(f"{'measured ' if step.ok else 'FAILED   '} {outcome} ({step.seconds:.1f} s)")
        self._say(f"believed  {_listed(likeliest(step.belief))}")

    def close(self) -> None:
        """Nothing is left open."""

    def _say(self, line: str) -> None:
        print(line, file=self._out, flush=True)


class LiveTable:
    """A table that grows with the steps, and bars for the belief, on a terminal."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.live import Live

        self._rows: list[tuple[str, str, str]] = []
        self._belief: list[tuple[str, float]] = []
        self._live = Live(console=Console(), auto_refresh=False)
        self._live.start()

    def begins(self, belief: Belief) -> None:
        """Show what is believed beforehand."""
        self._belief = likeliest(belief)
        self._refresh()

    def decides(self, decision: Decision) -> None:
        """Show the expected gain of each action, and the choice."""
        chosen = f"[bold]{decision.choice}[/bold]" if decision.choice else f"stop: {decision.stop}"
        self._rows.append((chosen, gains(decision).replace("; ", "\n"), "..." if decision.choice else ""))
        self._refresh()

    def learns(self, step: Step) -> None:
        """Show what an action brought."""
        found = "\n".join([measured(m) for m in step.measurements] + list(step.notes))
        action, expected, _ = self._rows[-1]
        verdict = found if step.ok else f"[red]failed[/red] {found}"
        self._rows[-1] = (action, expected, f"{verdict}\n[dim]{step.seconds:.1f} s[/dim]")
        self._belief = likeliest(step.belief)
        self._refresh()

    def close(self) -> None:
        """Leave the table on the screen as it is."""
        self._live.stop()

    def _refresh(self) -> None:
        self._live.update(self._picture(), refresh=True)

    def _picture(self) -> RenderableType:
        from rich.console import Group
        from rich.table import Table

        steps = Table("action", "expected", "found", title="Exploration", title_justify="left", expand=True)
        for row in self._rows:
            steps.add_row(*row)
        belief = Table("material", "probability", "", box=None)
        for name, probability in self._belief:
            belief.add_row(name, f"{probability:.3f}", "█" * round(probability * _BAR))
        return Group(steps, belief)


def _listed(classes: Iterable[tuple[str, float]]) -> str:
    return ", ".join(f"{name} {probability:.3f}" for name, probability in classes)
