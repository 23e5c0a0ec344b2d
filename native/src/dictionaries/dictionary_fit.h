/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Positions in terms of a dictionary, (F 24). */
#ifndef TUG_DICTIONARY_FIT_H
#define TUG_DICTIONARY_FIT_H

#include "status.h"

/* The contract of tug_fit_dictionary; the dictionary and the atoms have been checked. */
tug_status fit_dictionary(const tug_dictionary *given, const int32_t *atoms, int32_t atom_count,
                          const double *positions, const progress_range *range, double *transforms,
                          double *fitted);

#endif
