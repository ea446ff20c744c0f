# SPDX-License-Identifier: MIT
from shapegoogle_core.indexing.exclusion import Exclusion as Exclusion
from shapegoogle_core.indexing.files import find_meshes as find_meshes
from shapegoogle_core.indexing.index import index_files as index_files
from shapegoogle_core.indexing.plan import plan_indexing as plan_indexing
from shapegoogle_core.indexing.progress.events import FileOutcome as FileOutcome
from shapegoogle_core.indexing.progress.events import IndexingProgress as IndexingProgress
from shapegoogle_core.indexing.progress.events import IndexReport as IndexReport
from shapegoogle_core.indexing.progress.events import IndexSummary as IndexSummary
from shapegoogle_core.indexing.reading.describing import describe_shape as describe_shape
from shapegoogle_core.indexing.reading.external_reader import ExternalReader as ExternalReader
from shapegoogle_core.indexing.reading.external_reader import ReaderError as ReaderError
from shapegoogle_core.indexing.reading.external_reader import ReaderOption as ReaderOption
from shapegoogle_core.indexing.reading.shape_reader import FileShapes as FileShapes
from shapegoogle_core.indexing.reading.shape_reader import ShapeReader as ShapeReader
from shapegoogle_core.indexing.reading.shape_reader import readable_suffixes as readable_suffixes
from shapegoogle_core.indexing.settings import IndexSettings as IndexSettings

__all__: list[str]
