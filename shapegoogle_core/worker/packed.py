# SPDX-License-Identifier: MIT
"""Values that wait in a program with a window until a worker process needs them again."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Generic, TypeVar

__all__ = ["Packed"]

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Packed(Generic[T]):
    """What a worker process has described, pickled: it waits in the program with the window for all others.

    Only a worker process unpacks it: with thousands of them that would keep the window from answering. Both
    are our own processes; nothing from a file is unpickled.

    Attributes
    ----------
    content : bytes
    model : str
        Identifier of the model that described it.
    object_names : tuple of str
        Of the objects that show it, where somebody asks for them.

    Examples
    --------
    >>> from shapegoogle_core.worker.packed import Packed
    >>> Packed.of({"faces": 12}, "default").unpacked()
    {'faces': 12}
    """

    content: bytes
    model: str
    object_names: tuple[str, ...] = ()

    @classmethod
    def of(cls, value: T, model: str, object_names: tuple[str, ...] = ()) -> Packed[T]:
        """Pack a value.

        Parameters
        ----------
        value : object
            Picklable.
        model : str
        object_names : tuple of str, optional

        Returns
        -------
        packed : Packed
        """
        return cls(pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL), model, object_names)

    def unpacked(self) -> T:
        """Return the value."""
        value: T = pickle.loads(self.content)
        return value
