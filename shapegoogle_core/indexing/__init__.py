# SPDX-License-Identifier: MIT
"""From folders of files to a library.

`files` finds files and notices changes, the folder `reading` turns them into described shapes in worker
processes, `progress` reports what is done and what remains, and `index` is the whole run; `settings` has its
limits.
"""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
