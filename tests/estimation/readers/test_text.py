"""CSV logs: units, signs and columns as the map says; corrupt lines rejected by number, the rest kept."""

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from estimation.payload.motion_rows import JointLog
from estimation.readers import LogMap, read_log

COLUMNS = {"time": 0, "q": [1, 2], "dq": [3, 4], "current": [5, 6]}


def mapped(columns=COLUMNS, units=None, **options):
    return LogMap.from_tables({"columns": columns, "units": units or {}, "options": options}, "map")


@pytest.fixture
def lines():
    rng = np.random.default_rng(0)
    table = np.column_stack([100 + 0.01 * np.arange(50), rng.normal(size=(50, 6))])
    return [",".join(f"{value:.6f}" for value in row) for row in table]


def write(tmp_path, lines):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_columns_are_read_by_number(tmp_path, lines):
    log = read_log(write(tmp_path, lines), mapped())
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    np.testing.assert_array_equal(log.samples.time, table[:, 0])
    np.testing.assert_array_equal(log.samples.q, table[:, 1:3])
    np.testing.assert_array_equal(log.samples.dq, table[:, 3:5])
    np.testing.assert_array_equal(log.samples.tau, table[:, 5:])
    assert (log.drive_effort, log.rejections.count) == ("current", 0)
    assert "motor currents" in log.notes[0]
    motion = JointLog.of(log)
    assert motion.effort_kind == "current"
    np.testing.assert_array_equal(motion.effort, table[:, 5:])


def test_units_signs_names_and_delimiter(tmp_path, lines):
    named = ["a time;a;b;c;d;e;f", *(line.replace(",", ";") for line in lines)]
    columns = {"time": "a time", "q": ["b", "a"], "tau": ["e", "f"]}
    log = read_log(
        write(tmp_path, named), mapped(columns, {"q": "deg", "tau": "N mm"}, delimiter=";", torque_sign=-1)
    )
    plain = read_log(write(tmp_path, lines), mapped()).samples
    np.testing.assert_allclose(log.samples.q, np.radians(plain.q[:, ::-1]))
    np.testing.assert_allclose(log.samples.tau, -plain.tau / 1000)
    assert log.drive_effort == "torque"
    assert not log.has_velocities
    assert JointLog.of(log).dq is None


def test_numbers_and_names_of_a_header_are_one(tmp_path, lines):
    headed = write(tmp_path, ["t,q,q,v,w,i,i", *lines])
    by_number = read_log(headed, mapped()).samples
    by_both = read_log(headed, mapped({"time": "t", "q": [1, 2], "dq": ["v", 4], "current": [5, "i (column 6)"]}))
    np.testing.assert_array_equal(by_both.samples.tau, by_number.tau)
    np.testing.assert_array_equal(by_both.samples.q, by_number.q)


def test_currents_may_be_reversed(tmp_path, lines):
    path = write(tmp_path, lines)
    plain, turned = read_log(path, mapped()).samples, read_log(path, mapped(torque_sign=-1)).samples
    np.testing.assert_array_equal(turned.tau, -plain.tau)


def test_corrupt_lines_are_rejected_by_number(tmp_path, lines):
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
    good = read_log(write(tmp_path, lines), mapped()).samples
    log = read_log(write(tmp_path, bad), mapped())
    kept = [n for n in range(50) if n + 1 not in (5, 10, 15, 20, 25, 30, 35, 40)]
    np.testing.assert_array_equal(log.samples.time, good.time[kept])
    np.testing.assert_array_equal(log.samples.q, good.q[kept])
    assert log.rejections.count == 8
    assert [reason.split(":")[0] for reason in log.rejections.reasons] == [
        f"line {n}"
        for n in (5, 10, 15, 40, 20)  # those that are no rows at all come first
    ]


def test_a_pause_of_the_clock_is_no_corruption(tmp_path, lines):
    later = [f"{float(line.split(',')[0]) + 60:.6f},{line.split(',', 1)[1]}" for line in lines[25:]]
    assert read_log(write(tmp_path, lines[:25] + later), mapped()).rejections.count == 0


def test_times_of_a_motion_increase(tmp_path, lines):
    log = JointLog.of(read_log(write(tmp_path, [lines[0], *lines]), mapped()))
    assert len(log) == 50


@pytest.mark.parametrize(
    ("columns", "word"),
    [
        ({**COLUMNS, "tau": [5, 6]}, "one of them"),
        ({**COLUMNS, "speed": [1]}, "speed"),
        ({**COLUMNS, "q": [1, -2]}, "number from 0"),
        ({**COLUMNS, "q": [True, 2]}, "number from 0"),
        ({**COLUMNS, "q": []}, "number from 0"),
        ({**COLUMNS, "time": [0]}, "number from 0"),
    ],
)
def test_bad_columns_are_refused(columns, word):
    with pytest.raises(InvalidInput, match=word):
        mapped(columns)


@pytest.mark.parametrize(
    ("options", "word"),
    [({"delimiter": ";;"}, "one character"), ({"torque_sign": 2}, "1, -1"), ({"torque_sign": "auto"}, "1 or -1")],
)
def test_bad_options_are_refused(options, word):
    with pytest.raises(InvalidInput, match=word):
        mapped(**options)


def test_unusable_files_are_refused(tmp_path, lines):
    with pytest.raises(InvalidInput, match="0 to 6"):
        read_log(write(tmp_path, lines), mapped({**COLUMNS, "current": [5, 9]}))
    with pytest.raises(InvalidInput, match="a, b"):
        read_log(write(tmp_path, ["a,b", "1,2"]), mapped({"time": "t", "q": ["b"]}))
    with pytest.raises(InvalidInput, match="no torques of the joints"):
        JointLog.of(read_log(write(tmp_path, lines), mapped({"time": 0, "q": [1, 2]})))
    with pytest.raises(InvalidInput, match="one column a joint"):
        read_log(write(tmp_path, lines), mapped({**COLUMNS, "q": [1]}))
    with pytest.raises(InvalidInput):
        read_log(write(tmp_path, [""]), mapped())
