# SPDX-License-Identifier: MIT
"""The report of a benchmark as an HTML page; needs matplotlib and jinja2."""

from benchmarks.report.page import write_report

__all__ = ["write_report"]
