"""Files of sensor models: what they name changes, and every mistake is told in one line."""

import dataclasses

import pytest

from dynamics.errors import InvalidInput
from sim.sensors import SensorModel


def write(folder, text):
    path = folder / "noise.toml"
    path.write_text(text)
    return path


def test_file_changes_what_it_names(tmp_path):
    path = write(tmp_path, "torque_noise = [0.3, 0.2]\ntorque_drift = 0\ngrip_friction = 1.5\n")
    expected = dataclasses.replace(SensorModel(), torque_noise=(0.3, 0.2), torque_drift=0.0, grip_friction=1.5)
    assert SensorModel.from_file(path) == expected
    assert SensorModel.from_file(write(tmp_path, "")) == SensorModel()


def test_file_can_say_everything(tmp_path):
    values = {f.name: f.default for f in dataclasses.fields(SensorModel)}
    doubled = {k: [2 * x for x in v] if isinstance(v, tuple) else 2 * v for k, v in values.items()}
    found = SensorModel.from_file(write(tmp_path, "\n".join(f"{key} = {value}" for key, value in doubled.items())))
    assert dataclasses.asdict(found) == {k: tuple(v) if isinstance(v, list) else v for k, v in doubled.items()}


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("torque_noize = [0.1, 0.1]", "torque_noize"),
        ("torque_noise = 0.1", "torque_noise"),
        ("torque_noise = [0.1]", "torque_noise"),
        ("torque_noise = [0.1, -0.1]", "torque_noise"),
        ("torque_drift = nan", "torque_drift"),
        ("torque_drift = [0.1, 0.1]", "torque_drift"),
        ("effort_gain = -0.1", "effort_gain"),
        ("effort_gain = true", "effort_gain"),
        ("opening_quantum = inf", "opening_quantum"),
        ("opening_quantum = '1 mm'", "opening_quantum"),
        ("[sensors]", "sensors"),
    ],
)
def test_mistake_in_a_file(tmp_path, line, named):
    path = write(tmp_path, line + "\n")
    with pytest.raises(InvalidInput) as refusal:
        SensorModel.from_file(path)
    assert str(path) in str(refusal.value)
    assert named in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1
