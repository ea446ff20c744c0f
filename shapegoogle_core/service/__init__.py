# SPDX-License-Identifier: MIT
"""The HTTP service of a library, and its web page. Needs the extra `serve`."""
