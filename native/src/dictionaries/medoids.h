/* SPDX-License-Identifier: GPL-3.0-or-later */
/* k-medoids of a dictionary's columns (section 4.4 of the FBT paper). */
#ifndef TUG_MEDOIDS_H
#define TUG_MEDOIDS_H

#include "status.h"

/* The contract of tug_reduce_dictionary; the dictionary and the count have been checked. */
tug_status reduce_dictionary(const tug_dictionary *given, int32_t wanted,
                             const progress_range *range, int32_t *atoms);

#endif
