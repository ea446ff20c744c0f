# SPDX-License-Identifier: MIT
"""Functions by name: those of this package, and those that installed packages add as plug-ins.

A package names its plug-ins as entry points. Their names are read from the metadata of what is installed; the
code of a plug-in is imported when it is first asked for by name, so that one that is broken disturbs nobody
who does not use it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

from shapegoogle_core.errors import MeshError, PluginError, ShapeGoogleError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["Plugin", "PluginShapeError", "Registry", "check_takes"]

T = TypeVar("T")


class PluginShapeError(PluginError, MeshError):
    """A plug-in fails with one shape or file; others may work, and this one after an update."""


@dataclass(frozen=True)
class Plugin:
    """What an installed package adds.

    Attributes
    ----------
    kind : str
        Such as "descriptor".
    name : str
        By which it is asked for.
    package, version : str
        Of the package, as pip lists them.
    target : str
        Place of its object, such as "my_package.module:function".
    problem : str
        A sentence that says why it cannot be used; empty if it can.
    """

    kind: str
    name: str
    package: str
    version: str
    target: str
    problem: str = ""

    @property
    def title(self) -> str:
        """Its kind, name and package, for sentences."""
        return f"the {self.kind} {self.name!r} of the package {f'{self.package} {self.version}'.strip()!r}"

    @contextmanager
    def blamed(self, error: type[ShapeGoogleError], subject: str = "") -> Iterator[None]:
        """Turn what goes wrong inside the plug-in into one sentence that names its package.

        Parameters
        ----------
        error : type
            Class of the error to raise. Errors of this package pass as they are.
        subject : str, optional
            Name of the shape that it was called with.
        """
        try:
            yield
        except (ShapeGoogleError, MemoryError):
            raise
        except Exception as fault:
            raise error(
                f"{f'{subject!r}: ' if subject else ''}{self.title} fails; update the package, or report it "
                "to its authors"
            ) from fault

    def unfit(self, wanted: str, error: type[PluginError] = PluginError) -> PluginError:
        """Make the error for an object or a result that is not what is needed.

        Parameters
        ----------
        wanted : str
            Completes the sentence "<plug-in> must …".
        error : type, optional
            Class of the error.

        Returns
        -------
        error : PluginError
        """
        return error(f"{self.title} must {wanted}; update the package, or report it to its authors")


class Registry(Mapping[str, T], Generic[T]):
    """Objects by name, of this package first; plug-ins are found and loaded when they are needed.

    Parameters
    ----------
    kind : str
        What is registered, such as "descriptor".
    group : str
        Group of the entry points of plug-ins.
    own : dict
        Objects of this package by name. A plug-in cannot take one of these names.
    adapt : callable
        Checks the object of a plug-in, see `Plugin.unfit`, and returns what is used in its place.
    prefix : str, optional
        Put before the names of entry points that do not begin with it.

    Attributes
    ----------
    kind, group, own
        As given.

    Examples
    --------
    >>> from shapegoogle_core.keypoints import DETECTORS
    >>> DETECTORS.kind, "hks-maxima" in DETECTORS, "none-such" in DETECTORS
    ('keypoint detector', True, False)
    """

    def __init__(
        self, kind: str, group: str, own: dict[str, T], adapt: Callable[[object, Plugin], T], prefix: str = ""
    ) -> None:
        self.kind, self.group, self.own = kind, group, own
        self._adapt = adapt
        self._prefix = prefix
        self._loaded: dict[str, T] = {}

    def __getitem__(self, name: str) -> T:
        if name in self.own:
            return self.own[name]
        if name not in self._loaded:
            first, *others = self._found[name]
            if others:
                packages = sorted(plugin.package for plugin, _ in (first, *others))
                raise PluginError(
                    f"the {self.kind} {name!r} is in more than one package: {', '.join(packages)}; "
                    "keep one of them"
                )
            self._loaded[name] = self._load(*first)
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self.own or name in self._found

    def __iter__(self) -> Iterator[str]:
        yield from self.own
        yield from (name for name in sorted(self._found) if name not in self.own)

    def __len__(self) -> int:
        return len(self.own.keys() | self._found.keys())

    def plugin(self, name: str) -> Plugin | None:
        """Return the plug-in behind a name.

        Parameters
        ----------
        name : str

        Returns
        -------
        plugin : Plugin or None
            None for a name of this package, and for one that nobody has.
        """
        return None if name in self.own or name not in self._found else self._found[name][0][0]

    def plugins(self) -> list[Plugin]:
        """Find and load all plug-ins, also those that were installed since the first were found.

        Returns
        -------
        plugins : list of Plugin
            Those that cannot be used say why.
        """
        self.__dict__.pop("_found", None)
        self._loaded.clear()
        listed = []
        for name, found in sorted(self._found.items()):
            for plugin, _ in found:
                problem = ""
                if name in self.own:
                    problem = (
                        f"the package {plugin.package!r} has a {self.kind} {name!r}, the name of one of "
                        "Shape Google's own; its authors have to choose another name"
                    )
                else:
                    try:
                        self[name]
                    except PluginError as error:
                        problem = str(error)
                listed.append(replace(plugin, problem=problem))
        return listed

    def _load(self, plugin: Plugin, entry: EntryPoint) -> T:
        try:
            value = entry.load()
        except MemoryError:
            raise
        except (Exception, SystemExit) as fault:
            reason = "its code fails when it is imported"
            if isinstance(fault, ModuleNotFoundError):
                reason = f"there is no module {fault.name!r}"
            elif isinstance(fault, AttributeError):
                reason = f"there is no {plugin.target!r}"
            raise PluginError(
                f"{plugin.title} cannot be loaded, since {reason}; update or remove the package"
            ) from fault
        with plugin.blamed(PluginError):
            return self._adapt(value, plugin)

    @cached_property
    def _found(self) -> dict[str, list[tuple[Plugin, EntryPoint]]]:
        """Entry points of installed packages by name."""
        from importlib.metadata import entry_points

        found: dict[str, list[tuple[Plugin, EntryPoint]]] = {}
        for entry in entry_points(group=self.group):
            name = entry.name if entry.name.startswith(self._prefix) else f"{self._prefix}{entry.name}"
            package = entry.value.partition(":")[0] if entry.dist is None else entry.dist.name
            version = "" if entry.dist is None else entry.dist.version
            plugin = Plugin(self.kind, name, package, version, entry.value)
            found.setdefault(name, []).append((plugin, entry))
        return found


def check_takes(function: object, plugin: Plugin, names: tuple[str, ...], *, more: bool = False) -> None:
    """Check that the object of a plug-in can be called as it will be.

    Parameters
    ----------
    function : object
    plugin : Plugin
    names : tuple of str
        What its arguments without names are.
    more : bool, optional
        Whether it may have parameters with names after these.

    Raises
    ------
    PluginError
        If it is no function of these.
    """
    wanted = f"be a function of ({', '.join(names)}{', and parameters with names' if more else ''})"
    if not callable(function):
        raise plugin.unfit(wanted)
    try:
        signature = inspect.signature(function)
        signature.bind_partial(*names) if more else signature.bind(*names)
    except (TypeError, ValueError) as error:  # too few or many parameters, or none that Python knows
        raise plugin.unfit(wanted) from error
    kinds = [parameter.kind for parameter in signature.parameters.values()][len(names) :]
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    if more and not set(kinds) <= set(named):
        raise plugin.unfit(wanted)
