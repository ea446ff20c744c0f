# SPDX-License-Identifier: MIT
"""What can go wrong, one class for each kind of input."""

__all__ = ["LibraryError", "MeshError", "ModelError", "ShapeGoogleError"]


class ShapeGoogleError(Exception):
    """Base of all errors that this package raises on purpose.

    The message is one sentence that names the input, says what is wrong with it and what to do.
    """


class MeshError(ShapeGoogleError, ValueError):
    """A mesh, or a file that should hold one, cannot be used."""


class LibraryError(ShapeGoogleError):
    """A library file cannot be opened, read or written."""


class ModelError(ShapeGoogleError):
    """A model cannot be loaded, or does not fit what it is asked to do."""
