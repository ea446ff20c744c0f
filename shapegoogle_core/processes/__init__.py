# SPDX-License-Identifier: MIT
"""The one way to run work in other processes.

`launching` starts and ends processes in an orderly way; `pool` runs many tasks with limits of time and
memory; `worker` keeps one process that runs task after task, for a program with a window; `program` asks or
watches another program; `messages` is what they say to each other; `temporary` has folders that do not
outlast them; `progress` shows the progress of a loop.
"""
