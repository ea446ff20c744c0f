# SPDX-License-Identifier: MIT
"""Suggested tags, catalogs, folders and name words for a shape, from its nearest relatives in a library."""

from shapegoogle_core.library.suggestions.suggest import Suggestion, SuggestionKind, suggestions_from
from shapegoogle_core.library.suggestions.words import name_words

__all__ = ["Suggestion", "SuggestionKind", "name_words", "suggestions_from"]
