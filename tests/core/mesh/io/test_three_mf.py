# SPDX-License-Identifier: MIT
"""Reading 3MF: units, components, places, several parts; what is refused."""

from __future__ import annotations

import io
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError, MeshWarning
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.mesh.io.file import MeshFile
from shapegoogle_core.mesh.io.objects import MeshObject, read_object, read_objects
from shapegoogle_core.mesh.io.three_mf import PlateObject, read_plate
from tests.core.mesh.io.mesh_files import AREA, POINTS, TRIANGLES, VOLUME, obj, refuse, volume, write
from tests.core.mesh.io.three_mf_files import (
    LATTICE,
    component,
    components,
    item,
    mesh_object,
    model,
    moved,
    package,
)


def plate(data: bytes) -> list[PlateObject]:
    return read_plate(MeshFile(data, Path(), 1000))


@pytest.mark.parametrize(
    ("unit", "millimetres"),
    [
        (None, 1),
        ("millimeter", 1),
        ("micron", 0.001),
        ("centimeter", 10),
        ("inch", 25.4),
        ("foot", 304.8),
        ("meter", 1000),
    ],
)
def test_all_units_become_millimetres(tmp_path: Path, unit: str | None, millimetres: float) -> None:
    data = package(model(mesh_object(1), item(1, moved(5, 0, 0)), unit=unit))
    mesh = read_mesh(write(tmp_path, "box.3mf", data))
    assert mesh.area == pytest.approx(AREA * millimetres**2)
    assert mesh.vertices[:, 0].min() == pytest.approx(5 * millimetres)


def test_an_unknown_unit(tmp_path: Path) -> None:
    refuse(write(tmp_path, "box.3mf", package(model(mesh_object(1), item(1), unit="cubit"))), "unit 'cubit'")


def test_places_and_components(tmp_path: Path) -> None:
    """A lid on a box, the pair turned and mirrored; points are rows, so they are multiplied from the left."""
    pair = components(3, component(1), component(2, moved(0, 0, 3)))
    turned = [0, 1, 0, -1, 0, 0, 0, 0, 1, 100, 0, 0]  # x becomes y, and y becomes −x
    built = item(3, turned) + item(3, moved(0, 50, 0, (-1, 1, 1))) + item(1, moved(0, 0, 70, (2, 2, 2)))
    data = package(model(mesh_object(1) + mesh_object(2, POINTS * [1, 1, 2]) + pair, built))
    mesh = read_mesh(write(tmp_path, "plate.3mf", data))
    assert len(mesh.faces) == 5 * 12
    assert volume(mesh) == pytest.approx(VOLUME * (2 * 3 + 8))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    assert low == pytest.approx([-2, 0, 0])
    assert high == pytest.approx([100, 51, 76])
    first = mesh.vertices[:16]
    assert first.min(axis=0) == pytest.approx([99, 0, 0])
    assert first.max(axis=0) == pytest.approx([100, 2, 9])


def test_components_within_components() -> None:
    resources = mesh_object(1)
    for level in range(2, 7):
        resources += components(level, component(level - 1), component(level - 1, moved(2.0**level, 0, 0)))
    (found,) = plate(package(model(resources, item(6))))
    assert len(found.polygons.sizes) == 12 * 2**5
    assert np.ptp(found.polygons.vertices[:, 0]) == 2 + 4 + 8 + 16 + 32 + 64


def test_objects_of_a_plate() -> None:
    """Each object is found by its name, with all its places."""
    resources = mesh_object(1, more='name="Gear"') + mesh_object(2, POINTS * 2, 'name="Axle &amp; pin"')
    built = item(1) + item(2, moved(9, 0, 0)) + item(1, moved(0, 0, 7))
    gear, axle = plate(package(model(resources + mesh_object(3, more='name="unused"'), built)))
    assert (gear.name, axle.name) == ("Gear", "Axle & pin")
    assert [matrix[:3, 3].tolist() for matrix in gear.matrices] == [[0, 0, 0], [0, 0, 7]]
    assert np.ptp(axle.polygons.vertices, axis=0).tolist() == [4, 2, 6]
    assert np.array_equal(gear.polygons.vertices, POINTS)


