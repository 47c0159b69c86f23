"""Reference files: what is shipped reads well, survives a round trip, and what is wrong is named."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dynamics.errors import InvalidInput, PalpateError, UnknownName
from estimation.network import Network
from estimation.network_file import network_content, parse_network
from models import references

SHIPPED = ("household", "network-8x10", "soft-cubes", "thesis-3.1", "thesis-3.1-erratum", "thesis-3.2")


def test_all_references_are_listed() -> None:
    assert set(SHIPPED) <= set(references.names())
    assert all(references.path(name).is_file() for name in references.names())
    with pytest.raises(KeyError, match="soft-cubes"):
        references.path("hard-cubes")
    with pytest.raises(FileNotFoundError):
        references.raw("nowhere/else.json")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_references_survive_a_round_trip(name: str, tmp_path: Path) -> None:
    network = Network.from_file(name)
    network.save(tmp_path / "copy.json")
    copied = Network.from_file(tmp_path / "copy.json")
    assert network_content(copied) == network_content(network)
    assert copied.hypotheses.mean == pytest.approx(network.hypotheses.mean, rel=1e-12)


def test_table_3_1_is_shipped_as_printed_and_as_used() -> None:
    printed, used = Network.from_file("thesis-3.1"), Network.from_file("thesis-3.1-erratum")
    ceramic = printed.materials.index("ceramic")
    assert printed.property("density").sds[ceramic] == 50
    assert used.property("density").sds[ceramic] == 500
    assert printed.property("density").means == used.property("density").means
    assert printed.property("elasticity").means[printed.materials.index("steel")] == 200e9
    assert "500" in used.source


def test_thesis_joker_in_a_network_with_categories() -> None:
    network = Network.from_file("network-8x10")
    assert len(network.hypotheses.material) == 81
    assert network.classes("category")[-1] == "unknown"
    assert len(network.without_unknown().hypotheses.material) == 80


def test_soft_cubes_cover_their_range() -> None:
    network = Network.from_file("soft-cubes")
    density, elasticity = network.property("density"), network.property("elasticity")
    assert min(density.means) < 40
    assert max(m + 2 * s for m, s in zip(density.means, density.sds, strict=True)) > 5500
    assert min(elasticity.means) < 10e3
    assert max(elasticity.means) > 0.8e6


def test_scale_log_keeps_mean_and_sd() -> None:
    network = Network.from_file("soft-cubes")
    prop = network.property("elasticity")
    import numpy as np

    mean = np.exp(prop.location + 0.5 * prop.spread**2)
    assert mean == pytest.approx(prop.means, rel=1e-12)
    assert mean * np.sqrt(np.expm1(prop.spread**2)) == pytest.approx(prop.sds, rel=1e-12)


VALID: dict[str, Any] = {
    "format": "palpate-reference/1",
    "materials": ["a", "b"],
    "categories": {"c": {"materials": {"a": 0.5, "b": 0.5}}},
    "unknown": {"weight": 0.1},
    "properties": {
        "density": {
            "parent": "material",
            "unit": "kg/m^3",
            "classes": {"a": {"mean": 100, "sd": 10}, "b": {"mean": 200, "sd": 10}},
        },
        "volume": {"unit": "cm^3", "scale": "log", "mean": 100, "sd": 50},
    },
    "relations": {"mass": {"unit": "g", "product": {"density": 1, "volume": 1}}},
    "sensors": {
        "weigh": {"property": "mass", "unit": "g", "sd": 5},
        "look": {"variable": "material", "confusion": [[0.9, 0.2], [0.1, 0.8]]},
    },
}


def _set(*path_and_value: Any) -> Callable[[dict[str, Any]], None]:
    *path, last, value = path_and_value

    def change(content: dict[str, Any]) -> None:
        place: Any = content
        for key in path:
            place = place[key]
        place[last] = value

    return change


BROKEN: dict[str, tuple[Callable[[dict[str, Any]], None], str]] = {
    "format": (_set("format", "other"), "format"),
    "stray key": (_set("matirials", []), "matirials"),
    "no materials": (_set("materials", []), "materials"),
    "twice": (_set("materials", ["a", "a"]), "materials"),
    "unknown as material": (_set("materials", ["a", "unknown"]), "materials"),
    "prior sum": (_set("materials", {"a": 0.5, "b": 0.6}), "1.1"),
    "negative": (_set("materials", {"a": 1.5, "b": -0.5}), "-0.5"),
    "share sum": (_set("categories", "c", "materials", {"a": 0.5, "b": 0.4}), "0.9"),
    "stranger": (_set("categories", "c", "materials", {"a": 0.5, "z": 0.5}), "'z'"),
    "weight": (_set("unknown", "weight", 1.0), "weight"),
    "parent": (_set("properties", "density", "parent", "shape"), "shape"),
    "scale": (_set("properties", "density", "scale", "cubic"), "cubic"),
    "unit": (_set("properties", "density", "unit", "lump"), "lump"),
    "no unit": (lambda content: content["properties"]["density"].pop("unit"), "unit"),
    "sd": (_set("properties", "density", "classes", "a", "sd", 0), "sd: found 0"),
    "nan": (_set("properties", "density", "classes", "a", "mean", float("nan")), "mean: found nan"),
    "text": (_set("properties", "density", "classes", "a", "mean", "heavy"), "heavy"),
    "missing class": (lambda content: content["properties"]["density"]["classes"].pop("b"), "entry for b"),
    "log mean": (_set("properties", "volume", "mean", -1), "mean: found -1"),
    "unit does not fit": (_set("relations", "mass", "unit", "Pa"), "unit: found 'Pa'"),
    "cycle": (_set("relations", "mass", "product", {"mass": 1}), "cycle"),
    "stray factor": (_set("relations", "mass", "product", {"colour": 1}), "colour"),
    "sensor": (_set("sensors", "weigh", "property", "colour"), "colour"),
    "sensor sd": (_set("sensors", "weigh", "sd", -1), "sd: found -"),
    "sensor unit": (_set("sensors", "weigh", "unit", "m"), "unit: found 'm'"),
    "confusion": (_set("sensors", "look", "confusion", [[0.9, 0.3], [0.1, 0.8]]), "column b"),
    "confusion shape": (_set("sensors", "look", "confusion", [[1.0], [0.0]]), "confusion"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_named_on_one_line(name: str) -> None:
    change, expected = BROKEN[name]
    content = copy.deepcopy(VALID)
    change(content)
    with pytest.raises(PalpateError) as caught:
        parse_network(content, "mine.json")
    message = str(caught.value)
    assert message.startswith("mine.json")
    assert expected in message
    assert "\n" not in message


def test_the_valid_one_is_valid() -> None:
    network = parse_network(copy.deepcopy(VALID), "mine.json")
    assert network.unit("mass") == "kg"
    assert network.property("volume").means[0] == pytest.approx(1e-4)


def test_relations_may_build_on_each_other_but_not_in_a_circle() -> None:
    content = copy.deepcopy(VALID)
    content["relations"]["square"] = {"unit": "kg", "product": {"mass": 1}}
    assert dict(parse_network(content, "mine.json").relations[1].terms) == {"density": 1.0, "volume": 1.0}
    content["relations"]["mass"]["product"] = {"square": 1}
    with pytest.raises(InvalidInput, match="cycle"):
        parse_network(content, "mine.json")


def test_files_that_are_not_there_or_not_json(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="soft-cubes"):
        Network.from_file("hard-cubes")
    with pytest.raises(InvalidInput, match="existing file"):
        Network.from_file(tmp_path / "none.json")
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(InvalidInput, match=r"broken\.json"):
        Network.from_file(tmp_path / "broken.json")
    (tmp_path / "list.json").write_text(json.dumps([1]))
    with pytest.raises(InvalidInput, match=r"list\.json"):
        Network.from_file(tmp_path / "list.json")
