"""The steps of a run's page: why each action was chosen, what it measured, and what that taught."""

from __future__ import annotations

import math
from typing import Any

from selection.reporting import belief_figures, density_figures, signal_figures
from selection.reporting.analysis import Analysis
from selection.reporting.document import Block, Figure, Gallery, Paragraph, Section, Strong
from selection.reporting.document import paragraph as said
from selection.reporting.run_context import REASONS, RunPage
from selection.reporting.story import Step
from selection.reporting.text import bits, name_of, percent, reading, seconds, slug, title_of


def step_section(page: RunPage, step: Step) -> Section:
    """Return the story of one step."""
    analysis = page.analyses.get(step.number, Analysis())
    blocks: list[Block] = [said(*_why(step)), _brought(step)]
    failed = step.ok is False
    notes = step.notes[1:] if failed else (*step.notes, *analysis.notes)
    told = tuple(f"{seen.variable} {seen.best}" for seen in step.observations)
    notes = tuple(note for note in notes if not note.endswith(told))  # the paragraph says it already
    blocks += [said(note, kind="note") for note in notes]
    if page.pictures.get(step.number):
        blocks.append(Gallery(page.pictures[step.number], "pictures"))
    figures: list[Block] = []
    if step.scores:
        figures.append(belief_figures.gains(f"step-{step.number}-gains", step.scores, step.price, step.choice))
    if step.before is not None and step.after is not None:
        for variable in step.after.classes:
            if step.before.classes.get(variable) == step.after.classes[variable]:
                continue
            figures.append(
                belief_figures.change(
                    f"step-{step.number}-{slug(variable)}",
                    variable,
                    step.before.classes.get(variable, {}),
                    step.after.classes[variable],
                    page.shades.get(variable, {}),
                )
            )
    for i, seen in enumerate(step.observations):
        shades = page.shades.get(seen.variable, {})
        figures.append(belief_figures.perceived(f"step-{step.number}-perceived-{i + 1}", seen, shades))
    densities, signals = _density_figures(page, step, analysis), _signal_figures(step, analysis)
    figures += [*signals[:1], *densities, *signals[1:]]
    blocks.append(Gallery(tuple(figures)))
    return Section(title_of(step.choice), tuple(blocks), f"Step {step.number}")


def _why(step: Step) -> tuple[Any, ...]:
    chosen = step.chosen
    if chosen is None:
        return ("Chosen without a recorded reason.",)
    others = [s for s in step.scores if s.feasible and s.name != chosen.name]
    rival = max(others, key=lambda s: s.value, default=None)
    words: list[Any] = [
        "Expected to tell ",
        Strong(bits(chosen.bits)),
        f" about the {name_of(step.target)} for {seconds(chosen.seconds)} of robot time, "
        f"which cost {bits(step.price * chosen.seconds)}: worth {bits(chosen.value)}.",
    ]
    if rival is not None:
        words.append(f" The next best, {name_of(rival.name)}, was worth {bits(rival.value)}.")
    return tuple(words)


def _brought(step: Step) -> Paragraph:
    words: list[Any] = []
    if step.ok is False:
        why = f": {step.notes[0]}" if step.notes else ""
        words.append(f"It failed after {seconds(step.seconds)}{why}.")
    elif step.measurements:
        words.append("Measured ")
        for i, one in enumerate(step.measurements):
            words.append("" if i == 0 else " and " if i == len(step.measurements) - 1 else ", ")
            name, value = reading(one)
            words += [f"{name} ", Strong(value)]
        words.append(f" in {seconds(step.seconds)}." if math.isfinite(step.seconds) else ".")
    elif step.observations:
        for i, seen in enumerate(step.observations):
            words += [
                "; " if i else "",
                f"It seemed most like the {name_of(seen.variable)} ",
                Strong(name_of(seen.best)),
            ]
        words.append(f" after {seconds(step.seconds)}." if math.isfinite(step.seconds) else ".")
    elif math.isfinite(step.seconds):
        words.append(f"It measured nothing in {seconds(step.seconds)}.")
    else:
        words.append("It measured nothing.")
    if step.ok is not False and step.before and step.after and step.target in step.after.classes:
        gained = step.before.entropy(step.target) - step.after.entropy(step.target)
        name, probability = step.after.best(step.target)
        if gained >= 0:
            words.append(f" That told {bits(gained)}: ")
        else:
            words.append(f" That left {bits(-gained)} more open than before: ")
        words.append(f"now {name_of(name)} at {percent(probability)}.")
    return Paragraph(tuple(words))


def _signal_figures(step: Step, analysis: Analysis) -> list[Figure]:
    found = []
    if analysis.holds:
        found.append(signal_figures.torques(f"step-{step.number}-torques", analysis.holds))
    if analysis.squeezing is not None:
        found.append(signal_figures.stress_strain_curve(f"step-{step.number}-stress-strain", analysis.squeezing))
        found.append(signal_figures.gripper_signals(f"step-{step.number}-gripper", analysis.squeezing))
    if analysis.rubbing is not None:
        found.append(signal_figures.friction(f"step-{step.number}-friction", analysis.rubbing))
    if analysis.pinching is not None:
        found.append(signal_figures.slides(f"step-{step.number}-friction", analysis.pinching))
    return found


def _density_figures(page: RunPage, step: Step, analysis: Analysis) -> list[Figure]:
    if analysis.before is None:
        return []
    shades = page.shades.get("material", {})
    return [
        density_figures.densities(
            f"step-{step.number}-{slug(reading.property)}",
            analysis.before,
            analysis.after,
            reading,
            shades,
            page.true_value(reading.property),
        )
        for reading in analysis.readings
    ]


def stop_section(page: RunPage) -> list[Block]:
    """Return why the exploration ended."""
    last = page.story.steps[-1] if page.story.steps else None
    if last is None or last.choice or not last.scores:
        return []
    because = REASONS.get(last.stop, last.stop)
    return [
        Section(
            "Why it stopped",
            (
                said(f"The exploration stopped because {because}."),
                Gallery((belief_figures.gains(f"step-{last.number}-gains", last.scores, last.price, ""),)),
            ),
            "The end",
        )
    ]