def test_without_items_all_objects_are_built() -> None:
    resources = mesh_object(1) + mesh_object(2) + components(3, component(1))
    for build in (None, ""):
        assert len(plate(package(model(resources, build)))) == 2  # the first is a component of the third


def test_supports_are_left_out(tmp_path: Path) -> None:
    resources = mesh_object(1) + "".join(
        mesh_object(number, POINTS * number, f'type="{kind}"')
        for number, kind in ((2, "support"), (3, "solidsupport"), (4, "other"), (5, "surface"))
    )
    whole = components(6, *map(component, range(1, 6)))
    data = package(model(resources + whole, item(6)))
    assert read_mesh(write(tmp_path, "plate.3mf", data)).area == pytest.approx(AREA * (1 + 25))
    data = package(model(resources, "".join(map(item, range(1, 6)))))
    assert read_mesh(write(tmp_path, "plate.3mf", data)).area == pytest.approx(AREA * (1 + 25))
    refuse(
        write(tmp_path, "plate.3mf", package(model(resources, item(2)))), "builds no object with triangles"
    )


def test_several_parts(tmp_path: Path) -> None:
    """The production extension: objects in other parts, with ids of their own."""
    other = model(mesh_object(1, POINTS * 2) + components(2, component(1, moved(1, 0, 0))))
    resources = mesh_object(1) + components(
        3, component(1), component(2, moved(0, 0, 10), 'p:path="/3D/Other/part 2.model" p:UUID="u"')
    )
    built = item(3) + item(1, more='p:path="/3d/other/PART 2.model"')
    data = package(model(resources, built, 'requiredextensions="p"'), parts={"3D/Other/part 2.model": other})
    assert read_mesh(write(tmp_path, "plate.3mf", data)).area == pytest.approx(AREA * (1 + 4 + 4))
    data = package(model(resources, built), parts={"3D/Other/part 1.model": other})
    refuse(write(tmp_path, "plate.3mf", data), "names the part '/3D/Other/part 2.model'", "does not have")


def test_parts_with_other_units(tmp_path: Path) -> None:
    other = model(mesh_object(1), unit="inch")
    resources = components(1, component(1, moved(2, 0, 0), 'p:path="/3D/b.model"'))
    data = package(model(resources, item(1), unit="centimeter"), parts={"3D/b.model": other})
    mesh = read_mesh(write(tmp_path, "plate.3mf", data))
    assert mesh.area == pytest.approx(AREA * 25.4**2)
    assert mesh.vertices[:, 0].min() == pytest.approx(20)


@pytest.mark.parametrize(
    "target", ["/3D/3dmodel.model", "3D/3dmodel.model", "/3d/3DMODEL.model", "", "/gone.model"]
)
def test_where_the_model_is(tmp_path: Path, target: str) -> None:
    data = package(model(mesh_object(1), item(1)), target)
    assert volume(read_mesh(write(tmp_path, "box.3MF", data))) == pytest.approx(VOLUME)


def test_a_model_with_another_name(tmp_path: Path) -> None:
    parts = {"parts/plate.model": model(mesh_object(1), item(1))}
    data = package("<nothing/>", "/parts/plate.model", parts=parts)
    assert volume(read_mesh(write(tmp_path, "box.3mf", data))) == pytest.approx(VOLUME)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    text = model(mesh_object(1), item(1)).replace(' encoding="UTF-8"', "")
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("3D/3dmodel.model", text.encode(encoding))
    assert volume(read_mesh(write(tmp_path, "box.3mf", data.getvalue()))) == pytest.approx(VOLUME)


def test_extensions(tmp_path: Path) -> None:
    for known in ("m", "p", "s", "m p"):
        data = package(model(mesh_object(1), item(1), f'requiredextensions="{known}"'))
        assert volume(read_mesh(write(tmp_path, "box.3mf", data))) == pytest.approx(VOLUME)
    for unknown, name in (("x", "urn:x"), ("m b", LATTICE), ("undeclared", "undeclared")):
        data = package(model(mesh_object(1), item(1), f'requiredextensions="{unknown}"'))
        refuse(write(tmp_path, "box.3mf", data), f"requires the 3MF extension {name}")
    data = package(model(mesh_object(1) + '<x:thing><x:vertex x="1"/></x:thing>', item(1)))
    assert volume(read_mesh(write(tmp_path, "box.3mf", data))) == pytest.approx(VOLUME)


