# SPDX-License-Identifier: MIT
"""An example of each plug-in of Shape Google; `pyproject.toml` beside this folder names them."""
