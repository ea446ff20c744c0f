# SPDX-License-Identifier: MIT
"""`ServiceLibrary`: a library behind a service, to be searched and decided in like a file."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

from shapegoogle_core.api.arguments import as_tuple, check_count, check_number, check_type
from shapegoogle_core.client.address import ServiceAddress
from shapegoogle_core.client.connection import Connection, understood
from shapegoogle_core.client.models import cache_folder, model_file, model_of_service
from shapegoogle_core.client.records import group_from, match_from, suggestion_from
from shapegoogle_core.client.service_contents import as_in_library, portions
from shapegoogle_core.client.service_decisions import ServiceDecisions
from shapegoogle_core.client.versions import check_versions
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.leader_clustering import Wrapper
from shapegoogle_core.library.duplicates.settings import EXPLAINED_MEMBERS, MIN_SIMILARITY
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.query import QueryShape, QueryShapes
from shapegoogle_core.library.search.settings import RANKS, EvidenceSettings, Rank
from shapegoogle_core.library.suggestions import Suggestion
from shapegoogle_core.library.suggestions.suggest import RELATIVES
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["ServiceLibrary"]

# Matches of one search, and those of one request whose surfaces are compared.
_MOST_MATCHES, _EXPLAINED = 1_000, 25
# Seconds between questions whether an answer that takes long is there.
_PAUSE = 2.0


class ServiceLibrary(ServiceDecisions):
    """A library behind a service, see `shapegoogle serve`. Connect to it with `ServiceLibrary.connect`.

    It has the methods of a `Library` for searching, looking and deciding, which give the same answers. Shapes
    are described here, and only their signatures are sent, not their meshes. Shapes are added where the
    service runs. One thread at a time may use it.

    Every method raises `LibraryError` if the service does not answer, or refuses.

    Parameters
    ----------
    connection : Connection
        To the service.
    info : mapping
        What the service says of itself.
    model : ShapeModel
        The model of its library.

    Attributes
    ----------
    model_file : Path
        Where the model is kept, if its folder can be written.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> try:
    ...     sg.ServiceLibrary.connect("http://shapes.example")
    ... except sg.LibraryError as error:
    ...     print(error)
    'http://shapes.example' is not encrypted; use https://, or http:// with a service of this computer only
    """

    def __init__(self, connection: Connection, info: Mapping[str, Any], model: ShapeModel) -> None:
        super().__init__(connection, info, model)
        self._model_hash = str(info["model_hash"])
        self.model_file = Path()

    @classmethod
    def connect(
        cls, address: str, *, token: str = "", certificate: str = "", cache: Path | None = None
    ) -> Self:
        """Connect to a service, and download the model of its library if it is not here yet.

        Parameters
        ----------
        address : str
            Such as "https://shapes.example"; ``http://`` with a service of this computer only.
        token : str, optional
            From whoever runs the service.
        certificate : str, optional
            File with the certificate of the server, where no authority has signed it.
        cache : Path, optional
            Folder that models are kept in; by default one in the user's folder for such files.

        Returns
        -------
        library : ServiceLibrary
            Also a context manager that closes the connection.

        Raises
        ------
        LibraryError
            If the service does not answer, refuses the token, or has another version.
        """
        connection = Connection(ServiceAddress.parse(address), token, certificate)
        try:
            info = connection.get("info")
            with understood(connection.address):
                check_versions(connection.address, info)
                content_hash = str(info["model_hash"])
            folder = cache or cache_folder()
            library = cls(connection, info, model_of_service(connection, content_hash, folder))
            library.model_file = model_file(content_hash, folder)
            return library
        except BaseException:
            connection.close()
            raise

    def is_current(self) -> bool:
        """Ask the service whether it still has this library, with the same model and roots.

        Returns
        -------
        current : bool
            False if another library is served now: connect again.

        Raises
        ------
        LibraryError
            If the service does not answer, or is of a version that this one does not understand.
        """
        info = self._connection.get("info")
        with understood(self._connection.address):
            check_versions(self._connection.address, info)
            self._count, self._without_views = int(info["shapes"]), int(info["without_views"])
            same_roots = {str(name) for name in info["roots"]} == set(self._places.names)
            return str(info["model_hash"]) == self._model_hash and same_roots

    @as_in_library
    def query(
        self,
        shapes: QueryShapes,
        *,
        top: int = 10,
        explain: int = 10,
        exact: bool = False,
        unlike: QueryShapes = (),
        where: Filter | None = None,
        families: bool = False,
        rank: Rank = "both",
    ) -> list[Match]:
        """See `Library.query`."""
        check_count("top", top, 1)
        check_count("explain", explain, 0)
        check_type("where", where, (Filter, type(None)), "a shapegoogle_core.Filter")
        if rank not in RANKS:
            raise ValueError(f"there is no order {rank!r}; choose one of {', '.join(RANKS)}")
        if exact:
            raise LibraryError(f"'{self.name}' does not compare all shapes in full; search without that")
        if top > _MOST_MATCHES:
            raise LibraryError(f"'{self.name}' returns {_MOST_MATCHES:,} matches at most; ask for fewer")
        examples, negative = self._described(shapes, "query"), self._described(unlike, "unlike")
        if not examples:
            raise ValueError("there is nothing to search for: give at least one mesh or signature")
        conditions = self._places.conditions(where)
        if conditions is None:
            return []
        explained = min(explain, top)

        def asked() -> dict[str, object]:
            return {
                "like": self._examples.listed(examples),
                "unlike": self._examples.listed(negative),
                "rank": rank,
                "families": families,
                "limit": top,
                "evidence": min(explained, _EXPLAINED),
                **({"where": conditions} if conditions else {}),
            }

        answer = self._asked("queries", asked)
        with understood(self._connection.address):
            self._count = int(answer["shapes"])
            for index, example in enumerate(examples):
                self._examples.remember(example, {"query": str(answer["query"]), "index": index})
            matches = [match_from(record, self._places) for record in answer["matches"]]
        if explained <= _EXPLAINED:
            return matches
        return [
            *matches[:_EXPLAINED],
            *self.explain(examples, matches[_EXPLAINED:], explained - _EXPLAINED, where=where),
        ]

    @as_in_library
    def explain(
        self,
        signatures: QueryShapes,
        matches: Match | Sequence[Match],
        count: int | None = None,
        *,
        where: Filter | None = None,
    ) -> list[Match]:
        """See `Library.explain`."""
        count = EvidenceSettings.explained if count is None else count
        check_count("count", count, 0)
        matches = as_tuple("matches", matches, Match, "a Match, or several")
        examples = self._described(signatures, "signatures")
        explained: list[Match] = []
        for some in portions(matches[:count], _EXPLAINED):
            numbers = [match.shape_id for match in some]
            found = self._compared(examples, numbers, len(numbers), where)
            there = {match.shape_id: match for match in found}
            explained += [
                _explained_by(match, there[match.shape_id]) if match.shape_id in there else match
                for match in some
            ]
        return [*explained, *matches[count:]]

    @as_in_library
    def versions(self, shapes: QueryShapes, match: Match, *, explain: int = 10) -> list[Match]:
        """See `Library.versions`."""
        check_type("match", match, Match, "a Match")
        return self.compare_with(shapes, (match.shape_id, *match.version_ids), explain=explain)

    @as_in_library
    def compare_with(
        self,
        shapes: QueryShapes,
        shape_ids: Sequence[int],
        *,
        explain: int = 10,
        where: Filter | None = None,
    ) -> list[Match]:
        """See `Library.compare_with`."""
        check_count("explain", explain, 0)
        examples = self._described(shapes, "shapes")
        if not examples:
            raise ValueError("there is nothing to compare with: give at least one mesh or signature")
        numbers = list(dict.fromkeys(shape_ids))
        if not numbers:
            return []
        # Of a family with more shapes, the service has met these first.
        matches = self._compared(examples, numbers[:_MOST_MATCHES], min(explain, _EXPLAINED), where)
        if explain <= _EXPLAINED:
            return matches
        first, others = matches[:_EXPLAINED], matches[_EXPLAINED:]
        return [*first, *self.explain(examples, others, explain - _EXPLAINED, where=where)]

    @as_in_library
    def suggest(
        self, shape: QueryShape | int, *, relatives: int = RELATIVES, where: Filter | None = None
    ) -> list[Suggestion]:
        """See `Library.suggest`."""
        check_count("relatives", relatives, 1)
        conditions = self._places.conditions(where)
        if conditions is None:
            return []
        described = [] if isinstance(shape, int) else self._described(shape, "shape")

        def asked() -> dict[str, object]:
            example = {"shape_id": shape} if not described else self._examples.listed(described)[0]
            limits = {"where": conditions} if conditions else {}
            return {"shape": example, "relatives": relatives, **limits}

        answer = self._asked("suggestions", asked)
        with understood(self._connection.address):
            return [suggestion_from(record) for record in answer["suggestions"]]

    @as_in_library
    def duplicates(
        self,
        min_similarity: float = MIN_SIMILARITY,
        progress: Wrapper | None = None,  # noqa: ARG002 - the service does not tell
        *,
        explained: int = EXPLAINED_MEMBERS,
    ) -> list[DuplicateGroup]:
        """See `Library.duplicates`."""
        check_number("min_similarity", min_similarity, most=1, positive=True)
        check_count("explained", explained, 0)
        if explained != EXPLAINED_MEMBERS:
            raise LibraryError(
                f"'{self.name}' chooses itself how many shapes it compares; leave their number out"
            )
        if min_similarity < 0.5:
            raise LibraryError(f"'{self.name}' lists shapes with a similarity of 0.5 or more only")
        groups: list[DuplicateGroup] = []
        offset: int | None = 0
        while offset is not None:
            page = self._connection.get(
                "duplicates", offset=offset, limit=100, min_similarity=round(min_similarity, 2)
            )
            with understood(self._connection.address):
                if not page["ready"]:
                    time.sleep(_PAUSE)
                    groups, offset = [], 0
                    continue
                groups += [group_from(record, self._places) for record in page["groups"]]
                following = None if page["next"] is None else int(page["next"])
                if following is not None and following <= offset:
                    raise ValueError  # it would never end
                offset = following
        return groups

    def _compared(
        self, examples: Sequence[ShapeSignature], numbers: Sequence[int], evidence: int, where: Filter | None
    ) -> list[Match]:
        conditions = self._places.conditions(where)

        def asked() -> dict[str, object]:
            limits = {"where": conditions} if conditions else {}
            like = self._examples.listed(examples)
            return {"like": like, "shape_ids": list(numbers), "evidence": evidence, **limits}

        answer = self._asked("comparisons", asked)
        with understood(self._connection.address):
            return [match_from(record, self._places) for record in answer["matches"]]

    def signature(self, shape_id: int) -> ShapeSignature:
        """Return the signature of a shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        signature : ShapeSignature
            As the library has it. A search with it sends only the number of the shape.

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        signature = super().signature(shape_id)
        self._examples.remember(signature, {"shape_id": shape_id})
        return signature


def _explained_by(match: Match, compared: Match) -> Match:
    """Complete a match of a search by what comparing the surfaces has found."""
    return replace(
        match,
        evidence=compared.evidence,
        similarity=compared.similarity,
        object_name=compared.object_name,
        area=compared.area,
        placement=compared.placement,
    )
