# SPDX-License-Identifier: MIT
"""`LibraryDecisions`: the part of a library that remembers decisions and follows them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from shapegoogle_core.api.arguments import check_type
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.decisions.decision import (
    DECISION_KINDS,
    PAIR_KINDS,
    TAG_KINDS,
    Decision,
    DecisionKind,
    ShapeKey,
)
from shapegoogle_core.library.decisions.fingerprint import fingerprint, fingerprint_of_measures
from shapegoogle_core.library.parts.searching import LibrarySearch
from shapegoogle_core.library.storage.signatures import unpack_measures
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibraryDecisions"]

# Path of the key of a query without a source. Empty, it would be that of a shape that was added without one.
_OUTSIDE = "outside the library"


class LibraryDecisions(LibrarySearch):
    """The shapes of a library, the search in them, and what people decided about them; see `Library`.

    Parameters are those of `LibrarySearch`.
    """

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
        """Remember a decision about one or two shapes; later searches and lists of duplicates follow it.

        A shape is remembered by its source, its name and its content, so that the decision survives indexing
        the file again and moving it.

        Parameters
        ----------
        kind : {"not a match", "keep both", "master", "tag", "no tag"}
            See `Decision`.
        shape : int or ShapeSignature
            Number of a shape of this library. For a pair also the signature of a query that is not in the
            library.
        other : int, optional
            Number of the second shape, for "not a match" and "keep both".
        tag : str, optional
            For "tag" and "no tag".
        author : str, optional
            Who decides.
        name, source : str, optional
            Name and file of a query that is not in the library, for the list of decisions.

        Returns
        -------
        decision : Decision

        Raises
        ------
        LibraryError
            If there is no such shape, or the library cannot be written.
        ValueError
            If the arguments do not fit the kind.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         for size in (1, 2, 3):
        ...             _ = library.add(trimesh.creation.box((size, size, size)), name=f"box {size}")
        ...         _ = library.decide("not a match", 1, 3, author="ana")
        ...         [match.name for match in library.query(library.signature(1))]
        ['box 1', 'box 2']
        """
        self._check(kind, shape, other, tag)
        for argument, value in (("author", author), ("name", name), ("source", source)):
            check_type(argument, value, str, "a text")
        listed = [number for number in (shape, other) if isinstance(number, int)]
        for number in listed:
            has_tag = tag.strip() in self.shape(number).tags  # raises the error for an unknown shape
            if kind in TAG_KINDS and has_tag == (kind == "tag"):
                raise ValueError(
                    f"shape {number} {'has' if has_tag else 'does not have'} the tag {tag.strip()!r} already"
                )
        keys = self._keys(listed)
        if isinstance(shape, int):
            first = keys[shape]
        else:
            first = ShapeKey("", source or _OUTSIDE, name, name, fingerprint=fingerprint(shape))
        second = None if other is None else keys[other]
        decision = Decision(kind, first, second, tag.strip(), author, time.time())
        return replace(decision, number=self._store.add_decision(decision))

    def decisions(self) -> list[Decision]:
        """List what was decided about shapes of this library.

        Returns
        -------
        decisions : list of Decision
            Oldest first.

        Raises
        ------
        LibraryError
            If the library cannot be read, or its service does not answer.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         box = library.add(trimesh.creation.box(), name="box")
        ...         decision = library.decide("tag", box, tag="wood", author="ana")
        ...         [decision.sentence for decision in library.decisions()], library.shape(box).tags
        (["'box' has the tag 'wood'"], ('wood',))
        """
        return self._store.decisions()

    def undo(self, number: int) -> Decision:
        """Take a decision back.

        Parameters
        ----------
        number : int
            Of the decision.

        Returns
        -------
        decision : Decision

        Raises
        ------
        LibraryError
            If there is no such decision, or the library cannot be written.
        """
        decision = self._store.remove_decision(number)
        if decision is None:
            raise LibraryError(f"'{self.name}' has no decision {number}; list them to see their numbers")
        return decision

    def preview(self, shape_id: int) -> bytes | None:
        """Return the small mesh of a shape that can be shown when its file is not at hand.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        preview : bytes or None
            For `shapegoogle_core.rendering.read_preview`; None for a shape without one, such as those that an
            earlier version described.

        Raises
        ------
        LibraryError
            If there is no such shape.
        """
        preview = self._store.preview(shape_id)
        if preview is None and not self._store.shapes([shape_id]):
            raise self._unknown(shape_id)
        return preview

    def _hidden(self, examples: Sequence[ShapeSignature]) -> frozenset[int]:
        """Return the numbers of shapes that were decided not to match one of the examples."""
        pairs = [decision for decision in self._store.decisions() if decision.kind == "not a match"]
        if not pairs:
            return frozenset()
        asked = {fingerprint(example) for example in examples}
        # The file of the query may have changed since: then its shape as it is now counts too.
        now = self._store.shapes_of([decision.shape for decision in pairs])
        prints = self._fingerprints([number for number in now if number is not None])
        meant = [
            decision.other
            for decision, number in zip(pairs, now, strict=True)
            if decision.other is not None
            and (decision.shape.fingerprint in asked or (number is not None and prints[number] in asked))
        ]
        return frozenset(number for number in self._store.shapes_of(meant) if number is not None)

    def _keys(self, shape_ids: Sequence[int]) -> dict[int, ShapeKey]:
        prints = self._fingerprints(shape_ids)
        keys = self._store.shape_keys(shape_ids)
        return {number: replace(key, fingerprint=prints[number]) for number, key in keys.items()}

    def _fingerprints(self, shape_ids: Sequence[int]) -> dict[int, str]:
        measures = unpack_measures(self._store, shape_ids)
        found = {number: fingerprint_of_measures(own) for number, own in measures.items()}
        return found | {
            number: fingerprint(self.signature(number)) for number in shape_ids if number not in found
        }

    def _check(self, kind: DecisionKind, shape: int | ShapeSignature, other: int | None, tag: str) -> None:
        if kind not in DECISION_KINDS:
            raise ValueError(f"there is no decision {kind!r}; choose one of {', '.join(DECISION_KINDS)}")
        check_type("shape", shape, (int, ShapeSignature), "the number of a shape, or a signature")
        check_type("other", other, (int, type(None)), "the number of a shape")
        check_type("tag", tag, str, "a text")
        if isinstance(shape, ShapeSignature) and kind not in PAIR_KINDS:
            raise ValueError(f"{kind!r} needs the number of a shape of the library, not a signature")
        if (other is not None) != (kind in PAIR_KINDS):
            wanted = "two shapes" if kind in PAIR_KINDS else "one shape"
            raise ValueError(f"{kind!r} is about {wanted}; give {wanted}")
        if other is not None and other == shape:
            raise ValueError(f"{kind!r} is about two shapes; give another one than shape {other}")
        if bool(tag.strip()) != (kind in TAG_KINDS):
            raise ValueError("a tag belongs to the decisions 'tag' and 'no tag', and must not be empty there")
