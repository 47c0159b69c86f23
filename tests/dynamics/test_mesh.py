"""Meshes of objects: read the same from every format, measured right, and refused where no body comes of them."""

import struct

import numpy as np
import pytest

from dynamics.errors import InvalidInput
from dynamics.mesh import MAX_TRIANGLES, Mesh, read_mesh
from models.rounded_block import main, rounded_block

A, B, C = 0.04, 0.05, 0.06
CORNERS = np.array([[x, y, z] for x in (0, A) for y in (0, B) for z in (0, C)])
FACES = [  # of the box, counterclockwise seen from outside
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
]  # fmt: skip


def ascii_stl(path, faces=FACES, points=CORNERS):
    lines = ["solid box"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {' '.join(map(repr, map(float, points[i])))}" for i in face]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid"]))
    return path


def binary_stl(path, faces=FACES, points=CORNERS):
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel([points[i] for i in face]), 0) for face in faces)
    path.write_bytes(b"solid".ljust(80) + struct.pack("<I", len(faces)) + body)
    return path


def obj(path, faces=FACES, points=CORNERS):
    lines = [f"v {' '.join(map(repr, map(float, p)))}" for p in points]
    lines += [f"f {' '.join(f'{i + 1}//{i + 1}' for i in face)}" for face in faces]
    path.write_text("# a box\n" + "\n".join(lines))
    return path


@pytest.mark.parametrize(("write", "name"), [(ascii_stl, "a.stl"), (binary_stl, "a.STL"), (obj, "a.obj")])
def test_box_in_every_format(tmp_path, write, name):
    mesh = read_mesh(write(tmp_path / name))
    assert len(mesh.points) == 8
    np.testing.assert_allclose(mesh.extents, (A, B, C), rtol=1e-6)
    assert mesh.volume == pytest.approx(A * B * C, rel=1e-6)
    assert mesh.fill == pytest.approx(1.0)
    np.testing.assert_allclose(mesh.points.min(axis=0), [-A / 2, -B / 2, -C / 2], rtol=1e-6)
    np.testing.assert_allclose(mesh.center_of_volume(), 0, atol=1e-9)


def test_faces_of_four_corners_and_negative_numbers(tmp_path):
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    path = tmp_path / "a.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [
        f"f {' '.join(str(i - 8) for i in quad)}" for quad in quads
    ]
    path.write_text("\n".join(lines))
    assert read_mesh(path).volume == pytest.approx(A * B * C)


def test_units(tmp_path):
    mesh = read_mesh(obj(tmp_path / "a.obj", points=CORNERS * 1e3), unit=1e-3)
    assert mesh.volume == pytest.approx(A * B * C)


def test_volume_and_center_of_a_skewed_tetrahedron():
    rng = np.random.default_rng(0)
    for _ in range(20):
        points = rng.normal(size=(4, 3))
        volume = np.linalg.det(points[1:] - points[0]) / 6
        faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        mesh = Mesh(points, faces)
        assert mesh.volume == pytest.approx(volume)
        np.testing.assert_allclose(mesh.center_of_volume(), points.mean(axis=0), atol=1e-9)


def test_rounded_block_is_a_superellipsoid(tmp_path):
    """Its volume is a b c Gamma(1 + 1/4)^3 / Gamma(1 + 3/4); flat triangles leave a little out."""
    from scipy.special import gamma

    path = tmp_path / "block.stl"
    assert main([str(path), "--edges", "80", "56", "36", "--steps", "12"]) == 0
    mesh = read_mesh(path, 1e-3)
    exact = 0.08 * 0.056 * 0.036 * gamma(1.25) ** 3 / gamma(1.75)
    assert 0.985 * exact < mesh.volume < exact
    np.testing.assert_allclose(mesh.extents, (0.08, 0.056, 0.036), rtol=1e-6)
    assert len(rounded_block((1, 1, 1), 12)) == 6 * 144 * 2


