"""The parts of a page: colours that are told apart, numbers that people read, drawings that follow the theme."""

import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special

from estimation.belief import Belief
from estimation.measurement import Measurement
from estimation.mixture import Mixture
from estimation.network import Network
from estimation.pinching import Slide
from selection.reporting.analysis import Pinching
from selection.reporting.belief_figures import change, gains
from selection.reporting.density_figures import _classes
from selection.reporting.drawing import Sheet, drawing
from selection.reporting.palette import DARK, LIGHT, SERIES, colours
from selection.reporting.reading_curve import reading_density
from selection.reporting.signal_figures import slides
from selection.reporting.story import Score
from selection.reporting.text import clean, interval, number, percent, quantity, seconds, slug

# Machado, Oliveira and Fernandes (2009), severity 1: linear RGB as seen without one kind of receptor.
BLINDNESS = {
    "none": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039],
    ],
}  # fmt: skip
NOTICED = 2.3  # just noticeable difference in L*a*b* (Mahy, Van Eycken and Oosterlinck, 1994)


def linear(colour):
    values = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """Contrast ratio as of WCAG 2."""
    a, b = sorted(float(linear(c) @ [0.2126, 0.7152, 0.0722]) for c in (one, other))
    return (b + 0.05) / (a + 0.05)


def lab(rgb):
    """CIE L*a*b* of linear sRGB under D65."""
    matrix = [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.072175],
        [0.0193339, 0.119192, 0.9503041],
    ]
    ratio = np.array(matrix) @ np.clip(rgb, 0, 1) / np.array([0.95047, 1.0, 1.08883])
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("theme", [LIGHT, DARK])
def test_text_and_marks_stand_out_from_the_page(theme):
    for name in ("ink", "soft", "accent", "alarm"):
        assert contrast(theme[name], theme["page"]) >= 4.5, name
    for name in SERIES:
        assert contrast(theme[name], theme["page"]) >= 3, name


@pytest.mark.parametrize("sight", list(BLINDNESS))
@pytest.mark.parametrize("theme", [LIGHT, DARK])
def test_colours_of_materials_are_told_apart_by_everyone(theme, sight):
    seen = {name: lab(np.array(BLINDNESS[sight]) @ linear(theme[name])) for name in SERIES}
    for one, other in itertools.combinations(SERIES, 2):
        assert np.linalg.norm(seen[one] - seen[other]) > 5 * NOTICED, (one, other)


def test_themes_have_the_same_names_and_no_colour_stands_for_two():
    assert LIGHT.keys() == DARK.keys()
    assert len(set(LIGHT.values())) == len(LIGHT)
    named = colours([f"m{i}" for i in range(9)])
    assert len({named[f"m{i}"] for i in range(6)}) == 6
    assert named["m6"] == named["m8"] == LIGHT["muted"]


@given(st.floats(allow_nan=True, allow_infinity=True), st.integers(2, 6))
def test_numbers_keep_their_digits(value, digits):
    text = number(value, digits)
    assert len(text) <= 20
    assert "e" not in text
    if math.isfinite(value) and 1e-4 <= abs(value) < 1e7:
        assert float(text.replace("−", "-")) == pytest.approx(value, rel=0.5 * 10 ** (1 - digits), abs=0.5000001)


@pytest.mark.parametrize(
    ("given_text", "expected"),
    [
        (quantity(0.0874682, 0.00195, "kg"), "87.5 ± 1.9 g"),
        (quantity(41906.0, 2202.0, "Pa"), "41.9 ± 2.2 kPa"),
        (quantity(2.05e11, 4e9, "Pa"), "205.0 ± 4.0 GPa"),
        (quantity(-0.00012, 0.0011, "kg"), "−0.1 ± 1.1 g"),
        (quantity(0.8, math.nan, "1"), "0.800"),
        (interval((0.0847, 0.0911), "kg"), "84.7 to 91.1 g"),
        (percent(0.94804), "94.8 %"),
        (percent(0.99999), "> 99.9 %"),
        (percent(1e-30), "< 0.1 %"),
        (percent(math.nan), "–"),
        (seconds(98.23), "98 s"),
        (seconds(725.0), "12 min 5 s"),
        (number(1.5e-9), "1.50 × 10⁻⁹"),
        (slug("../../Évil name!"), "vil-name"),
        (slug("///"), "unnamed"),
    ],
)
def test_people_read(given_text, expected):
    assert given_text.replace("\u00a0", " ") == expected


@given(st.text(max_size=60))
def test_cleaned_text_fits_xml(text):
    from xml.etree import ElementTree
    from xml.sax.saxutils import escape

    ElementTree.fromstring(f"<p>{escape(clean(text))}</p>")


