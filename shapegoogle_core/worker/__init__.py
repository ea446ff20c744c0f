# SPDX-License-Identifier: MIT
"""Requests that a long-running process answers, with libraries and models kept open."""
