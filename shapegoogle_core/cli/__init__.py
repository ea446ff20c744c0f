# SPDX-License-Identifier: MIT
"""The `shapegoogle` command; `commands` has a file for each of its commands.

Modules of this folder import nothing heavy: a help text, or an error in a command line, must not wait for it.
"""

from shapegoogle_core.cli.parser import main

__all__ = ["main"]
