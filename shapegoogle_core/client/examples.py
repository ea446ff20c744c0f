# SPDX-License-Identifier: MIT
"""`Examples`: signatures as a service takes them, each sent only once."""

from __future__ import annotations

import base64
import hashlib
from collections import OrderedDict
from collections.abc import Sequence

from shapegoogle_core.library.storage.signature_file import signature_to_bytes
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Examples"]

Example = dict[str, object]

# Signatures that are known by what they are on the service.
_MOST = 200


class Examples:
    """What signatures are on a service: shapes of its library, or examples of an earlier search."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, Example] = OrderedDict()

    def listed(self, signatures: Sequence[ShapeSignature]) -> list[Example]:
        """Return signatures as the service takes them.

        Parameters
        ----------
        signatures : sequence of ShapeSignature

        Returns
        -------
        examples : list of dict
            References where the service has them already.
        """
        listed = []
        for signature in signatures:
            # Without the surface, which is a mesh.
            content = signature_to_bytes(signature)
            known = self._known.get(hashlib.sha256(content).hexdigest())
            listed.append(known or {"signature": base64.b64encode(content).decode()})
        return listed

    def remember(self, signature: ShapeSignature, example: Example) -> None:
        """Note what a signature is on the service.

        Parameters
        ----------
        signature : ShapeSignature
        example : dict
        """
        name = hashlib.sha256(signature_to_bytes(signature)).hexdigest()
        self._known[name] = example
        self._known.move_to_end(name)
        if len(self._known) > _MOST:
            self._known.popitem(last=False)

    def forget(self) -> bool:
        """Forget everything, since the service may have; return whether there was anything."""
        known = bool(self._known)
        self._known.clear()
        return known
