# SPDX-License-Identifier: MIT
"""How long a process may take, on a machine that is idle, busy or silent."""

from __future__ import annotations

from shapegoogle_core.processes.signs_of_life import MOST_TIMES, Silence, Standstill


class Machine:
    """A clock and a process that gets a part of each second."""

    def __init__(self, share: float | None) -> None:
        self.seconds, self._share = 1000.0, share

    def clock(self) -> float:
        return self.seconds

    def work(self, _pid: int) -> float | None:
        return None if self._share is None else self._share * self.seconds


def seconds_given(share: float | None, limit: float) -> float:
    """Seconds after which a process that gets a share of the machine has had its time."""
    machine = Machine(share)
    standstill = Standstill(1, limit, machine.clock, machine.work)
    while not standstill.is_over(0):
        machine.seconds += 1
    return machine.seconds - 1000


def test_on_a_busy_machine_a_process_gets_its_time_later() -> None:
    assert seconds_given(1.0, 100) == 101
    assert seconds_given(4.0, 100) == 101  # several threads need no longer than one
    assert 199 <= seconds_given(0.5, 100) <= 201
    assert seconds_given(0.05, 100) == MOST_TIMES * 100 + 1
    assert seconds_given(0.0, 100) == 101
    assert seconds_given(None, 100) == 101  # where nobody knows how much it worked


def test_a_silent_process_has_no_sign_of_life() -> None:
    machine = Machine(0.0)
    silence = Silence(1, 10, machine.clock, machine.work)
    machine.seconds += 9
    assert not silence.is_over(0)
    machine.seconds += 2
    assert not silence.is_over(1)  # it has printed something
    machine.seconds += 11
    assert silence.is_over(1)
