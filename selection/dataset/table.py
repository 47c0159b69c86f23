"""The table of a dataset: a row an object, the truth beside what was found; Parquet, see docs/dataset.md."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dynamics.errors import InvalidInput
from estimation.recording import CannotRecord
from selection.dataset.one import FAILURE, OBJECT, RESULT, failed_actions
from selection.dataset.random_objects import read_object

TABLE = "dataset.parquet"
QUANTITIES = {"mass": "kg", "density": "kg_m3", "volume": "m3", "elasticity": "pa", "friction": ""}
MEASURED = ("mass", "elasticity", "friction")

Row = dict[str, Any]


def check_parquet() -> None:
    """Refuse to begin what could not be finished.

    Raises:
        InvalidInput: if pyarrow is not installed.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise InvalidInput("dataset", "no pyarrow", "pip install palpate[parquet], for the table") from None


def write_table(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as a Parquet file, whole or not at all; equal rows give equal bytes.

    Raises:
        CannotRecord: if the disk does not take it.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pylist(list(rows), schema=schema())
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        with open(temporary, "wb") as file:
            pq.write_table(table, file, compression="zstd")
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise CannotRecord(f"{path}: {error.strerror or error}") from error


def schema() -> Any:
    """Return the table's schema (pyarrow)."""
    import pyarrow as pa

    text, number, whole = pa.string(), pa.float64(), pa.int64()
    fields: list[tuple[str, Any]] = [("index", whole), ("folder", text), ("robot_seed", whole), ("shape", text)]
    fields += [(f"declared_{axis}_m", number) for axis in "xyz"]
    fields += [(name, number) for name in ("size_sd_m", "position_x_m", "position_y_m", "yaw_rad")]
    fields += [("true_material", text)]
    fields += [(f"true_{axis}_m", number) for axis in "xyz"]
    fields += [(_column("true", quantity), number) for quantity in QUANTITIES]
    fields += [("true_poisson", number)]
    fields += [
        ("believed_material", text),
        ("believed_probability", number),
        ("true_material_probability", number),
    ]
    fields += [("material_posterior", pa.map_(text, number))]
    for quantity in QUANTITIES:
        fields += [(_column("believed", quantity, moment), number) for moment in ("", "sd")]
    for quantity in MEASURED:
        fields += [(_column("measured", quantity, moment), number) for moment in ("", "sd")]
    fields += [("actions", pa.list_(text)), ("failures", pa.list_(text)), ("stopped_because", text)]
    fields += [("steps", whole), ("failed_steps", whole), ("seconds", number), ("error", text)]
    return pa.schema(fields)


def row_of(folder: Path) -> Row:
    """Return the row of a complete object; what it does not know is left out."""
    row: Row = {"index": int(folder.name), "folder": f"{folder.parent.name}/{folder.name}"}
    row |= _truth(folder / OBJECT)
    if (folder / FAILURE).exists():
        failure = json.loads((folder / FAILURE).read_text(encoding="utf-8"))
        return row | {"error": f"{failure['kind']}: {failure['message']}"}
    result = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    return row | _found(result, str(row["true_material"])) | _course(result, folder)


def _truth(path: Path) -> Row:
    if not path.exists() or not path.stat().st_size:
        return {}
    drawn = read_object(path)
    known = drawn.declared
    row: Row = {"shape": known.shape, "size_sd_m": known.size_sd, "yaw_rad": known.yaw}
    row |= {f"declared_{axis}_m": edge for axis, edge in zip("xyz", known.size, strict=True)}
    row |= {"position_x_m": known.position[0], "position_y_m": known.position[1]}
    row |= {"true_material": drawn.material}
    row |= {f"true_{axis}_m": edge for axis, edge in zip("xyz", drawn.size, strict=True)}
    true = {
        "mass": drawn.mass,
        "density": drawn.mass / drawn.volume,
        "volume": drawn.volume,
        "elasticity": drawn.young_modulus,
        "friction": drawn.friction,
    }
    return row | {_column("true", name): value for name, value in true.items()} | {"true_poisson": drawn.poisson}


def _found(result: Mapping[str, Any], true_material: str) -> Row:
    posterior: Mapping[str, float] = result["belief"]["material"]
    best = max(posterior, key=lambda name: posterior[name])
    row: Row = {
        "believed_material": best,
        "believed_probability": posterior[best],
        "true_material_probability": posterior.get(true_material),
        "material_posterior": list(posterior.items()),
    }
    for quantity in QUANTITIES:
        believed = result["properties"].get(quantity)
        if believed is not None:
            row[_column("believed", quantity)] = believed["mean"]
            row[_column("believed", quantity, "sd")] = believed["sd"]
    for action in result["actions"]:
        for measured in action["measurements"]:
            if measured["property"] in MEASURED:  # the last one stands
                row[_column("measured", measured["property"])] = measured["mean"]
                row[_column("measured", measured["property"], "sd")] = measured["sd"]
    return row


def _course(result: Mapping[str, Any], folder: Path) -> Row:
    import tomllib

    failures = failed_actions(folder)
    config = tomllib.loads((folder / "config.toml").read_text(encoding="utf-8"))
    return {
        "robot_seed": config["seed"],
        "actions": [action["action"] for action in result["actions"]],
        "failures": list(failures),
        "stopped_because": result["stopped_because"],
        "steps": len(result["actions"]),
        "failed_steps": len(failures),
        "seconds": result["seconds"],
    }


def _column(kind: str, quantity: str, moment: str = "") -> str:
    return "_".join(part for part in (kind, quantity, moment, QUANTITIES[quantity]) if part)
