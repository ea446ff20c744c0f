# SPDX-License-Identifier: GPL-3.0-or-later
"""A line of text while it is typed, without Blender."""

from __future__ import annotations

from dataclasses import dataclass, replace

__all__ = ["TypedText"]


@dataclass(frozen=True)
class TypedText:
    """A text with a caret.

    Attributes
    ----------
    text : str
    caret : int
        Number of letters before the caret.
    """

    text: str = ""
    caret: int = 0

    def with_input(self, letters: str) -> TypedText:
        """Insert letters at the caret; line breaks become spaces."""
        clean = "".join(letter for letter in " ".join(letters.split("\n")) if letter.isprintable())
        text = self.text[: self.caret] + clean + self.text[self.caret :]
        return TypedText(text, self.caret + len(clean))

    def with_key(self, key: str, *, word: bool = False) -> TypedText | None:
        """Move the caret or delete letters.

        Parameters
        ----------
        key : str
            Blender's name of the key.
        word : bool
            By words rather than letters.

        Returns
        -------
        typed : TypedText or None
            None for a key that does neither.
        """
        start = self._start_of_word() if word else max(self.caret - 1, 0)
        end = self._end_of_word() if word else min(self.caret + 1, len(self.text))
        if key == "BACK_SPACE":
            return TypedText(self.text[:start] + self.text[self.caret :], start)
        if key == "DEL":
            return TypedText(self.text[: self.caret] + self.text[end:], self.caret)
        places = {"LEFT_ARROW": start, "RIGHT_ARROW": end, "HOME": 0, "END": len(self.text)}
        return replace(self, caret=places[key]) if key in places else None

    def _start_of_word(self) -> int:
        before = self.text[: self.caret].rstrip()
        return before.rfind(" ") + 1

    def _end_of_word(self) -> int:
        after = self.text[self.caret :]
        spaces = len(after) - len(after.lstrip())
        end = after.find(" ", spaces)
        return len(self.text) if end < 0 else self.caret + end
