# SPDX-License-Identifier: MIT
"""From folders of files to a library.

`files` finds files and notices changes, `reading` turns a file into shapes (`external_reader` asks another
program), `describing` is the work of a process on one file, `file_pool` spreads it over processes, and
`index` is the whole run; `settings` has its limits.
"""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
