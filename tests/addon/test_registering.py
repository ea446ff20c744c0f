# SPDX-License-Identifier: MIT
"""The add-on can be switched on and off, again and again."""

import bpy


def test_off_and_on_again(addon):
    for _ in range(2):
        addon.unregister()
        assert not hasattr(bpy.types.WindowManager, "shape_google")
        addon.register()
        assert hasattr(bpy.types.WindowManager, "shape_google")
