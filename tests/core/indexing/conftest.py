# SPDX-License-Identifier: MIT
"""Small libraries, and files to index into them."""

from tests.core.number_reader import reader  # noqa: F401
from tests.core.postgresql_server import postgresql, postgresql_url  # noqa: F401
from tests.core.small_libraries import folder, indexed, library, library_file, model_file  # noqa: F401
from tests.core.tiny_model import model  # noqa: F401
