# SPDX-License-Identifier: MIT
from shapegoogle_core.api.registry import Plugin as Plugin
from shapegoogle_core.library.search.query import Query as Query
from shapegoogle_core.library.search.settings import CandidateSettings as CandidateSettings
from shapegoogle_core.library.search.settings import RerankSettings as RerankSettings
from shapegoogle_core.library.search.stages import CandidateStage as CandidateStage
from shapegoogle_core.library.search.stages import MatchReranker as MatchReranker
from shapegoogle_core.library.storage.store import Store as Store
from shapegoogle_core.mesh.io.file import FormatError as FormatError
from shapegoogle_core.mesh.io.file import MeshFile as MeshFile
from shapegoogle_core.mesh.io.polygons import Polygons as Polygons
from shapegoogle_core.plugins.installed import installed_plugins as installed_plugins

__all__: list[str]
