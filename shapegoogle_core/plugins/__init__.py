# SPDX-License-Identifier: MIT
"""All that the author of a plug-in needs besides the public functions, and the list of installed ones."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
