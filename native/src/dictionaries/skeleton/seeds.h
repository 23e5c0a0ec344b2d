/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The first bones: clusters of vertices that move as one. */
#ifndef TUG_SEEDS_H
#define TUG_SEEDS_H

#include "dictionaries/skeleton/skinning.h"

/* Fill bones, motions and weights of `s` (one bone a vertex, room for `wanted` bones). The first
 * bone carries all; each further one starts from a patch around the vertex that those before it
 * carry worst, as long as that is off by more than rounding; then k-means on the rigid motions. */
tug_status plant_bones(skinning *s, int32_t wanted, const progress_range *range);

#endif
