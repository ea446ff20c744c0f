# SPDX-License-Identifier: MIT
"""Settings of a search: one frozen value that programs can read without numpy."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace

import pytest

from shapegoogle_core.library.search.settings import SearchSettings, VerificationSettings


def test_settings_and_their_stages_are_frozen() -> None:
    settings = SearchSettings()
    for stage in fields(settings):
        value = getattr(settings, stage.name)
        assert is_dataclass(value)
        for field in fields(value):
            with pytest.raises(FrozenInstanceError):
                setattr(value, field.name, 0)


def test_settings_are_compared_by_value() -> None:
    other = replace(SearchSettings(), verification=VerificationSettings(certain=0.5))
    assert SearchSettings() == SearchSettings() != other
    assert len({SearchSettings(), SearchSettings(), other}) == 2


@pytest.mark.parametrize("module", ["search.settings", "filter", "evidence", "duplicates.settings"])
def test_values_for_the_command_line_need_no_numpy(module: str) -> None:
    code = f"import sys, shapegoogle_core.library.{module}; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
