# SPDX-License-Identifier: MIT
"""Errors of this package, one class for each kind of input, and its warning."""

from __future__ import annotations

__all__ = ["LibraryError", "MeshError", "MeshWarning", "ModelError", "PluginError", "ShapeGoogleError"]


class ShapeGoogleError(Exception):
    """Base class of all errors that this package raises on purpose.

    The message is one sentence that names the input, says what is wrong with it and what to do.

    Parameters
    ----------
    template : str
        The message; with values, each stands in it as its name in braces.
    **values : object
        Values of the message. Programs that speak other languages translate the template and fill them in.

    Attributes
    ----------
    template : str
    values : dict of str to object

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> try:
    ...     sg.read_mesh("horse.ply")
    ... except sg.ShapeGoogleError as error:
    ...     print(error)
    'horse.ply' does not exist; give the path of a mesh file
    >>> sg.ShapeGoogleError("{name!r} is empty; save it again", name="horse.ply").values
    {'name': 'horse.ply'}
    """

    def __init__(self, template: str = "", **values: object) -> None:
        # A message without values may have braces of its own, such as in the name of a file.
        super().__init__(template.format(**values) if values else template)
        self.template = template
        self.values = values


class MeshError(ShapeGoogleError, ValueError):
    """A mesh, or a file that should hold one, cannot be used.

    It is a `ValueError` too, since the arguments of a function are often the cause.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> try:
    ...     sg.Mesh([[0, 0, 0], [1, 0, 0]], [[0, 1, 2]], name="horse")
    ... except sg.MeshError as error:
    ...     print(error)
    'horse': a face names vertex 2, but indices must be 0 to 1; subtract 1 if yours count from 1, or export
    the mesh again if it was cut short
    """


class MeshWarning(UserWarning):
    r"""A part of a mesh file was left out; the message is one sentence that names the file and the part.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import tempfile, warnings
    >>> from pathlib import Path
    >>> points = "".join(f"{i % 4} {i // 4} {i % 3}\n" for i in range(16))
    >>> with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as found:
    ...     warnings.simplefilter("always", sg.MeshWarning)
    ...     path = Path(folder, "scan.xyz")
    ...     _ = path.write_text(points + "nan nan nan\n")
    ...     scan = sg.read_mesh(path)
    >>> scan, str(found[0].message)
    (Mesh('scan.xyz', 16 vertices, 0 faces), "'scan.xyz' has 1 of 17 points without finite coordinates ...")
    """


class LibraryError(ShapeGoogleError):
    """A library cannot be opened, read or written.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> try:
    ...     sg.Library.open("missing.sglib", read_only=True)
    ... except sg.LibraryError as error:
    ...     print(error)
    there is no library 'missing.sglib'; check the name, or index a folder into it first
    """


class ModelError(ShapeGoogleError):
    """A model cannot be loaded or trained, or does not fit the shapes or the library it is used with.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> try:
    ...     sg.load_model("missing.npz")
    ... except sg.ModelError as error:
    ...     print(error)
    cannot read the model 'missing.npz': ...; give a file made by `shapegoogle train`, or one of ...
    """


class PluginError(ShapeGoogleError):
    """A plug-in of another package cannot be loaded, or fails; the message names the package.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> from shapegoogle_core.plugins import Plugin
    >>> plugin = Plugin("descriptor", "curvature", "my-shapes", "1.0", "my_shapes:curvature")
    >>> try:
    ...     raise plugin.unfit("return finite numbers")
    ... except sg.PluginError as error:
    ...     print(error)
    the descriptor 'curvature' of the package 'my-shapes 1.0' must return finite numbers; update the ...
    """
