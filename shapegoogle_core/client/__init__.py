# SPDX-License-Identifier: MIT
"""Libraries behind a service, as programs use them: what `shapegoogle serve` offers, over HTTP."""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
