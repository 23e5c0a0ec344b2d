/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char error_text[1024];

tug_status fail(tug_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error_text, sizeof error_text, format, arguments);
    va_end(arguments);
    return status;
}

tug_status fail_memory(void)
{
    return fail(TUG_ERROR_MEMORY, "not enough memory");
}

const char *tug_error_text(void)
{
    return error_text;
}

tug_status report(const progress_range *range, const char *stage, double fraction)
{
    if (range->callback == NULL) {
        return TUG_OK;
    }
    double whole = range->start + range->span * fraction;
    if (range->callback(range->user, stage, whole) != 0) {
        return fail(TUG_ERROR_CANCELLED, "cancelled while %s", stage);
    }
    return TUG_OK;
}

progress_range progress_part(const progress_range *whole, double from, double to)
{
    progress_range part = *whole;
    part.start += whole->span * from;
    part.span *= to - from;
    return part;
}
