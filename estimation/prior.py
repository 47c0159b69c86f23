"""A prior over materials, as a person writes it."""

from __future__ import annotations

from dynamics.errors import InvalidInput, UnknownName
from estimation.network import MATERIAL, Network


def parse_prior(text: str | None, network: Network, where: str) -> dict[str, float] | None:
    """Return the prior over materials that a text means, or None for the reference's own.

    Args:
        text: ``uniform``, or ``NAME=P,...``; what is not named shares the rest evenly. None or empty for none.
        network: gives the names.
        where: the text comes from, for messages.

    Raises:
        InvalidInput: for text of another form, or probabilities that are not between 0 and 1 or exceed 1.
        UnknownName: for a material that the reference does not list.
    """
    if not text:
        return None
    listed = network.materials
    given: dict[str, float] = {}
    for part in text.split(",") if text != "uniform" else ():
        name, separator, value = part.partition("=")
        if not separator:
            raise InvalidInput(where, part, "uniform, or NAME=P,... such as " + f"{listed[0]}=0.7")
        if name not in network.classes(MATERIAL):
            raise UnknownName(where, name, network.classes(MATERIAL))
        if name in given:
            raise InvalidInput(where, f"{name} twice", "every name once")
        try:
            given[name] = float(value)
        except ValueError:
            raise InvalidInput(f"{where}: {name}", value, "a probability between 0 and 1") from None
        if not 0 <= given[name] <= 1:
            raise InvalidInput(f"{where}: {name}", value, "a probability between 0 and 1")
    rest = [name for name in listed if name not in given]
    left = 1 - sum(given.values())
    if left < -1e-9 or (left > 1e-9 and not rest):
        raise InvalidInput(where, text, f"probabilities that sum to {'at most ' if rest else ''}1")
    return given | {name: max(left, 0.0) / len(rest) for name in rest}
