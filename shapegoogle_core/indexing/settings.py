# SPDX-License-Identifier: MIT
"""Settings of an indexing run: how many processes, their limits, and which files are read again."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["IndexSettings"]


@dataclass(frozen=True)
class IndexSettings:
    """Settings of an indexing run. The command line shows the same defaults.

    Parameters
    ----------
    jobs : int, optional
        Number of worker processes; by default one per processor.
    time_limit : float, optional
        Seconds that reading one file may take, and describing one shape of it; of files that another program
        reads, such as Blender, seconds without progress. A file or shape that takes longer is skipped and
        reported.
    memory_limit : int, optional
        Megabytes that reading one file may need, and describing one shape. Enforced on Linux only.
    retry : bool, optional
        Whether files are tried again that failed before and have not changed since. Otherwise they are
        reported as failed without being read.
    reread : bool, optional
        Whether all files are read and described again, changed or not.

    Raises
    ------
    ValueError
        If the number of jobs or a limit is not positive.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> sg.IndexSettings().time_limit
    300.0
    >>> patient = sg.IndexSettings(jobs=2, time_limit=3600)
    """

    jobs: int | None = None
    time_limit: float = 300.0
    memory_limit: int = 4096
    retry: bool = False
    reread: bool = False

    def __post_init__(self) -> None:
        if self.jobs is not None and self.jobs < 1:
            raise ValueError(f"jobs must be at least 1, not {self.jobs}")
        if not self.time_limit > 0:
            raise ValueError(f"time_limit must be above 0 seconds, not {self.time_limit}")
        if self.memory_limit < 1:
            raise ValueError(f"memory_limit must be at least 1 MB, not {self.memory_limit}")
