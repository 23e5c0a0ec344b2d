# SPDX-License-Identifier: GPL-3.0-or-later
# CHOLMOD, BLAS and LAPACK. The library takes them in whole where they are there as static position
# independent libraries, so that it runs in any Blender.
set(cache $ENV{XDG_CACHE_HOME})
if(NOT cache)
    set(cache $ENV{HOME}/.cache)
endif()
set(TUG_SUITESPARSE ${cache}/tug/suitesparse-5.12.0 CACHE PATH
    "Where native/provide_suitesparse.sh has put include/ and lib/")

find_library(TUG_STATIC_CHOLMOD libsuitesparse.a PATHS ${TUG_SUITESPARSE}/lib NO_DEFAULT_PATH)
find_library(TUG_STATIC_OPENBLAS libopenblas.a PATH_SUFFIXES openblas-pthread)
if(TUG_STATIC_CHOLMOD AND TUG_STATIC_OPENBLAS)
    set(TUG_CHOLMOD_INCLUDE ${TUG_SUITESPARSE}/include)
    set(TUG_CHOLMOD ${TUG_STATIC_CHOLMOD})
    set(TUG_OPENBLAS ${TUG_STATIC_OPENBLAS})
else()
    message(WARNING "libtug will load this system's CHOLMOD and OpenBLAS, and so run in few "
                    "Blenders: see native/provide_suitesparse.sh")
    find_path(TUG_CHOLMOD_INCLUDE cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
    set(TUG_CHOLMOD cholmod)
    set(TUG_OPENBLAS openblas)
endif()

set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)
