# SPDX-License-Identifier: MIT
"""Measurements of Shape Google, figures of its documentation and training of its models; not shipped."""
