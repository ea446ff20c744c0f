# SPDX-License-Identifier: MIT
"""`ServiceDecisions`: the part of a library behind a service that decides, and sends examples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from shapegoogle_core.api.arguments import check_type
from shapegoogle_core.client.connection import Connection, NotThereError, understood
from shapegoogle_core.client.examples import Examples
from shapegoogle_core.client.records import decision_from
from shapegoogle_core.client.service_contents import ServiceContents, as_in_library
from shapegoogle_core.library.decisions.decision import Decision, DecisionKind
from shapegoogle_core.library.search.query import QueryShapes, as_query_shapes
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.mesh import as_mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["ServiceDecisions"]


class ServiceDecisions(ServiceContents):
    """The base of `ServiceLibrary`.

    Parameters
    ----------
    connection, info, model
        See `ServiceLibrary`.
    """

    def __init__(self, connection: Connection, info: Mapping[str, Any], model: ShapeModel) -> None:
        super().__init__(connection, info, model)
        self._examples = Examples()

    @as_in_library
    def decide(
        self,
        kind: DecisionKind,
        shape: int | ShapeSignature,
        other: int | None = None,
        *,
        tag: str = "",
        author: str = "",
        name: str = "",
        source: str = "",
    ) -> Decision:
        """See `Library.decide`."""
        check_type("shape", shape, (int, ShapeSignature), "the number of a shape, or a signature")
        described = [] if isinstance(shape, int) else self._described(shape, "shape")

        def asked() -> dict[str, object]:
            example = {"shape_id": shape} if not described else self._examples.listed(described)[0]
            about = {"kind": kind, "shape": example, "other": other, "tag": tag, "author": author}
            # A file of this computer that the service does not know has no name there.
            place = self._places.place(source) if source else None
            return {**about, "name": name, **({} if place is None else {"source": place})}

        answer = self._asked("decisions", asked, once=True)
        with understood(self._connection.address):
            return decision_from(answer)

    @as_in_library
    def decisions(self) -> list[Decision]:
        """See `Library.decisions`."""
        answer = self._connection.get("decisions")
        with understood(self._connection.address):
            return [decision_from(record) for record in answer["decisions"]]

    @as_in_library
    def undo(self, number: int) -> Decision:
        """See `Library.undo`."""
        answer = self._connection.delete(f"decisions/{int(number)}")
        with understood(self._connection.address):
            return decision_from(answer)

    # -- requests -------------------------------------------------------------------------------------------

    def _described(self, shapes: QueryShapes, argument: str) -> list[ShapeSignature]:
        """Describe meshes; signatures are checked and kept."""
        signatures = []
        for shape in as_query_shapes(shapes):
            if isinstance(shape, ShapeSignature):
                check_signature(shape, argument, self.model, self.name)
                signatures.append(shape)
            else:
                signatures.append(self.model.describe(as_mesh(shape, argument)))
        return signatures

    def _asked(self, path: str, asked: Callable[[], dict[str, object]], *, once: bool = False) -> Any:
        """Send a request; if the service does not know an earlier search any more, with all signatures."""
        try:
            return self._connection.post(path, asked(), once=once)
        except NotThereError:
            if not self._examples.forget():
                raise
        return self._connection.post(path, asked(), once=once)
