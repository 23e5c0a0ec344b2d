#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# install_dependencies.sh [tests]: install the Debian packages that building Tug and showing the
# demo need, or those of the tests. Does nothing, and needs no network, where all are there.
set -eu

# Compiler and libraries; Python; what the bpy wheels load (libraries of X and OpenGL, also
# without a window).
packages="gcc libc6-dev cmake ninja-build libopenblas-pthread-dev libsuitesparse-dev xz-utils
    python3 python3.11 python3.11-venv ca-certificates
    libegl1 libgl1 libgl1-mesa-dri libgomp1 libice6 libopengl0 libsm6 libx11-6 libxext6 libxfixes3
    libxi6 libxkbcommon0 libxrender1 libxt6 libxxf86vm1"
[ "${1:-}" = tests ] && packages="bubblewrap clang-format-14 mmdebstrap uidmap"

# Elsewhere than on Debian, CMake and Python tell what they miss.
command -v dpkg-query >/dev/null || exit 0

missing=
for package in $packages; do
    case $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true) in
    installed) ;;
    *) missing="$missing $package" ;;
    esac
done
[ -z "$missing" ] && exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null; then
    as_root=sudo
else
    echo "Tug needs packages that are not installed. As root: apt-get install$missing" >&2
    exit 1
fi
echo "Tug: installing$missing"
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get -qq update
# shellcheck disable=SC2086 # a list
$as_root apt-get -qq install -y --no-install-recommends $missing >/dev/null
