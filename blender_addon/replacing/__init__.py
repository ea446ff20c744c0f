# SPDX-License-Identifier: GPL-3.0-or-later
"""Replace the meshes of objects by that of a match, without losing anything of theirs."""

from . import operators

__all__ = ["register", "unregister"]

register, unregister = operators.register, operators.unregister
