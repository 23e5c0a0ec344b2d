/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a refused call owes its caller. */
#ifndef TUG_REFUSAL_H
#define TUG_REFUSAL_H

#include "tug.h"

/* Whether a call was refused with this status in words that start with its name. The error text is
 * the last failure's, so another call has to fail in between: see REFUSED. */
int refused(tug_status status, tug_status expected, const char *call);
void spoil_error_text(void);

#define REFUSED_WITH(expected, call, ...)                                                          \
    (spoil_error_text(), refused(call(__VA_ARGS__), expected, #call))
#define REFUSED(call, ...) REFUSED_WITH(TUG_ERROR_ARGUMENT, call, __VA_ARGS__)

/* Any address that is not NULL: what a failed call has to replace. */
extern char rubbish;
#define RUBBISH ((void *)&rubbish)

#endif
