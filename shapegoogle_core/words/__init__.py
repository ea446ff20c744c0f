# SPDX-License-Identifier: MIT
"""Geometric words: vocabulary, assignment, bags, tf-idf weighting, binary codes."""

from shapegoogle_core.words.assignment import hard_words, soft_words
from shapegoogle_core.words.bags import bag_of_features, spatially_sensitive_bag
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
