# SPDX-License-Identifier: MIT
"""The page that shows what a benchmark found; needs matplotlib and jinja2."""

from benchmarks.report.page import write_report

__all__ = ["write_report"]
