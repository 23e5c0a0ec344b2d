/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Items of work on several threads, while the calling thread reports progress. */
#ifndef TUG_WORKERS_H
#define TUG_WORKERS_H

#include "status.h"

#include <stdatomic.h>

/* Work on one item; worker: which thread it is, from 0. A long one looks at `stop` now and then and
 * returns TUG_ERROR_CANCELLED where it is set. */
typedef tug_status (*work_function)(void *context, int32_t worker, int32_t item,
                                    const atomic_int *stop);

/* Items 0 to count - 1, each by the next free one of `threads` threads. The callback is only called
 * from this thread, every twentieth of a second. After a failure or a cancel no further item
 * begins; the first failure is the result. */
tug_status run_workers(int32_t threads, int32_t count, work_function work, void *context,
                       const progress_range *range, const char *stage);

int32_t processor_count(void);

#endif
