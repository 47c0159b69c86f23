"""Logs in NumPy's NPZ: arrays ``time``, ``q``, ``tau`` ... or as a column map names them."""

from __future__ import annotations

import math
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dynamics.arm import Arm
from dynamics.errors import InvalidInput
from estimation.readers.mapping import LogMap
from estimation.readers.signals import RawSignals, pick_columns, to_recording
from estimation.recording.data import Recording

MAX_BYTES = 2**31  # of one array


def read_npz(path: Path, mapping: LogMap, arm: Arm | None = None) -> Recording:
    """Return the recording of an NPZ file; nothing in it is ever executed.

    Raises:
        InvalidInput: if it is no NPZ file, or its arrays do not fit together.
    """
    arrays: dict[str, NDArray[np.float64]] = {}
    labels: list[str] | None = None
    phase = mapping.column("phase")
    try:
        with zipfile.ZipFile(path) as archive:
            for info in archive.infolist():
                name = info.filename.removesuffix(".npy")
                array = _read_array(archive, info)
                if name == phase and array.dtype.kind in "US" and array.ndim == 1:
                    labels = _texts(array)
                elif array.dtype.kind in "fiub" and array.ndim in (1, 2):
                    arrays[name] = array.astype(float)
                elif array.dtype.names is not None and array.ndim == 1:
                    arrays |= _fields(array)
    except Exception as error:  # the libraries raise whatever a damaged file provokes, from EOFError to TokenError
        raise InvalidInput(f"{path}", str(error) or type(error).__name__, "an NPZ file of numbers") from None
    signals = pick_columns(path, arrays, mapping)
    lengths = {name: len(values) for name, values in signals.items()}
    if labels is not None:
        lengths["phase"] = len(labels)
    if len(set(lengths.values())) > 1:
        raise InvalidInput(f"{path}: lengths", lengths, "arrays of one length")
    return to_recording(path, RawSignals(signals, labels=labels), mapping, arm)


def _read_array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    """Return one array, its declared size checked before memory is taken."""
    form = np.lib.format
    with archive.open(info) as file:
        version = form.read_magic(file)
        read_header = form.read_array_header_1_0 if version == (1, 0) else form.read_array_header_2_0
        shape, _, dtype = read_header(file)
        size = math.prod(shape) * dtype.itemsize
        if dtype.hasobject or size > min(MAX_BYTES, info.file_size):
            raise ValueError(f"{info.filename}: {size} bytes of {dtype} declared, {info.file_size} there")
    with archive.open(info) as file:
        array: NDArray[Any] = form.read_array(file, allow_pickle=False)
    return array


def _texts(array: NDArray[Any]) -> list[str]:
    """Return labels; NumPy itself would make strings of what is no character."""
    if array.dtype.kind == "S":
        return [label.decode("utf-8", "replace") for label in array.tolist()]
    codes = np.frombuffer(array.tobytes(), np.dtype(np.uint32).newbyteorder(array.dtype.byteorder))
    if len(codes) and codes.max() > sys.maxunicode:
        raise ValueError("a label that is no text")
    return [str(label) for label in array]


def _fields(array: NDArray[Any]) -> dict[str, NDArray[np.float64]]:
    names = array.dtype.names or ()
    return {name: array[name].astype(float) for name in names if array[name].dtype.kind in "fiub"}
