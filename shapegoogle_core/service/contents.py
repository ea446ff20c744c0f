# SPDX-License-Identifier: MIT
"""What requests and answers contain, as the description of the service states it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator

from shapegoogle_core.library.decisions.decision import DecisionKind
from shapegoogle_core.library.evidence import EvidenceKind
from shapegoogle_core.library.origin import ShapeType

__all__ = [
    "AnswerPage",
    "DecisionList",
    "DecisionRecord",
    "DuplicateList",
    "ErrorAnswer",
    "Example",
    "Health",
    "Info",
    "LibraryMap",
    "MatchRecord",
    "NewDecision",
    "NewSession",
    "Place",
    "QueryRequest",
    "RequestContent",
    "SessionState",
    "ShapeDetails",
    "ShapeId",
    "ShapeList",
    "UploadAnswer",
    "Where",
]

_LARGEST_ID = 2**62
ShapeId = Annotated[int, Field(ge=1, le=_LARGEST_ID, description="Number of a shape of the library.")]
Text = Annotated[str, StringConstraints(min_length=1, max_length=500)]
Number = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Range = Annotated[
    tuple[Number | None, Number | None],
    Field(description="Least and largest value, both included; null for no limit."),
]
Rank = Literal["both", "shape", "kind"]


class RequestContent(BaseModel):
    """What a client sends: nothing but the fields that are described."""

    model_config = ConfigDict(extra="forbid")


class ErrorAnswer(BaseModel):
    """An error: one sentence that says what is wrong, and what to do."""

    error: str


class Place(BaseModel):
    """Where a shape comes from: the name of a root and a path below it, or a label with an empty root."""

    root: Annotated[str, Field(max_length=500)]
    path: Annotated[str, Field(max_length=4_000)]


class Example(RequestContent):
    """An example: a shape of the library, of an upload or of an earlier search; or a signature."""

    shape_id: ShapeId | None = None
    upload: Annotated[str, Field(max_length=64)] | None = None
    query: Annotated[str, Field(max_length=64, description="Name of an earlier search.")] | None = None
    index: Annotated[
        int, Field(ge=0, le=99, description="Which shape of the upload, or example of the search.")
    ] = 0
    signature: (
        Annotated[
            str,
            Field(max_length=1_500_000, description="A signature as base64; describe with GET /api/model."),
        ]
        | None
    ) = None

    @model_validator(mode="after")
    def _one(self) -> Example:
        given = (self.shape_id, self.upload, self.query, self.signature)
        if sum(value is not None for value in given) != 1:
            raise ValueError("an example is one of shape_id, upload, query and signature")
        return self


class Where(RequestContent):
    """Conditions that every match meets."""

    name: Text | None = None
    text: Text | None = None
    folder: Text | None = Field(None, description="Name of a root, and a folder below it: 'assets/props'.")
    sources: Annotated[list[Place], Field(min_length=1, max_length=1_000)] | None = None
    not_sources: Annotated[list[Place], Field(min_length=1, max_length=1_000)] | None = None
    tag: Text | None = None
    file_type: Text | None = None
    catalog: Text | None = None
    shape_type: ShapeType | None = None
    faces: Range | None = None
    size: Range | None = None
    area: Range | None = None
    kind: EvidenceKind | None = None
    min_similarity: Annotated[float, Field(ge=0, le=1)] | None = None


class QueryRequest(RequestContent):
    """A search."""

    like: Annotated[list[Example], Field(min_length=1, max_length=20)]
    unlike: Annotated[list[Example], Field(max_length=20)] = []
    where: Where | None = None
    rank: Rank = "both"
    families: bool = False
    limit: Annotated[int, Field(ge=1, le=1_000, description="Matches of the first page.")] = 24
    evidence: Annotated[int, Field(ge=0, le=100, description="Matches whose surfaces are compared.")] = 10


class MatchRecord(BaseModel):
    """A match."""

    shape_id: int
    name: str
    object_name: str
    source: Place
    similarity: float
    likeness: float | None
    distance: float
    evidence: dict[str, Any] | None
    placements: int
    placement: list[float] | None
    versions: int
    version_ids: list[int] = Field(description="The other shapes of its family, as far as they were met.")
    vertices: int
    faces: int
    area: float
    tags: list[str]
    shape_type: str
    catalog: str
    frame: int | None


class AnswerPage(BaseModel):
    """A page of the answer to a search."""

    query: str = Field(description="Name of the search, for further pages.")
    offset: int
    matches: list[MatchRecord]
    next: int | None = Field(description="Offset of the next page, null at the end.")
    shapes: int = Field(description="Number of shapes in the library.")


class UploadedRecord(BaseModel):
    """A shape of an upload."""

    index: int
    name: str
    object_name: str
    vertices: int
    faces: int
    area: float


class UploadAnswer(BaseModel):
    """An upload that was described."""

    upload: str
    shapes: list[UploadedRecord]
    problems: list[str]


class ShapeDetails(BaseModel):
    """A shape of the library."""

    shape_id: int
    name: str
    object_name: str
    source: Place
    vertices: int
    faces: int
    area: float
    extents: list[float]
    tags: list[str]
    placements: int
    shape_type: str
    catalog: str
    frame: int | None


class ShapeList(BaseModel):
    """Some shapes in the order of their numbers."""

    shapes: list[ShapeDetails]
    next: int | None = Field(description="For `after` of the next page, null at the end.")


class DuplicateMemberRecord(BaseModel):
    """A shape, or a file, of a group of duplicates."""

    name: str
    object_name: str
    source: Place
    shape_id: int
    similarity: float
    scale: float
    placements: int


class DuplicateRecord(BaseModel):
    """Shapes of which one would be enough."""

    kind: str
    title: str = Field(description="The kind in words.")
    similarity: float
    saving: dict[str, int]
    members: list[DuplicateMemberRecord]


class DuplicateList(BaseModel):
    """A page of the groups of duplicates; `ready` is false while they are being found."""

    ready: bool
    total: int
    offset: int
    groups: list[DuplicateRecord]
    next: int | None


class KeyRecord(BaseModel):
    """A shape as a decision names it."""

    root: str
    path: str
    object_name: str
    name: str
    fingerprint: str = Field(description="Of its mesh.")


class DecisionRecord(BaseModel):
    """A decision."""

    number: int
    kind: str
    shape: KeyRecord
    other: KeyRecord | None
    tag: str
    author: str
    time: str
    sentence: str


class DecisionList(BaseModel):
    """All decisions, oldest first."""

    decisions: list[DecisionRecord]


class NewDecision(RequestContent):
    """A decision to remember. The query of "not a match" may be an upload or a signature."""

    kind: DecisionKind
    shape: Example
    other: ShapeId | None = None
    tag: Annotated[str, Field(max_length=100)] = ""
    author: Annotated[str, Field(max_length=100, description="Used where the service has no tokens.")] = ""
    name: Annotated[str, Field(max_length=500, description="Of a shape from outside the library.")] = ""
    source: Annotated[Place | None, Field(description="Of a shape from outside the library.")] = None


class NewSession(RequestContent):
    """A token, which the service keeps in a cookie of the web page."""

    token: Annotated[str, Field(max_length=200)]


class SessionState(BaseModel):
    """What the client may do."""

    needs_token: bool
    scope: Literal["none", "read", "write"]
    name: str


class Health(BaseModel):
    """The service answers, and can read its library."""

    status: Literal["ok"]


class Info(BaseModel):
    """The library, and what the service offers."""

    library: str
    version: str
    api: int
    shapes: int
    sources: int
    failed: int
    model: str
    model_hash: str = Field(description="SHA-256 of the file that /api/model returns.")
    model_name: str
    without_views: int
    roots: list[str]
    allow_download: bool
    max_upload: int
    formats: list[str]


class MapPoint(BaseModel):
    """A shape on the map, from 0 to 1 in both directions."""

    shape_id: int
    name: str
    x: float
    y: float


class LibraryMap(BaseModel):
    """Shapes laid out so that those that are alike are near; `ready` is false while it is computed."""

    ready: bool
    total: int
    points: list[MapPoint]
