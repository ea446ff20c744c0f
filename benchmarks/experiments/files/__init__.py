# SPDX-License-Identifier: MIT
"""Reading model files with the product and with other readers: `python -m benchmarks files`.

`command` runs the readers of `readers` over folders; `facts` measures what each of them read; `verdicts`
compares the measurements and `report` writes them down. `in_blender` runs inside Blender.
"""
