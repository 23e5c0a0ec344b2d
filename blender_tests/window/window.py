# SPDX-License-Identifier: GPL-3.0-or-later
"""Mouse and keyboard of a Blender window, by simulated events.

Blender must have been started with --enable-event-simulate. Positions are window pixels from the
bottom left. An event is handled once the test yields.
"""

from __future__ import annotations

import itertools
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import bpy
from console import Console

# Shades of a picture that shows a window; one of a failed grab has one or two.
FEWEST_COLOURS = 50
STEP = 8  # pixels, less than a button is high
RED = "#ff5555"
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf"
TAB = 10  # pixels from the right edge of the sidebar to the middle of its tabs


class Window:
    """The pointer and the held modifiers of Blender's first window.

    Nothing of Blender's is kept from one call to the next: loading a file and undo replace it.
    """

    def __init__(self, pictures: Path, console: Console) -> None:
        self.pictures, self.console = pictures, console
        self.pointer = (self.window.width // 2, self.window.height // 2)
        self.modifiers: dict[str, bool] = {}

    @property
    def window(self) -> bpy.types.Window:
        return bpy.data.window_managers[0].windows[0]

    @property
    def area(self) -> bpy.types.Area:
        return next(area for area in self.window.screen.areas if area.type == "VIEW_3D")

    @property
    def region(self) -> bpy.types.Region:
        return next(region for region in self.area.regions if region.type == "WINDOW")

    @property
    def view(self) -> bpy.types.RegionView3D:
        return self.area.spaces.active.region_3d

    def event(self, kind: str, value: str, character: str | None = None) -> None:
        x, y = self.pointer
        text = {} if character is None else {"unicode": character}
        self.window.event_simulate(type=kind, value=value, x=x, y=y, **self.modifiers, **text)

    def move(self, x: float, y: float) -> None:
        self.pointer = (round(x), round(y))
        self.event("MOUSEMOVE", "NOTHING")

    def press(self, kind: str) -> None:
        self.event(kind, "PRESS")

    def release(self, kind: str) -> None:
        self.event(kind, "RELEASE")

    def tap(self, kind: str, *, ctrl: bool = False, shift: bool = False, alt: bool = False) -> None:
        """Press and release a key or a mouse button, with modifiers held around it."""
        held = [name for name, on in (("ctrl", ctrl), ("shift", shift), ("alt", alt)) if on]
        for name in held:
            self.modifiers[name] = True
            self.press(f"LEFT_{name.upper()}")
        self.press(kind)
        self.release(kind)
        for name in reversed(held):
            del self.modifiers[name]
            self.release(f"LEFT_{name.upper()}")

    def type(self, text: str) -> None:
        """Characters for a text field; one of Blender's types stands for all of them."""
        for character in text:
            self.event("A", "PRESS", character)
            self.release("A")

    def travel(self, dx: float, dy: float, steps: int = 6) -> Iterator[None]:
        """Move by so many pixels in steps: after a single jump Blender may not see a drag."""
        x, y = self.pointer
        for step in range(1, steps + 1):
            self.move(x + dx * step / steps, y + dy * step / steps)
            yield

    def drag(self, dx: float, dy: float, steps: int = 6) -> Iterator[None]:
        """Pull with the left button from where the pointer is, and let go."""
        self.press("LEFTMOUSE")
        yield
        yield from self.travel(dx, dy, steps)
        self.release("LEFTMOUSE")
        yield

    def grab(self, name: str, dx: float, dy: float) -> Iterator[None]:
        """Click on an object, press G and move; the grab goes on until RET or ESC."""
        self.point_at(bpy.data.objects[name])
        yield
        self.tap("LEFTMOUSE")
        yield
        self.tap("G")
        yield
        yield from self.travel(dx, dy)

    def undo(self, steps: int = 1) -> Iterator[None]:
        for _ in range(steps):
            self.tap("Z", ctrl=True)
            yield

    def redo(self, steps: int = 1) -> Iterator[None]:
        for _ in range(steps):
            self.tap("Z", ctrl=True, shift=True)
            yield

    def wait_until(self, condition: Callable[[], bool], seconds: float = 30.0) -> Iterator[float]:
        """Let Blender work until the condition holds."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"not so after {seconds} s")
            yield 0.02  # seconds

    def pixels_of(self, place: Sequence[float]) -> tuple[float, float]:
        """Where a position of the scene is seen; ValueError if it is behind the view."""
        x, y, _, w = (
            row[0] * place[0] + row[1] * place[1] + row[2] * place[2] + row[3]
            for row in self.view.perspective_matrix
        )
        if w <= 0:
            raise ValueError(f"{tuple(place)} is behind the view")
        region = self.region
        return (
            region.x + region.width * (0.5 + 0.5 * x / w),
            region.y + region.height * (0.5 + 0.5 * y / w),
        )

    def point_at(self, obj: bpy.types.Object) -> None:
        self.move(*self.pixels_of(obj.matrix_world.translation))

    def context(self, **members: object) -> object:
        """The context that operators need and a timer lacks: `with ui.context(): bpy.ops...`"""
        return bpy.context.temp_override(
            window=self.window, area=self.area, region=self.region, **members
        )

    def frame_all(self) -> Iterator[None]:
        """Show the whole scene in the viewport."""
        yield  # a file that was loaded has been drawn
        with self.context():
            bpy.ops.view3d.view_all()
        yield

    def undo_base(self) -> None:
        """Push the step that undo may return to: without it undo takes the built scene away."""
        with self.context():
            bpy.ops.ed.undo_push(message="Scene built")

    def point_at_view(self) -> None:
        """At the middle of the viewport."""
        region = self.region
        self.move(region.x + region.width // 2, region.y + region.height // 2)

    def side(self, kind: str) -> bpy.types.Region:
        """A region at the side of the viewport: UI is the sidebar, TOOLS the toolbar."""
        return next(region for region in self.area.regions if region.type == kind)

    def open_tab(self, name: str) -> Iterator[float]:
        """Click on a tab of the sidebar, which must be open."""
        region = self.side("UI")
        for y in range(region.y + region.height - STEP, region.y, -STEP):
            self.move(region.x + region.width - TAB, y)
            yield 0.05
            self.tap("LEFTMOUSE")
            yield 0.05
            if self.side("UI").active_panel_category == name:
                return
        raise AssertionError(f"there is no tab {name}")

    def find_button(self, call: str, kind: str = "UI") -> Iterator[float]:
        """Put the pointer on the button whose operator, as Python, starts with `call`.

        Blender tells of no button where it is, but Ctrl C over one copies what it does.
        """
        region, clipboard = self.side(kind), bpy.context.window_manager
        for y in range(region.y + region.height - STEP, region.y, -STEP):
            clipboard.clipboard = ""
            self.move(region.x + (region.width - TAB) // 2, y)
            yield 0.05
            self.tap("C", ctrl=True)
            yield 0.05
            if clipboard.clipboard.startswith(call):
                self.move(self.pointer[0], y - STEP)
                yield 0.05
                return
        raise AssertionError(f"there is no button for {call}")

    def find_tool(self, name: str) -> Iterator[float]:
        yield from self.find_button(f'bpy.ops.wm.tool_set_by_id(name="{name}"', "TOOLS")

    def picture(
        self, name: str, *, ring: bool = False, only: bpy.types.Region | None = None
    ) -> Path:
        """Save what the display shows, or one region of it, as NAME.png, with a ring around the
        pointer where asked.

        Blender's own screenshot is black under recent Mesa, without an error.
        """
        path = self.pictures / f"{name}.png"
        image_magick("import", "-window", "root", path)
        colours = int(image_magick("identify", "-format", "%k", path))
        assert colours >= FEWEST_COLOURS, f"{path} has {colours} colours"
        finish = ["+dither", "-colors", "255"]  # a tenth of the bytes
        if ring:
            x, y = self.pointer[0], self.window.height - 1 - self.pointer[1]
            finish += ["-fill", "none", "-stroke", RED, "-strokewidth", "4"]
            finish += ["-draw", f"circle {x},{y} {x + 20},{y}"]
        if only is not None:
            top = self.window.height - only.y - only.height
            finish += ["-crop", f"{only.width}x{only.height}+{only.x}+{top}", "+repage"]
        image_magick("mogrify", *finish, path)
        return path

    def strip(self, name: str, pictures: Sequence[Path], columns: int) -> Path:
        """Some pictures, numbered, in rows of one."""
        label = ["-gravity", "northwest", "-pointsize", "60", "-font", FONT]
        label += ["-fill", "white", "-undercolor", RED, "-annotate", "+0+0"]
        tiles = [
            ["(", picture, *label, f" {number} ", "-resize", "62.5%", ")"]
            for number, picture in enumerate(pictures, start=1)
        ]
        rows = []
        for first in range(0, len(tiles), columns):
            rows += ["(", *itertools.chain(*tiles[first : first + columns]), "+append", ")"]
        path = self.pictures / f"{name}.png"
        image_magick("convert", *rows, "-append", "+dither", "-colors", "255", path)
        return path


def image_magick(*words: object) -> bytes:
    """What one of its programs prints."""
    return subprocess.run(
        list(map(str, words)), check=True, stdout=subprocess.PIPE, timeout=120
    ).stdout
