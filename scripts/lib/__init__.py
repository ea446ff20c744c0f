# SPDX-License-Identifier: MIT
"""Helpers of the scripts beside this folder."""
