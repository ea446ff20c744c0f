# SPDX-License-Identifier: MIT
from shapegoogle_core.client.address import ServiceAddress as ServiceAddress
from shapegoogle_core.client.connection import Connection as Connection
from shapegoogle_core.client.opening import LibraryAddress as LibraryAddress
from shapegoogle_core.client.opening import open_library as open_library
from shapegoogle_core.client.service_library import ServiceLibrary as ServiceLibrary
from shapegoogle_core.client.tokens import KeptTokens as KeptTokens

__all__: list[str]
