"""CSV logs: units, signs and columns as the map says; corrupt lines rejected by number, the rest kept."""

import logging

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.readers.csv import ColumnMap, read_csv

MAP = {"time": 0, "q": [1, 2], "dq": [3, 4], "current": [5, 6]}


@pytest.fixture
def lines():
    rng = np.random.default_rng(0)
    table = np.column_stack([100 + 0.01 * np.arange(50), rng.normal(size=(50, 6))])
    return [",".join(f"{value:.6f}" for value in row) for row in table]


def write(tmp_path, lines):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_columns_are_read_as_mapped(tmp_path, lines):
    log = read_csv(write(tmp_path, lines), ColumnMap.from_table(MAP))
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    np.testing.assert_array_equal(log.time, table[:, 0])
    np.testing.assert_array_equal(log.q, table[:, 1:3])
    np.testing.assert_array_equal(log.dq, table[:, 3:5])
    np.testing.assert_array_equal(log.effort, table[:, 5:])
    assert (log.effort_kind, log.rejected) == ("current", ())


def test_units_signs_names_and_delimiter(tmp_path, lines):
    named = ["t;a;b;c;d;e;f", *(line.replace(",", ";") for line in lines)]
    table = {"time": "t", "q": ["b", "a"], "torque": ["e", "f"], "delimiter": ";", "angle_unit": "deg"}
    log = read_csv(write(tmp_path, named), ColumnMap.from_table({**table, "torque_sign": -1}))
    plain = read_csv(write(tmp_path, lines), ColumnMap.from_table(MAP))
    np.testing.assert_allclose(log.q, np.radians(plain.q[:, ::-1]))
    np.testing.assert_allclose(log.effort, -plain.effort)
    assert log.dq is None


def test_corrupt_lines_are_rejected_by_number(tmp_path, lines, caplog):
    bad = list(lines)
    bad[4] = bad[4] + ",1.0"  # line 5: a column too many
    bad[9] = "1,2"  # line 10: torn
    bad[14] = bad[14].replace(",", ",x", 1)  # line 15: not a number
    cells = bad[19].split(",")
    bad[19] = ",".join([*cells[:3], "1e200", *cells[4:]])  # line 20
    bad[24] = ",".join(["1e9", *bad[24].split(",")[1:]])  # line 25: the clock leaps and comes back
    bad[29] = ",".join(["3.0", *bad[29].split(",")[1:]])  # line 30: the clock falls back
    bad[34] = bad[34].replace(",", ",nan,", 1).rsplit(",", 1)[0]  # line 35
    bad[39] = "\x00\ufffd" * 10  # line 40: rubbish
    with caplog.at_level(logging.WARNING):
        log = read_csv(write(tmp_path, bad), ColumnMap.from_table(MAP))
    assert [number for number, _ in log.rejected] == [5, 10, 15, 20, 25, 30, 35, 40]
    assert len(log) == 42
    assert "8 corrupt lines" in caplog.text
    assert np.all(np.diff(log.time) > 0)


def test_a_pause_of_the_clock_is_no_corruption(tmp_path, lines):
    later = [f"{float(line.split(',')[0]) + 60:.6f},{line.split(',', 1)[1]}" for line in lines[25:]]
    log = read_csv(write(tmp_path, lines[:25] + later), ColumnMap.from_table(MAP))
    assert log.rejected == ()


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"q": [1]}, "dq|current"),
        ({"torque": [5, 6]}, "exactly one"),
        ({"speed": [1]}, "unknown entry speed"),
        ({"angle_unit": "grad"}, "rad, deg"),
        ({"torque_sign": 2}, "1 or -1"),
        ({"q": "1,2"}, "list of columns"),
        ({"q": [1, -2]}, "column numbers"),
        ({"q": [True, 2]}, "column numbers"),
        ({"delimiter": ""}, "one character"),
        ({"time": None}, "time"),
    ],
)
def test_bad_maps_are_refused(change, word):
    with pytest.raises(InvalidInput, match=word):
        ColumnMap.from_table({**MAP, **change})


def test_unreadable_files_are_refused(tmp_path, lines):
    with pytest.raises(InvalidInput, match="readable"):
        ColumnMap.from_file(tmp_path / "none.toml")
    with pytest.raises(InvalidInput, match="readable"):
        read_csv(tmp_path / "none.csv", ColumnMap.from_table(MAP))
    broken = tmp_path / "broken.toml"
    broken.write_text("time = ")
    with pytest.raises(InvalidInput, match="TOML"):
        ColumnMap.from_file(broken)
    with pytest.raises(InvalidInput, match="at least 10"):
        read_csv(write(tmp_path, lines), ColumnMap.from_table({**MAP, "current": [5, 9]}))
    with pytest.raises(InvalidInput, match="0 good lines"):
        read_csv(write(tmp_path, ["a,b,c,d,e,f,g"] * 30), ColumnMap.from_table(MAP))
    with pytest.raises(InvalidInput, match="a, b"):
        read_csv(write(tmp_path, ["a,b", *lines]), ColumnMap.from_table({**MAP, "time": "t"}))
    with pytest.raises(InvalidInput):
        read_csv(write(tmp_path, [""]), ColumnMap.from_table(MAP))
