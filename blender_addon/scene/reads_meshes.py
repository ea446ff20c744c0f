# SPDX-License-Identifier: GPL-3.0-or-later
"""`ReadsMeshes`: operators that first read meshes of the scene, in slices if these are many."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from ..time_slices import InSlices, next_slice

if TYPE_CHECKING:
    from shapegoogle_core import MeshError

__all__ = ["ReadsMeshes"]


class ReadsMeshes(InSlices):
    """Base of operators that read meshes, then go on with them.

    What a single slice suffices for is read before `read_meshes` returns, so most calls are over at once.
    """

    def read_meshes(self: Any, context: Any, steps: Generator[bool, None, Any]) -> set[str]:
        """Begin to read; for `invoke`.

        Parameters
        ----------
        context : bpy.types.Context
        steps : generator
            Such as `query.query_steps`; what it returns is given to `take_meshes`.

        Returns
        -------
        result : set of str
            Of the operator.
        """
        self._read: Any = None
        self._error: MeshError | None = None
        steps = self._kept(steps)
        result: set[str] = self.begin(context, steps) if next_slice(steps) else self._go_on(context)
        return result

    def take_meshes(self, context: Any, found: Any) -> set[str]:
        """Go on with what was read; returns the operator's result."""
        raise NotImplementedError

    def take_error(self, context: Any, error: MeshError) -> set[str]:
        """Go on, or end, since nothing usable could be read; returns the operator's result."""
        raise NotImplementedError

    def take_cancelled(self, context: Any) -> set[str]:
        """End, since the user does not want it any more; returns the operator's result."""
        raise NotImplementedError

    def finish(self: Any, context: Any, *, cancelled: bool) -> set[str]:
        """Go on once all slices are done."""
        result: set[str] = self.take_cancelled(context) if cancelled else self._go_on(context)
        return result

    def _kept(self: Any, steps: Generator[bool, None, Any]) -> Generator[bool, None, None]:
        """Keep what the steps return or raise."""
        from shapegoogle_core import MeshError

        try:
            self._read = yield from steps
        except MeshError as error:
            self._error = error

    def _go_on(self: Any, context: Any) -> set[str]:
        result: set[str] = (
            self.take_meshes(context, self._read)
            if self._error is None
            else self.take_error(context, self._error)
        )
        return result
