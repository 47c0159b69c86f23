"""Logs in Parquet, through pyarrow (the extra ``parquet``): scalar columns, or lists with one number a joint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.readers.mapping import LogMap
from estimation.readers.signals import RawSignals, pick_columns, to_recording
from estimation.recording.data import Recording

MAX_ROWS = 20_000_000
BATCH = 65_536


def read_parquet(path: Path, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return the recording of a Parquet file.

    Raises:
        InvalidInput: if pyarrow is not installed, or the file can not be read.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InvalidInput(
            f"{path}", "no pyarrow", "pip install palpate[parquet], to read Parquet files"
        ) from None
    try:
        with pq.ParquetFile(path) as file:
            if file.metadata.num_rows > MAX_ROWS:
                raise InvalidInput(f"{path}", f"{file.metadata.num_rows} rows", f"{MAX_ROWS} rows at most")
            names = list(file.schema_arrow.names)
            mapping = mapping.named(names, f"{path}")
            columns, labels = _read(file, mapping)
    except (pa.ArrowException, OSError, ValueError, MemoryError, OverflowError) as error:
        raise InvalidInput(f"{path}", str(error), "a Parquet file") from None
    return to_recording(path, RawSignals(pick_columns(path, columns, mapping, names), labels=labels), mapping, arm)


def _read(file: Any, mapping: LogMap) -> tuple[dict[str, NDArray[np.float64]], list[str] | None]:
    wanted = [name for name in file.schema_arrow.names if mapping.wants(name)]
    phase = mapping.column("phase")
    labelled = phase in file.schema_arrow.names
    names = [*dict.fromkeys(wanted), *([str(phase)] if labelled else [])]
    parts: dict[str, list[NDArray[np.float64]]] = {name: [] for name in dict.fromkeys(wanted)}
    labels: list[str] = []
    for batch in file.iter_batches(batch_size=BATCH, columns=names):
        for name in parts:
            parts[name].append(_numbers(batch.column(name), name))
        if labelled:
            labels += ["" if label is None else str(label) for label in batch.column(str(phase)).to_pylist()]
    columns = {name: np.concatenate(blocks) for name, blocks in parts.items() if blocks}
    return columns, labels if labelled else None


def _numbers(column: Any, name: str) -> NDArray[np.float64]:
    """Return a column as numbers, nulls as NaN; lists of one length become two dimensions."""
    import pyarrow as pa

    kind = column.type
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
        lengths = {None if item is None else len(item) for item in column}
        if len(lengths) != 1 or None in lengths:
            raise InvalidInput(f"column {name}", f"lists of lengths {lengths}", "as many numbers in every row")
        flat: NDArray[np.float64] = np.asarray(column.flatten().to_numpy(zero_copy_only=False), float)
        return flat.reshape(len(column), -1)
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)):
        return np.full(len(column), np.nan)
    values: NDArray[np.float64] = np.asarray(column.to_numpy(zero_copy_only=False), float)
    return values
