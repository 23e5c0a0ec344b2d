#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# start.sh ZIP WIDTHxHEIGHT SCRIPT [ARGUMENT...]: install the extension as a new user would, then run
# a script in a window on a display of its own, where events can be simulated.
set -eu
zip=$1 size=$2 script=$3
shift 3

BLENDER_USER_RESOURCES=$(mktemp -d)
export BLENDER_USER_RESOURCES
unset TUG_LIBRARY # the library is the one in the zip
blender --command extension install-file --repo user_default --enable "$zip"
xvfb-run -a -s "-screen 0 ${size}x24 +extension GLX +render -noreset" \
    blender -noaudio --enable-event-simulate --window-geometry 0 0 "${size%x*}" "${size#*x}" \
    --python-exit-code 1 --python "$script" -- "$@" && exit
code=$?
# Where Blender was when it crashed.
for crash in "${TMPDIR:-/tmp}"/*.crash.txt; do
    [ ! -e "$crash" ] || cat "$crash"
done
exit "$code"
