# SPDX-License-Identifier: MIT
"""The `shapegoogle` command: one file per command.

Modules of this folder import nothing heavy: a help text, or an error in a command line, must not wait for it.
"""

from shapegoogle_core.cli.parser import main

__all__ = ["main"]
