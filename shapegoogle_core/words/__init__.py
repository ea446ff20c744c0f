# SPDX-License-Identifier: MIT
"""Geometric words: vocabulary, assignment, bags, tf-idf weighting and binary codes (paper, sections 4 and 5).

Names are imported when they are first used: the estimators are built on scikit-learn, and only training needs
them.
"""

from shapegoogle_core.api.lazy_names import lazy_names

__all__, __getattr__, __dir__ = lazy_names(__name__)
