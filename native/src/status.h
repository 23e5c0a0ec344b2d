/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Status codes with their text, and progress of long calls. */
#ifndef TUG_STATUS_H
#define TUG_STATUS_H

#include "tug.h"

/* Keep the text for tug_error_text() and return `status`. */
tug_status fail(tug_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* fail() for an allocation of which nothing more can be said. */
tug_status fail_memory(void);

/* The part [start, start + span] of a caller's progress bar that belongs to one stage. */
typedef struct progress_range {
    tug_progress callback; /* may be NULL */
    void *user;
    double start, span;
} progress_range;

/* Tell the caller that `fraction` of this stage is done. TUG_ERROR_CANCELLED where it asks to stop.
 */
tug_status report(const progress_range *range, const char *stage, double fraction);

/* The part of `whole` between two fractions of it. */
progress_range progress_part(const progress_range *whole, double from, double to);

#endif
