# SPDX-License-Identifier: MIT
from shapegoogle_core.words.assignment import hard_words as hard_words
from shapegoogle_core.words.assignment import soft_words as soft_words
from shapegoogle_core.words.bags import bag_of_features as bag_of_features
from shapegoogle_core.words.bags import spatially_sensitive_bag as spatially_sensitive_bag
from shapegoogle_core.words.hashing import SimilaritySensitiveHashing as SimilaritySensitiveHashing
from shapegoogle_core.words.hashing import rotated_components as rotated_components
from shapegoogle_core.words.tfidf import InverseDocumentFrequency as InverseDocumentFrequency
from shapegoogle_core.words.vocabulary import Vocabulary as Vocabulary

__all__: list[str]
