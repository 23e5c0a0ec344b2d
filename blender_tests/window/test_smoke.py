# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample creature follows Blender's own G."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scenes import add_creature, shown
from window import Window


def test_the_creature_follows_a_handle(ui: Window) -> Iterator[None]:
    add_creature()
    yield from ui.frame_all()
    ui.undo_base()
    before = shown("Creature")
    yield from ui.grab("Head", -60, 40)
    ui.tap("RET")
    yield
    after = shown("Creature")
    assert np.abs(after - before).max() > 0.1
    yield from ui.undo()
    np.testing.assert_array_equal(shown("Creature"), before)
    yield from ui.redo()
    np.testing.assert_array_equal(shown("Creature"), after)
    yield from ui.grab("Tail", 50, 30)
    assert np.abs(shown("Creature") - after).max() > 0.05
    ui.tap("ESC")
    yield
    np.testing.assert_array_equal(shown("Creature"), after)
    ui.picture("creature")