def test_what_is_not_read_is_said(tmp_path: Path) -> None:
    """Beam lattices and slices that are not required leave the triangles of an object."""
    lattice = '<b:beamlattice><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice>'
    data = package(model(mesh_object(1, inside=lattice), item(1) + item(1)))
    with pytest.warns(MeshWarning, match="'box.3mf' has beam lattices beside its triangles") as found:
        mesh = read_mesh(write(tmp_path, "box.3mf", data))
    assert (len(mesh.faces), len(found)) == (24, 1)
    for quality, warned in (("lowres", True), ("fullres", False)):
        sliced = mesh_object(1, more=f's:meshresolution="{quality}" s:slicestackid="3"')
        data = package(model(sliced, item(1), 'requiredextensions="s"'))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            assert volume(read_mesh(write(tmp_path, "box.3mf", data))) == pytest.approx(VOLUME)
        assert [("coarse mesh" in str(each.message)) for each in caught] == [True] * warned


def test_the_limit_of_faces(tmp_path: Path) -> None:
    """Counted before components are put together: 2 to the power of 40 boxes are never made."""
    resources = mesh_object(1)
    for level in range(2, 42):
        resources += components(level, component(level - 1), component(level - 1))
    path = write(tmp_path, "many.3mf", package(model(resources, item(41))))
    refuse(path, "faces or more, above the limit of 100,000;", max_faces=100_000)
    refuse(path, "more than 1,000,000 components")
    empty = components(1)
    for level in range(2, 42):
        empty += components(level, component(level - 1), component(level - 1))
    path = write(tmp_path, "many.3mf", package(model(empty, item(41))))
    refuse(path, "more than 1,000,000 components")
    path = write(tmp_path, "box.3mf", package(model(mesh_object(1), item(1) + item(1))))
    refuse(path, "24 faces", "limit of 23", max_faces=23)
    refuse(path, "12 faces", "limit of 11", max_faces=11)


def test_objects_within_themselves(tmp_path: Path) -> None:
    loop = components(1, component(2)) + components(2, component(1))
    refuse(write(tmp_path, "loop.3mf", package(model(loop, item(1)))), "or an object within itself")
    chain = mesh_object(1) + "".join(components(level, component(level - 1)) for level in range(2, 300))
    refuse(write(tmp_path, "deep.3mf", package(model(chain, item(299)))), "on more than 100 levels")


def test_entities_are_not_expanded(tmp_path: Path) -> None:
    bomb = "<!DOCTYPE model [" + '<!ENTITY a "aaaaaaaaaa">'
    bomb += "".join(f'<!ENTITY {chr(98 + n)} "{f"&{chr(97 + n)};" * 10}">' for n in range(9)) + "]>"
    text = model(mesh_object(1), item(1)).replace("?>", "?>" + bomb, 1).replace('x="0.0"', 'x="&j;"', 1)
    refuse(write(tmp_path, "bomb.3mf", package(text)), "has a document type in its part")
    text = text.replace(bomb, '<!DOCTYPE model [<!ENTITY j SYSTEM "file:///etc/hostname">]>')
    refuse(write(tmp_path, "bomb.3mf", package(text)), "has a document type in its part")
    parts = {"_rels/.rels": "<!DOCTYPE a [<!ENTITY b 'c'>]><a/>"}
    data = package(model(mesh_object(1), item(1)), "", parts=parts)
    refuse(write(tmp_path, "bomb.3mf", data), "has a document type in its part '_rels/.rels'")


def test_zips_that_fill_memory(tmp_path: Path) -> None:
    """300 MB of blanks are a few hundred kilobytes in the zip; they are not unpacked."""
    data = io.BytesIO()
    archive = zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED, compresslevel=1)
    with archive, archive.open("3D/3dmodel.model", "w") as part:
        for _ in range(300):
            part.write(b" " * 1_000_000)
    refuse(
        write(tmp_path, "bomb.3mf", data.getvalue()),
        "unpacks its part '3d/3dmodel.model' to 300,000,000 bytes",
    )


