"""The page of a run: what the object is, how that was found out step by step, and everything it rests on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from selection.reporting import belief_figures
from selection.reporting.analysis import analyse
from selection.reporting.document import Block, Document, Gallery, Section
from selection.reporting.document import paragraph as said
from selection.reporting.files import write_document
from selection.reporting.headline import headline
from selection.reporting.palette import colours
from selection.reporting.pictures import BEFORE, pictures_of
from selection.reporting.run_context import UNKNOWN, RunPage
from selection.reporting.run_tables import (
    belief_table,
    configuration_blocks,
    decision_table,
    found_table,
    measurement_table,
)
from selection.reporting.steps import step_section, stop_section
from selection.reporting.story import Beliefs, Story, read_story
from selection.reporting.text import (
    date,
    plain,
    slug,
    title_of,
)

REPORT = "report.html"


def write_run_report(directory: Path, out: Path | None = None) -> Path:
    """Write the page of a run, with a file for each figure and table in folders beside it; return its path.

    Args:
        directory: of the run.
        out: the page; ``report.html`` in the run's directory if None.

    Raises:
        InvalidInput: if there is no recording in the directory.
        CannotRecord: if the files cannot be written.
    """
    return write_document(run_document(read_story(directory), directory), out or directory / REPORT)


def run_document(story: Story, directory: Path) -> Document:
    """Return the page of a run."""
    analyses, notes = analyse(story)
    truth = story.result.get("truth")
    pictures = pictures_of(directory, [(step.number, step.choice) for step in story.acts])
    page = RunPage(story, analyses, _shades(story), truth if isinstance(truth, Mapping) else {}, pictures)
    blocks: list[Block] = [*headline(page), *_found(page)]
    if pictures.get(BEFORE):
        blocks.append(Section("What it looked like", (Gallery(pictures[BEFORE], "pictures"),)))
    blocks += [step_section(page, step) for step in story.acts]
    blocks += stop_section(page)
    blocks.append(_numbers(page))
    blocks.append(Section("How it was set up", configuration_blocks(story)))
    remarks = [*story.notes, *notes]
    if remarks:
        blocks.append(Section("Remarks", tuple(said(note, kind="note") for note in dict.fromkeys(remarks))))
    versions = story.result.get("versions") or story.recording.config.get("versions")
    made = versions.get("palpate", "") if isinstance(versions, Mapping) else ""
    by = f"Palpate {made}" if made and made != "not installed" else "Palpate"
    end = (
        f"Made by {by} from the recording of the run alone; figures and tables are also in the folders beside it."
    )
    return Document(title_of(story.object_name), _occasion(story), tuple(blocks), end)


def _occasion(story: Story) -> str:
    robot = story.recording.config.get("robot")
    how = " in simulation" if robot == "sim" else ""
    when = date(story.recording.started)
    return f"Explored by touch{how}{', ' if when else ''}{when}"


def _shades(story: Story) -> dict[str, dict[str, str]]:
    """Return one colour for each class, the likeliest first, for all figures; unknown stays grey."""
    moments = [step.before for step in story.steps] + [step.after for step in story.steps] + [story.last]
    known = [moment for moment in moments if moment is not None]
    found: dict[str, dict[str, str]] = {}
    for variable in dict.fromkeys(v for moment in known for v in moment.classes):
        last = known[-1].classes.get(variable, {})
        later = [m.classes.get(variable, {}) for m in known if m is not known[0]]
        peak = {name: (last.get(name, 0.0), max((m.get(name, 0.0) for m in later), default=0.0)) for name in last}
        order = sorted((n for n in peak if n != UNKNOWN), key=lambda n: (-peak[n][0], -peak[n][1], n))
        found[variable] = colours(order) | ({UNKNOWN: "#5a626f"} if UNKNOWN in last else {})
    return found


def _found(page: RunPage) -> list[Block]:
    story = page.story
    if story.last is None:
        return []
    figures: list[Block] = []
    moments = _moments(story)
    variable = story.target if story.target in story.last.classes else "material"
    if len(moments) > 1:
        threshold = story.recording.config.get("confidence")
        level = float(threshold) if isinstance(threshold, int | float) and 0 < threshold <= 1 else None
        figures.append(
            belief_figures.course(
                f"course-of-{slug(variable)}",
                variable,
                [(word, belief.classes.get(variable, {})) for word, belief in moments],
                page.shades.get(variable, {}),
                level,
            )
        )
    rows = []
    for name, found in story.last.quantities.items():
        first = story.first.quantities.get(name, found) if story.first is not None else found
        if found.median > 0:
            text = plain(found.median, found.unit)
            row = (name, text, found.median, found.interval, first.interval, page.true_value(name))
            rows.append(belief_figures.Learned(*row))
    if rows:
        figures.append(belief_figures.learned("how-well-known", rows))
    table = found_table(story, page.true_value)
    return [Section("What was found", (table, Gallery(tuple(figures))))]


def _moments(story: Story) -> list[tuple[str, Beliefs]]:
    moments = [("start", story.first)] if story.first is not None else []
    moments += [(step.choice, step.after) for step in story.acts if step.after is not None]
    return [(word, belief) for word, belief in moments if belief is not None]


def _numbers(page: RunPage) -> Section:
    story = page.story
    tables: list[Block] = [measurement_table(story), decision_table(story)]
    if story.last is not None:
        tables += [belief_table(variable, _moments(story)) for variable in story.last.classes]
    return Section("In numbers", tuple(tables))
