"""The head of a run's page: the conclusion in plain words, and the figures that matter."""

from __future__ import annotations

from typing import Any

from selection.reporting.document import Block, Fact, Facts, Strong
from selection.reporting.document import paragraph as said
from selection.reporting.run_context import REASONS, UNKNOWN, RunPage
from selection.reporting.story import Story
from selection.reporting.text import (
    NO_BREAK,
    bits,
    interval,
    listed,
    name_of,
    percent,
    plain,
    reading,
    seconds,
    title_of,
)

SURE, LIKELY = 0.95, 0.6
MOST_FACTS = 4
_DID = {"weigh": "weighed", "squeeze": "squeezed", "rub": "rubbed", "observe": "looked at", "sound": "knocked"}


def headline(page: RunPage) -> list[Block]:
    """Return the conclusion."""
    story = page.story
    if story.last is None:
        return [said("Nothing was believed before the run ended: there is no conclusion.", kind="lead")]
    variable = story.target if story.target in story.last.classes else next(iter(story.last.classes), "material")
    name, probability = story.last.best(variable)
    words: tuple[Any, ...]
    if name == UNKNOWN:
        count = len(story.last.classes[variable]) - 1
        words = ("It fits none of the ", f"{count} kinds of {variable} listed", f" (P = {percent(probability)}).")
    else:
        how = "almost certainly" if probability >= SURE else "most likely" if probability >= LIKELY else "perhaps"
        words = (f"Its {variable} is {how} ", Strong(name_of(name)), f" (P = {percent(probability)}).")
    blocks: list[Block] = [said(*words, *_against_truth(page, variable, name), kind="lead")]
    blocks.append(said(_course_of(story)))
    if not story.stopped_because:
        blocks.append(
            said(
                Strong("The run was broken off. "),
                "What follows is what it knew until then, not what it would have found.",
                kind="alarm",
            )
        )
    blocks.append(Facts(tuple(_facts(story, variable, probability))))
    return blocks


def _against_truth(page: RunPage, variable: str, name: str) -> tuple[str, ...]:
    told = page.truth.get("material") if variable == "material" else None
    if not isinstance(told, str):
        return ()
    if told == name:
        return (
            " The simulated object is indeed made of it." if told != UNKNOWN else " Indeed it is none of them.",
        )
    if told == UNKNOWN:
        return (" The simulated object is of no listed material: the conclusion is wrong.",)
    really = f" The simulated object is of {name_of(told)}"
    listed_there = page.story.last is not None and told in page.story.last.classes.get(variable, {})
    if listed_there:
        return (f"{really}: the conclusion is wrong.",)
    return (f"{really}, which the reference does not list{': that is right' if name == UNKNOWN else ''}.",)


def _course_of(story: Story) -> str:
    acts = [step.choice for step in story.acts]
    did = "Nothing was done"
    if acts:
        counted = [
            _DID.get(name, f"did {name_of(name)} with")
            + ("" if acts.count(name) == 1 else f" {acts.count(name)} times")
            for name in dict.fromkeys(acts)
        ]
        did = f"The robot {listed(counted)} it in {seconds(story.seconds)}"
    if not story.stopped_because:
        return f"{did}."
    because = REASONS.get(story.stopped_because, story.stopped_because)
    return f"{did}, and stopped because {because}."


def _facts(story: Story, variable: str, probability: float) -> list[Fact]:
    assert story.last is not None
    count = len(set(story.last.classes.get(variable, {})) - {UNKNOWN})
    facts = [Fact(percent(probability), "Probability", f"of {count} kinds listed")]
    measured = {reading(m)[0] for step in story.acts for m in step.measurements}
    if "mass" in measured and "mass" not in story.last.quantities:
        measured.add("density")
    for name, found in story.last.quantities.items():
        if name in measured and len(facts) < MOST_FACTS:
            remark = f"90{NO_BREAK}%: {interval(found.interval, found.unit)}"
            facts.append(Fact(plain(found.median, found.unit), title_of(name), remark))
    if story.first is not None and variable in story.first.classes:
        gained = story.first.entropy(variable) - story.last.entropy(variable)
        facts.append(Fact(bits(gained), "Learned", f"of {bits(story.first.entropy(variable))} not known"))
    count = len(story.acts)
    facts.append(Fact(seconds(story.seconds), "Robot time", f"{count} action{'s' if count != 1 else ''}"))
    return facts