def test_files_that_are_no_package(tmp_path: Path) -> None:
    good = package(model(mesh_object(1), item(1)))
    for data, word in (
        (obj(), "is not a zip"),
        (good[:200], "is not a zip"),
        (good[:-30], "is not a zip"),
        (model(mesh_object(1), item(1)).encode(), "is not a zip"),
        (package("<a/>"), "is not a 3MF model"),
        (package(model(mesh_object(1), item(1))[:-30]), "has no valid XML at line 1, column"),
        (package("plain text"), "has no valid XML at line 1, column 1 of its part '3d/3dmodel.model'"),
        (
            package(model(mesh_object(1), item(1)), compression=zipfile.ZIP_STORED).replace(
                b"vertex", b"vortex", 1
            ),
            "cannot be unpacked",
        ),
    ):
        refuse(write(tmp_path, "bad.3mf", data), word)
    other = io.BytesIO()
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("word/document.xml", "<a/>")
    refuse(write(tmp_path, "letter.3mf", other.getvalue()), "a zip without a 3D model")
    encrypted = bytearray(good)
    for mark, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        place = good.find(mark)
        while place >= 0:
            encrypted[place + offset] |= 1
            place = good.find(mark, place + 1)
    refuse(write(tmp_path, "secret.3mf", bytes(encrypted)), "is encrypted")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('x="0.0"', 'x="zero"', "an element or an encoding at line 1 of its part '3d/3dmodel.model'"),
        ('x="0.0" ', "", "an element or an encoding at line 1"),
        ('v1="0"', 'v1="0.5"', "an element or an encoding at line 1"),
        ('v1="0"', 'v1="8"', "names vertex 8, counted from 0, of the 8"),
        ('v1="0"', 'v1="-1"', "names vertex -1"),
        ('item objectid="1"', 'item objectid="7"', "names the object '7'"),
        ('item objectid="1"', "item", "an element or an encoding at line 1"),
        ('item objectid="1"', 'item objectid="1" transform="1 2 3"', "an element or an encoding at line 1"),
        (
            'item objectid="1"',
            'item objectid="1" transform="' + "nan " * 12 + '"',
            "an element or an encoding at line 1",
        ),
        ("</resources>", '<vertex x="1" y="1" z="1"/></resources>', "an element or an encoding at line 1"),
        ("</resources>", '<object id="1"></object></resources>', "two objects with the id '1'"),
    ],
)
def test_models_that_are_damaged(tmp_path: Path, old: str, new: str, word: str) -> None:
    text = model(mesh_object(1), item(1))
    assert old in text
    refuse(write(tmp_path, "bad.3mf", package(text.replace(old, new, 1))), word)


def test_volumes_of_prusaslicer(tmp_path: Path) -> None:
    """One mesh holds the model, a modifier and a support blocker; the settings tell them apart."""
    points = np.vstack([POINTS, POINTS + 10, POINTS + 20, POINTS + 30])
    faces = [tuple(corner + 8 * part for corner in face) for part in range(4) for face in TRIANGLES]
    volumes = "".join(
        f'<volume firstid="{12 * part}" lastid="{12 * part + 11}">'
        '<metadata type="volume" key="name" value="v"/>'
        f'<metadata type="volume" key="{key}" value="{value}"/></volume>'
        for part, (key, value) in enumerate(
            [
                ("volume_type", "ModelPart"),
                ("volume_type", "ParameterModifier"),
                ("modifier", "1"),
                ("volume_type", "ModelPart"),
            ]
        )
    )
    config = f'<config><object id="1"><metadata type="object" key="name" value="Bracket"/>{volumes}</object>'
    config += '<object id="2"><metadata type="object" key="name" value="Other"/></object></config>'
    resources = mesh_object(1, points, faces=faces) + mesh_object(2)
    data = package(model(resources, item(1) + item(2)), parts={"Metadata/Slic3r_PE_model.config": config})
    bracket, other = plate(data)
    assert (bracket.name, other.name) == ("Bracket", "Other")
    path = write(tmp_path, "plate.3mf", data)
    assert read_mesh(path).area == pytest.approx(AREA * (2 + 1))
    subtracted = config.replace("ParameterModifier", "NegativeVolume")
    data = package(model(resources, item(1)), parts={"Metadata/Slic3r_PE_model.config": subtracted})
    with pytest.warns(MeshWarning, match="its slicer subtracts"):
        assert read_mesh(write(tmp_path, "plate.3mf", data)).area == pytest.approx(2 * AREA)
    data = package(model(resources, item(1)), parts={"Metadata/Slic3r_PE_model.config": config[:-20]})
    refuse(write(tmp_path, "plate.3mf", data), "part 'Metadata/Slic3r_PE_model.config'")


