# SPDX-License-Identifier: MIT
"""Geometric words: vocabulary, assignment, bags, tf-idf weighting and binary codes (paper, sections 4 and 5).

The functions that describe a shape are imported at once. The estimators, which are built on scikit-learn and
only needed to train a model, are imported when they are first used.
"""

import importlib
from typing import TYPE_CHECKING

from shapegoogle_core.words.assignment import hard_words, soft_words
from shapegoogle_core.words.bags import bag_of_features, spatially_sensitive_bag

if TYPE_CHECKING:
    from shapegoogle_core.words.hashing import SimilaritySensitiveHashing, rotated_components
    from shapegoogle_core.words.tfidf import InverseDocumentFrequency
    from shapegoogle_core.words.vocabulary import Vocabulary

__all__ = [
    "InverseDocumentFrequency",
    "SimilaritySensitiveHashing",
    "Vocabulary",
    "bag_of_features",
    "hard_words",
    "rotated_components",
    "soft_words",
    "spatially_sensitive_bag",
]

_ESTIMATORS = {
    "InverseDocumentFrequency": "tfidf",
    "SimilaritySensitiveHashing": "hashing",
    "Vocabulary": "vocabulary",
    "rotated_components": "hashing",
}

if not TYPE_CHECKING:  # or any name would do for the type checker

    def __getattr__(name: str) -> object:
        """Import an estimator when it is first used (PEP 562)."""
        if name not in _ESTIMATORS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{__name__}.{_ESTIMATORS[name]}"), name)
