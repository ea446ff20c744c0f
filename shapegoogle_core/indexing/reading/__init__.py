# SPDX-License-Identifier: MIT
"""From files to described shapes.

`shape_reader` turns a file into shapes (`external_reader` asks another program), `describing` is the work of
a process on one file, and `file_pool` spreads it over processes.
"""
