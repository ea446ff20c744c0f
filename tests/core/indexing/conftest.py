# SPDX-License-Identifier: MIT
"""Small libraries, and files to index into them."""

from tests.core.number_reader import reader  # noqa: F401
from tests.core.small_libraries import folder, indexed, library, library_file, model, model_file  # noqa: F401
