#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""run_script.py SCRIPT [ARGUMENT...]: run a Python script in the Blender that the demo uses."""

import os
import sys
from pathlib import Path

from blenders import UnavailableError, demo_blender


def main() -> None:
    try:
        blender = demo_blender()
        print(f"Tug: using {blender.name}", flush=True)
        blender.provide()
    except UnavailableError as reason:
        sys.exit(f"Tug: no Blender can be had ({reason}): set BLENDER to one of 4.2 or newer")
    command = blender.command(Path(sys.argv[1]).resolve(), *sys.argv[2:])
    os.execvp(command[0], command)


if __name__ == "__main__":
    main()
