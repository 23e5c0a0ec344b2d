#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Build the part of SuiteSparse that libtug links, position independent, from Debian's source
# package into the cache. Debian's own static CHOLMOD cannot go into a shared library.
set -eu

version=5.12.0
target=${XDG_CACHE_HOME:-$HOME/.cache}/tug/suitesparse-$version
[ -e "$target" ] && exit 0
echo "Tug: building SuiteSparse $version (once)"

mkdir -p "$(dirname "$target")"
work=$(mktemp -d "$target.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work"

# An apt of our own: this system's archives, as sources.
mkdir -p parts lists/partial archives/partial source include lib
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ -f "$list" ] && sed -n 's/^deb /deb-src /p' "$list" >"parts/$(basename "$list" .list).list"
done
for list in /etc/apt/sources.list.d/*.sources; do
    [ -f "$list" ] && sed 's/^Types:.*/Types: deb-src/' "$list" >"parts/$(basename "$list")"
done
own_apt() {
    apt-get -qq -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$work/parts" \
        -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work" \
        -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none "$@"
}
own_apt update || true # of the archives only Debian's matters
own_apt source --download-only suitesparse

top=SuiteSparse-$version
tar -xf suitesparse_"$version"*.orig.tar.xz --strip-components=1 -C source \
    $top/SuiteSparse_config $top/AMD $top/COLAMD $top/CHOLMOD
cp source/SuiteSparse_config/*.h source/*/Include/*.h include/

# t_*.c are included by others; without METIS and CAMD there is no nested dissection.
find source/SuiteSparse_config/*.c source/AMD/Source source/COLAMD/Source \
    source/CHOLMOD/Core source/CHOLMOD/Check source/CHOLMOD/Cholesky source/CHOLMOD/MatrixOps \
    source/CHOLMOD/Supernodal -name '*.c' ! -name 't_*' -print0 |
    xargs -0 -n 8 -P "$(nproc)" \
        cc -c -O3 -fPIC -ffunction-sections -w -DNPARTITION -DNCAMD -DNMODIFY -Iinclude \
        -Isource/CHOLMOD/Supernodal -Isource/CHOLMOD/Core
ar rcs lib/libsuitesparse.a ./*.o

cp source/CHOLMOD/Doc/License.txt LICENSE.txt
rm -rf source parts lists archives suitesparse_* ./*.o ./*.bin
chmod 755 "$work"
mv -T "$work" "$target" 2>/dev/null || [ -e "$target" ]