def test_parts_of_bambu_studio() -> None:
    other = model(mesh_object(1) + mesh_object(2, POINTS * 2))
    resources = components(
        3, component(1, more='p:path="/3D/b.model"'), component(2, more='p:path="/3D/b.model"')
    )
    config = (
        '<config><object id="3"><metadata key="name" value="Vase"/><part id="1" subtype="normal_part">'
        '<metadata key="name" value="body"/></part><part id="2" subtype="modifier_part"/></object>'
        '<plate><metadata key="plater_name" value=""/></plate></config>'
    )
    parts = {"3D/b.model": other, "Metadata/model_settings.config": config}
    (vase,) = plate(package(model(resources, item(3), 'requiredextensions="p"'), parts=parts))
    assert vase.name == "Vase"
    assert np.ptp(vase.polygons.vertices, axis=0).tolist() == [2, 1, 3]


def objects_of(path: Path) -> dict[str, MeshObject]:
    return {found.object_name: found for found in read_objects(path) if isinstance(found, MeshObject)}


def test_objects_and_their_places(tmp_path: Path) -> None:
    """One object for each mesh, as its first place has it; another one where it is stretched."""
    resources = mesh_object(1, more='name="Gear"') + mesh_object(2, POINTS * 2, 'name="Gear"')
    resources += mesh_object(3, POINTS * 3)
    built = item(1, moved(5, 0, 0)) + item(1, moved(0, 0, 0, (-2, 2, 2))) + item(2) + item(3)
    built += item(1, moved(0, 9, 0, (1, 1, 2)))
    path = write(tmp_path, "plate.3mf", package(model(resources, built)))
    found = objects_of(path)
    assert list(found) == ["Gear", "Gear (2)", "Gear (3)", "Object 4"]
    gear = found["Gear"]
    assert (gear.mesh.name, len(gear.matrices)) == ("Gear", 2)
    assert gear.mesh.vertices.min(axis=0).tolist() == [5, 0, 0]
    carried = gear.mesh.vertices @ (gear.matrices[1] @ np.linalg.inv(gear.matrices[0]))[:3, :3].T
    assert np.ptp(carried, axis=0) == pytest.approx([4, 2, 6])
    assert found["Gear (2)"].mesh.extents == pytest.approx((2, 1, 6))
    assert found["Gear (3)"].mesh.extents == pytest.approx((4, 2, 6))
    assert read_object(path, "Gear (3)").extents == pytest.approx((4, 2, 6))
    with pytest.raises(MeshError, match=r"'plate.3mf' has no object 'Axle' any more"):
        read_object(path, "Axle")


def test_a_plate_of_one_object_has_the_name_of_its_file(tmp_path: Path) -> None:
    for more, name in (('name="Body 1"', "Body 1"), ("", "bracket")):
        path = write(tmp_path, "bracket.3mf", package(model(mesh_object(1, more=more), item(1))))
        (found,) = objects_of(path).values()
        assert (found.mesh.name, found.object_name) == ("bracket.3mf", name)


def test_an_object_that_is_no_shape_does_not_hide_the_others(tmp_path: Path) -> None:
    resources = mesh_object(1, POINTS * 0, 'name="dot"') + mesh_object(2, more='name="box"')
    path = write(tmp_path, "plate.3mf", package(model(resources, item(1) + item(2))))
    problems = [found for found in read_objects(path) if isinstance(found, str)]
    assert problems == ["'dot': all points of its faces coincide; export the mesh again"]
    assert list(objects_of(path)) == ["box"]


def test_other_files_are_one_object(tmp_path: Path) -> None:
    (found,) = read_objects(write(tmp_path, "box.obj", obj()))
    assert isinstance(found, MeshObject)
    assert (found.mesh.name, found.object_name, found.matrices) == ("box.obj", "", ())
    assert read_object(tmp_path / "box.obj", "").area == pytest.approx(AREA)
