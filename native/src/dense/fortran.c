/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The one function of the Fortran runtime that LAPACK calls. The runtime itself cannot be linked
 * into a shared library, and is not there on an artist's machine. */
#include <string.h>

void _gfortran_concat_string(size_t size, char *destination, size_t first_size, const char *first,
                             size_t second_size, const char *second);

/* first || second, cut or padded with blanks to `size` characters. */
void _gfortran_concat_string(size_t size, char *destination, size_t first_size, const char *first,
                             size_t second_size, const char *second)
{
    size_t head = first_size < size ? first_size : size;
    size_t tail = second_size < size - head ? second_size : size - head;
    memcpy(destination, first, head);
    memcpy(destination + head, second, tail);
    memset(destination + head + tail, ' ', size - head - tail);
}
