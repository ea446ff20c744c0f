# SPDX-License-Identifier: MIT
"""`python -m shapegoogle_core` is the command `shapegoogle`."""

from shapegoogle_core.cli import main

__all__: list[str] = []

if __name__ == "__main__":
    raise SystemExit(main())
