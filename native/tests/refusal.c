/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "refusal.h"

#include <stdio.h>
#include <string.h>

char rubbish;

int refused(tug_status status, tug_status expected, const char *call)
{
    const char *text = tug_error_text();
    size_t length = strlen(call);
    if (status == expected && strncmp(text, call, length) == 0 && text[length] == ':' &&
        strlen(text) > length + 3 && strchr(text, '\n') == NULL) {
        return 1;
    }
    printf("%s: status %d, \"%s\"\n", call, (int)status, text);
    return 0;
}

void spoil_error_text(void)
{
    if (strncmp(tug_error_text(), "tug_find", 8) != 0) {
        tug_find_components(NULL, NULL, NULL);
    } else {
        tug_check_mesh(NULL, NULL, 0, NULL, NULL);
    }
}
