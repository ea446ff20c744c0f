# SPDX-License-Identifier: MIT
"""What requests and answers contain that programs need and the web page does not."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field, model_validator

from shapegoogle_core.service.contents import (
    Example,
    MatchRecord,
    RequestContent,
    ShapeId,
    Where,
)

__all__ = [
    "ComparisonAnswer",
    "ComparisonRequest",
    "ListRequest",
    "PictureAnswer",
    "PlacementAnswer",
    "ShapesRequest",
    "SuggestionAnswer",
    "SuggestionRequest",
]

ShapeIds = Annotated[list[ShapeId], Field(min_length=1, max_length=1_000)]
FewShapeIds = Annotated[list[ShapeId], Field(min_length=1, max_length=100)]


class ComparisonRequest(RequestContent):
    """A query and the shapes that it is compared with."""

    like: Annotated[list[Example], Field(min_length=1, max_length=20)]
    shape_ids: ShapeIds
    where: Where | None = None
    evidence: Annotated[int, Field(ge=0, le=100, description="Matches whose surfaces are compared.")] = 10


class ComparisonAnswer(BaseModel):
    """The shapes as matches, best first, without those that are not in the library."""

    matches: list[MatchRecord]


class SuggestionRequest(RequestContent):
    """A shape, and how many of its nearest relatives vote."""

    shape: Example
    relatives: Annotated[int, Field(ge=1, le=100)] = 8
    where: Where | None = None


class SuggestionRecord(BaseModel):
    """A tag, catalog, folder or word that relatives have."""

    kind: Literal["tag", "catalog", "folder", "word"]
    text: str
    confidence: float
    relatives: list[str]


class SuggestionAnswer(BaseModel):
    """Suggestions, the most confident first."""

    suggestions: list[SuggestionRecord]


class ListRequest(RequestContent):
    """Which shapes are listed: those with some numbers, or a page of those that meet conditions."""

    shape_ids: ShapeIds | None = None
    where: Where | None = None
    after: Annotated[int, Field(ge=0, le=2**62, description="Number of the last shape before.")] = 0
    limit: Annotated[int, Field(ge=1, le=1_000)] = 100

    @model_validator(mode="after")
    def _one_way(self) -> ListRequest:
        of_a_page = {name for name in ("where", "after", "limit") if name in self.model_fields_set}
        if self.shape_ids is not None and any(getattr(self, name) is not None for name in of_a_page):
            raise ValueError(
                "shapes are listed by shape_ids, or in pages by where, after and limit; leave one of them out"
            )
        return self


class ShapesRequest(RequestContent):
    """Some shapes."""

    shape_ids: FewShapeIds


class PictureAnswer(BaseModel):
    """Pictures as PNG in base64, by the number of the shape; shapes without one are left out."""

    pictures: dict[int, str]


class PlacementRecord(BaseModel):
    """An object that shows a shape."""

    object_name: str
    matrix: Annotated[list[float], Field(min_length=16, max_length=16, description="Row by row.")]
    extents: tuple[float, float, float] | None


class PlacementAnswer(BaseModel):
    """The objects that show shapes, by the number of the shape; unknown shapes are left out."""

    placements: dict[int, list[PlacementRecord]]
