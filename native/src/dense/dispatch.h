/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Inner loops are compiled for wider vectors too and chosen when the library is loaded. */
#ifndef TUG_DISPATCH_H
#define TUG_DISPATCH_H

/* The sanitizers do not survive functions that are chosen before they have started. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) &&                             \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DISPATCHED __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define DISPATCHED
#endif

#endif