def test_a_drawing_has_the_theme_s_colours_on_the_page_and_its_own_as_a_file():
    with drawing():
        sheet = Sheet(2.0)
        axes = sheet.axes(0.5, 0.5, 0.1, 0.1)
        for name in SERIES:
            axes.plot([0, 1], [0, 1], color=LIGHT[name], marker="o")
        axes.set_xlabel("$a_b$ <i> & 漢字")
        figure = sheet.finish("some-name", "title", "", "alt")
    assert not re.search(r"#[0-9a-f]{6}\b", figure.inline)
    for name in SERIES:
        assert f"var(--{name})" in figure.inline
        assert LIGHT[name] in figure.svg
    assert "var(" not in figure.svg
    assert "$a_b$ &lt;i&gt; &amp; 漢字" in figure.inline
    assert "http" not in figure.inline
    for target in re.findall(r'(?:url\(#|href="#)([^)"]+)', figure.inline):
        assert target.startswith("some-name-")
        assert f'id="{target}"' in figure.inline


def test_a_bar_is_as_long_as_what_it_stands_for():
    scores = (Score("a", 2.0, 10.0, 1.0, True, ""), Score("b", 1.0, 10.0, -0.5, True, ""))
    figure = gains("gains", scores, 0.1, "a")
    shades = {LIGHT[name]: name for name in ("pale", "accent", "muted")}
    bars = []
    for path, colour in re.findall(r'<path d="M ([^"]+?) z"[^>]*fill: (#\w+)', figure.svg):
        if colour in shades:
            x = [float(pair.split()[0]) for pair in path.split(" L ")]
            bars.append((shades[colour], max(x) - min(x)))
    unit = max(length for _, length in bars) / 2.0
    found = [(shade, pytest.approx(length / unit, abs=1e-3)) for shade, length in bars]
    assert found == [("pale", 2.0), ("accent", 1.0), ("pale", 1.0), ("muted", 0.5)]


def test_classes_that_nobody_believes_are_counted_together():
    before = {f"m{i}": 0.1 for i in range(10)}
    after = {f"m{i}": 0.0 for i in range(10)} | {"m3": 1.0}
    figure = change("c", "material", before, after, colours(["m3"]))
    assert "3 others" in figure.alt
    assert "m3 from 10.0" in figure.alt


@pytest.mark.parametrize(("reference", "reading"), [
    ("soft-cubes", Measurement("mass", 0.0874, 0.002, "kg")),
    ("soft-cubes", Measurement("mass", 0.0031, 0.0018, "kg")),
    ("soft-cubes", Measurement("elasticity", 42e3, 2.2e3, "Pa")),
    ("thesis-3.1-erratum", Measurement("density", 2800.0, 300.0, "kg/m^3")),
])  # fmt: skip
def test_the_dots_are_the_likelihoods(reference, reading):
    belief = Belief(Network.from_file(reference))
    heights = {
        one.name: float(reading_density(one.part, np.array([reading.mean]), reading.sd)[0])
        for one in _classes(belief, reading.property)
    }
    total = sum(heights.values())
    after = belief.update(reading).probabilities("material")
    for name, height in heights.items():
        # The belief is conditioned to first order on the log scale, the curves are drawn exactly.
        assert height / total == pytest.approx(after[name], abs=0.03)


@pytest.mark.parametrize("spread", [0.02, 0.3, 1.5, 4.0])
@pytest.mark.parametrize("sd", [1e-3, 0.1, 1.0, 5.0])
def test_density_of_a_reading_against_a_plain_sum(spread, sd):
    part = Mixture(np.array([0.4]), np.array([math.log(2.0)]), np.array([spread]), "log", "kg")
    z = np.array([-1.0, 0.01, 0.5, 1.0, 2.0, 3.5, 8.0])
    # Evenly in probability, so that nothing of the quadrature under test is in it.
    u = (np.arange(400_000) + 0.5) / 400_000
    x = 2.0 * np.exp(spread * special.ndtri(u))
    plain = 0.4 * np.exp(-0.5 * ((z[:, None] - x) / sd) ** 2).mean(axis=1) / (sd * math.sqrt(2 * math.pi))
    found = reading_density(part, z, sd)
    assert found == pytest.approx(plain, rel=0.01, abs=1e-3 * float(plain.max()))


def test_slides_of_a_rub_lie_on_the_line_of_their_friction():
    found = tuple(Slide(2 * 0.5 * force, 0.0, 2 * 0.5 * force, force, force, 0.1) for force in (4.0, 8.0))
    figure = slides("rub", Pinching(found, 0.5, 0.03))
    assert "4.00 N at 4.00 N and 8.00 N at 8.00 N" in figure.alt
    assert "μ = 0.500 ± 0.030" in figure.inline.replace("\u00a0", " ")