OPEN = FACES[1:]
FLIPPED = [tuple(reversed(FACES[0])), *FACES[1:]]
INSIDE_OUT = [tuple(reversed(face)) for face in FACES]
TWO = FACES + [tuple(i + 8 for i in face) for face in FACES]
DOUBLED = [*FACES, FACES[0], tuple(reversed(FACES[0]))]
FLAT = [(0, 1, 1), *FACES[1:]]


@pytest.mark.parametrize(
    ("faces", "points", "found"),
    [
        (OPEN, CORNERS, "3 open edges"),
        (FLIPPED, CORNERS, "turn against each other"),
        (INSIDE_OUT, CORNERS, "turn inward"),
        (TWO, np.vstack([CORNERS, CORNERS + 0.1]), "separate surfaces"),
        (DOUBLED, CORNERS, "more than two triangles"),
        (FLAT, CORNERS, "without area"),
        (FACES, CORNERS * [1, 1, 0], "without extent"),
        (FACES, np.where(CORNERS == B, 1e300, CORNERS), "not finite"),
        ([], CORNERS, "no triangles"),
    ],
)
@pytest.mark.parametrize(("write", "name"), [(ascii_stl, "a.stl"), (obj, "a.obj")])
def test_surface_that_is_no_body_is_refused_with_its_file(tmp_path, write, name, faces, points, found):
    path = write(tmp_path / name, faces, points)
    with pytest.raises(InvalidInput) as refusal:
        read_mesh(path)
    assert str(path) in str(refusal.value)
    assert found in str(refusal.value)


def test_hollow_shape_whose_parts_hide_each_other_is_refused(tmp_path):
    """An L of two bars, seen from its middle: the inner corner hides a part of it."""
    outline = np.array([(0, 0), (5, 0), (5, 1), (1, 1), (1, 5), (0, 5)]) * 0.02
    points = np.array([(x, y, z) for z in (0, 0.02) for x, y in outline])
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [tuple(reversed(c)) for c in caps] + [tuple(i + 6 for i in c) for c in caps]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    path = obj(tmp_path / "l.obj", faces, points)
    with pytest.raises(InvalidInput, match="hidden from its middle"):
        read_mesh(path)


def test_too_many_triangles_are_refused(tmp_path):
    path = tmp_path / "a.stl"
    steps = int((MAX_TRIANGLES / 12) ** 0.5) + 1
    main([str(path), "--steps", str(steps)])
    with pytest.raises(InvalidInput, match=f"at most {MAX_TRIANGLES}"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("name", "content", "found"),
    [
        ("a.stl", b"", "neither binary nor ASCII"),
        ("a.stl", b"\x00" * 200, "binary"),
        ("a.stl", b"\xff" * 200, "not text"),
        ("a.stl", b"solid\nvertex 1 2\n", "3 numbers"),
        ("a.stl", b"solid\nvertex 1 2 3\n", "three for every triangle"),
        ("a.stl", b"solid\nvertex 1 2 x\n", "3 numbers"),
        ("a.obj", b"v 1 2\n", "3 numbers"),
        ("a.obj", b"v 1 2 3\nf 1 2 3\n", "a face with point 3"),
        ("a.obj", b"v 1 2 3\nf 0 1 1\n", "face corner"),
        ("a.obj", b"v 1 2 3\nf -2 1 1\n", "face corner"),
        ("a.obj", b"v 1 2 3\nf a b c\n", "face corner"),
        ("a.obj", b"v 1 2 3\nf 1 1\n", "at least three"),
        ("a.obj", b"", "no triangles"),
        ("a.ply", b"ply", "suffix"),
    ],
)
def test_files_that_are_no_mesh(tmp_path, name, content, found):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InvalidInput) as refusal:
        read_mesh(path)
    assert str(path) in str(refusal.value)
    assert found in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


def test_missing_mesh(tmp_path):
    with pytest.raises(InvalidInput, match="readable STL or OBJ"):
        read_mesh(tmp_path / "missing.stl")
