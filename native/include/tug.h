/* SPDX-License-Identifier: GPL-3.0-or-later */
/* libtug: example-based mesh posing in real time.
 *
 * A mesh, a few example shapes of it and a few handles become a model once (seconds); a solver on
 * that model then answers handle positions with a pose in milliseconds or less. The pose is a
 * function of the handle positions alone: every solve starts cold.
 *
 *     mesh + handles -> weights -> groups -> model -> solver -> positions
 *
 * Conventions, for every call:
 * - Arrays are dense, row-major double; "#V by k" means #V rows of k values. Indices are int32_t,
 *   from 0. #V vertices, #F triangles, k dimensions (2 or 3), #S shapes, #W weight functions,
 *   #H constraint rows (handles), #G edge groups. Lengths are in the caller's unit; any unit works.
 * - Inputs are copied, outputs are the caller's. No pointer may be NULL unless it says so.
 * - A fallible call returns a tug_status; on anything but TUG_OK it has changed none of its outputs
 *   but created handles (`*out`), which are NULL then, and tug_error_text() says in words what was
 *   wrong. Whether a solve converged is not a status: it stands in the info.
 * - The library never prints, never exits and never asserts on a caller's data.
 * - Different objects may be used by different threads at once, and a mesh or a model by several;
 *   one solver by one thread at a time.
 * - Options and info structs start with their size: fill options by their defaults function, and
 * set `struct_size` of an info to sizeof before the call. An info may be NULL.
 *
 * Equations: (A n) Wampler 2016, "Fast and Reliable Example-Based Mesh IK for Stylized
 * Deformations". (F n) Shtern, Sela and Kimmel 2017, "Fast Blended Transformations for Partial
 * Shape Registration".
 */
#ifndef TUG_H
#define TUG_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define TUG_API __declspec(dllexport)
#else
#define TUG_API __attribute__((visibility("default")))
#endif

/* Changes whenever a struct or a signature below changes. */
#define TUG_ABI 2

typedef enum tug_status {
    TUG_OK = 0,
    TUG_ERROR_ARGUMENT = 1,  /* a count, index, pointer or option that cannot be */
    TUG_ERROR_MEMORY = 2,    /* an allocation failed */
    TUG_ERROR_CANCELLED = 3, /* the progress callback asked to stop */
    TUG_ERROR_MESH = 4,      /* the mesh cannot be used: see tug_check_mesh */
    TUG_ERROR_HANDLES = 5,   /* handles that coincide, or a component that has none */
    TUG_ERROR_NUMERIC = 6,   /* a factorisation failed or a result is not finite */
    TUG_ERROR_BLOB = 7       /* not a model blob, of another version, or damaged */
} tug_status;

/* TUG_ABI of the library that is loaded: compare it with the header's. */
TUG_API int32_t tug_abi(void);

/* "major.minor.patch"; static storage. */
TUG_API const char *tug_version(void);

/* What the last call of this thread that failed had to say: of an argument that cannot be, its call
 * and its name; of a mesh or handles, what is wrong with them and what to do. Never NULL; valid
 * until the next failing call of the same thread. */
TUG_API const char *tug_error_text(void);

/* Called from the thread that made the long call, at least every 0.1 s or so. stage: a short
 * English phrase; fraction: 0 to 1 over the whole call, never falling. Return non-zero to cancel:
 * the call then returns TUG_ERROR_CANCELLED. Wherever a call takes one, it may be NULL. */
typedef int (*tug_progress)(void *user, const char *stage, double fraction);

/* ------------------------------------------------------------------------------------------------
 * Mesh
 */

/* The rest shape and its triangles, with areas and cotangents. Immutable. */
typedef struct tug_mesh tug_mesh;

/* vertices: #V by k. triangles: #F by 3. Fails on an index out of range, a dimension other than 2
 * or 3 and empty input only; any geometry is taken: tug_check_mesh tells what is wrong with it, and
 * the calls that cannot work on it fail with the same words. O(#V + #F log #F). */
TUG_API tug_status tug_create_mesh(const double *vertices, int32_t vertex_count, int32_t dimension,
                                   const int32_t *triangles, int32_t triangle_count,
                                   tug_mesh **out);

/* NULL is allowed. */
TUG_API void tug_destroy_mesh(tug_mesh *mesh);

/* What is wrong with a mesh, in words: one line for each kind of problem, with a count, an example
 * and what to do. Errors make the mesh unusable: coordinates that are not finite, triangles of no
 * area, vertices in no triangle. Warnings do not: edges of more than two triangles, neighbours that
 * face opposite ways, vertices at which the surface is pinched, triangles that are there twice.
 * text: capacity bytes, always terminated, cut where it does not fit; errors come first.
 * errors, warnings: numbers of lines. O(#F). */
TUG_API tug_status tug_check_mesh(const tug_mesh *mesh, char *text, size_t capacity,
                                  int32_t *errors, int32_t *warnings);

/* component: #V, numbered from 0 in the order of their first vertex. A vertex in no triangle is a
 * component of its own. O(1) per vertex. */
TUG_API tug_status tug_find_components(const tug_mesh *mesh, int32_t *component, int32_t *count);

/* Vertices spread evenly over the surface: `first`, then again and again the one farthest along the
 * edges from all before it; a component that has none yet comes before any other. count: at most
 * #V. vertices: count. O(count #V log #V). */
TUG_API tug_status tug_spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count,
                                       int32_t *vertices);

/* Distances along the edges from the nearest of some vertices; INFINITY in a component that has
 * none. Never below the distances along the surface. distances: #V. nearest: #V, which of the
 * sources that is, counted from 0, and -1 where there is none; may be NULL. O(#V log #V). */
TUG_API tug_status tug_find_distances(const tug_mesh *mesh, const int32_t *sources, int32_t count,
                                      double *distances, int32_t *nearest);

/* The Voronoi area of each vertex: of the surface that is nearer to it than to the other corners of
 * its triangles; of a triangle with an obtuse angle half goes to that corner, a quarter to each
 * other (Meyer et al. 2003). They sum to the area of the mesh. areas: #V. O(#F). */
TUG_API tug_status tug_find_areas(const tug_mesh *mesh, double *areas);

/* half_cotangents: #F by 3; of the angle at each corner, the weight of the edge opposite of it in
 * (A 7) and in the Laplacian. O(#F). */
TUG_API tug_status tug_get_cotangents(const tug_mesh *mesh, double *half_cotangents);

/* Unit normals of the mesh's triangles at some positions, a pose for one: at each vertex the mean
 * of the triangles' normals, weighted by their angles there, which does not depend on how a flat
 * part is cut into triangles, as weights by area do. Zero where no triangle has an area or they
 * cancel. For dimension 3 only. positions: #V by 3, every coordinate within 1e150. normals: #V by
 * 3. O(#F). */
TUG_API tug_status tug_find_normals(const tug_mesh *mesh, const double *positions, double *normals);

/* ------------------------------------------------------------------------------------------------
 * Weights and groups
 */

typedef struct tug_weights_options {
    size_t struct_size;
    double tolerance;       /* relative duality gap of each handle's problem; default 1e-6 */
    int32_t max_iterations; /* of the quadratic programs; default 200 */
    int32_t threads;        /* handles solved at a time; 0, the default: one a processor */
    /* What becomes of a component that no handle touches. 0, the default: TUG_ERROR_HANDLES. 1: it
     * gets weight one for the handle nearest to it, and so moves with it. */
    int32_t follow_nearest;
} tug_weights_options;

typedef struct tug_weights_info {
    size_t struct_size;
    int32_t converged;  /* every handle's problem reached the tolerance */
    int32_t iterations; /* largest over the handles */
    double gap;         /* largest relative duality gap */
    double
        kkt_residual; /* largest violation of the optimality conditions, relative to the gradient */
    double bound_violation; /* largest distance of a weight from [0, 1] before the final clamp */
} tug_weights_info;

TUG_API void tug_default_weights_options(tug_weights_options *options);

/* Bounded biharmonic weights (Jacobson et al. 2011) on the surface: for each handle the minimiser
 * of the Laplacian energy w^T L M^-1 L w within [0, 1] that is one on the handle's vertices and
 * zero on the others'; values below ten times the tolerance become zero, so that a handle reaches
 * no farther than its weights count; then every row is divided by its sum. handle_starts: #W + 1
 * offsets into handle_vertices, which lists the vertices of handle after handle. weights: #V by #W.
 * Fails with TUG_ERROR_HANDLES where two handles share a vertex or a component has none. One sparse
 * factorisation and a few tens of solves a handle: about a second at 20,000 vertices. */
TUG_API tug_status tug_compute_weights(const tug_mesh *mesh, const int32_t *handle_starts,
                                       const int32_t *handle_vertices, int32_t handle_count,
                                       const tug_weights_options *options, tug_progress progress,
                                       void *user, double *weights, tug_weights_info *info);

typedef struct tug_eigenfunctions_info {
    size_t struct_size;
    int32_t constants; /* functions of eigenvalue 0: one for each component, if there is room */
    int32_t solves;    /* with the factor */
    double residual;   /* largest |L f - mu M f| in the norm of M^-1, in parts of mu */
} tug_eigenfunctions_info;

/* Eigenfunctions of the Laplace-Beltrami operator, the weight functions of (F 3) where there is no
 * skeleton: the `count` smallest solutions of L f = mu M f, with cotangent stiffness L and as mass
 * M the Voronoi areas of the vertices, in parts of the whole area. So neither mu nor f has a unit:
 * divided by the area, mu is that of the surface. Orthonormal: f_i^T M f_j is 1 or 0. The first
 * function is 1 everywhere. Each further component of the mesh has a function of eigenvalue 0 of
 * its own, constant on it and on those larger than it; where count is too small for all, the
 * smallest components have none. Functions of one eigenvalue are some basis of their space. A
 * function is positive at the first vertex where it has half of its largest magnitude; the search
 * always starts alike. count: at most #V. values: count, rising. functions: #V by count. One sparse
 * factorisation and about 10 solves a function: half a second for 15 functions of 25,000
 * vertices. */
TUG_API tug_status tug_compute_eigenfunctions(const tug_mesh *mesh, int32_t count,
                                              tug_progress progress, void *user, double *values,
                                              double *functions, tug_eigenfunctions_info *info);

typedef struct tug_skeleton_options {
    size_t struct_size;
    double smoothness;  /* weight of tr(W^T L W) beside squared distances in parts of the diagonal;
                           default 1e-5 */
    double tolerance;   /* converged where a round lowers the objective by no more, relatively;
                           default 1e-2 */
    int32_t max_rounds; /* of weights and motions; default 100 */
} tug_skeleton_options;

typedef struct tug_skeleton_info {
    size_t struct_size;
    int32_t converged;
    int32_t rounds;
    double error;     /* of the shapes as skinned by the bones: root mean square distance over area
                         and all shapes but the rest shape, in units of length */
    double objective; /* in squared parts of the diagonal; never rises from round to round */
} tug_skeleton_info;

TUG_API void tug_default_skeleton_options(tug_skeleton_options *options);

/* Bones of the examples and their weights, the weight functions of (F 3) for articulated shapes:
 * smooth skinning decomposition with rigid bones (Le and Deng 2012). Minimises, over rigid motions
 * of each bone in each shape and over convex weights of at most four bones a vertex,
 *     sum_vs m_v |q_vs - sum_j w_vj (R_js p_v + t_js)|^2 + smoothness tr(W^T L W)
 * with p the rest shape, m the areas around the vertices and L the cotangent Laplacian. A local
 * minimum: it starts from clusters of vertices that move as one, and always from the same.
 * shapes: #S by #V by k, shape 0 the rest shape. wanted: how many bones; fewer come out where fewer
 * explain the shapes, and one where there is one shape. weights: room for #V by `wanted`, filled as
 * #V by *bone_count; rows sum to one. Edge groups for them: tug_cluster_triangles.
 * O(rounds #V wanted #S): seconds for 20 bones of 25,000 vertices. */
TUG_API tug_status tug_find_skeleton(const tug_mesh *mesh, const double *shapes,
                                     int32_t shape_count, int32_t wanted,
                                     const tug_skeleton_options *options, tug_progress progress,
                                     void *user, double *weights, int32_t *bone_count,
                                     tug_skeleton_info *info);

/* Edge groups of (A 7): triangles clustered by k-means on the weights of their corners, weighted by
 * area. Deterministic: farthest-point seeds, then Lloyd's rounds.
 * weights: #V by #W. wanted: how many groups; fewer come out where the triangles differ too little.
 * groups: #F, every number below *group_count used. O(rounds #F #W wanted). */
TUG_API tug_status tug_cluster_triangles(const tug_mesh *mesh, const double *weights,
                                         int32_t weight_count, int32_t wanted,
                                         tug_progress progress, void *user, int32_t *groups,
                                         int32_t *group_count);

/* ------------------------------------------------------------------------------------------------
 * Dictionaries on their own
 */

/* The dictionary D of (F 4), as a model has it: shapes #S by #V by k, weights #V by #W. Its columns
 * are called atoms: of weight function h come W_h, number h (1 + #S k), and then W_h times
 * coordinate c of shape s, number h (1 + #S k) + 1 + s k + c. */
typedef struct tug_dictionary {
    const double *shapes;
    const double *weights;
    int32_t vertex_count, dimension, shape_count, weight_count;
} tug_dictionary;

/* Dictionary reduction (F, section 4.4): k-medoids of the atoms. An atom is near another where a
 * multiple of that is near it: where what it has besides is small. The weight functions themselves
 * always stay. wanted: #W at least, #W (1 + #S k) at most. atoms: wanted, rising.
 * O(#V b^2 + wanted b^2), b = #W (1 + #S k). */
TUG_API tug_status tug_reduce_dictionary(const tug_dictionary *dictionary, int32_t wanted,
                                         tug_progress progress, void *user, int32_t *atoms);

/* Change of dictionary, (F 24): the pose in the span of some atoms that is nearest to given
 * positions, those of a pose in another dictionary for instance, over the sum of squared distances.
 * atoms: rising numbers, those of every W_h among them, as from tug_reduce_dictionary; NULL, with a
 * count of 0, for all. positions: #V by k. transforms: T_2, #W (1 + #S k) by k in the order of the
 * atoms, zero for those that are not used or depend on others; may be NULL. fitted: D T_2, #V by k;
 * may be NULL, and may be `positions`. O(#V b^2). */
TUG_API tug_status tug_fit_dictionary(const tug_dictionary *dictionary, const int32_t *atoms,
                                      int32_t atom_count, const double *positions,
                                      tug_progress progress, void *user, double *transforms,
                                      double *fitted);

/* ------------------------------------------------------------------------------------------------
 * Model
 */

/* Everything a solve needs of mesh, shapes, weights, constraint rows and groups: the constants of
 * (A 12-19) with the transforms eliminated, so that their size does not depend on #V. Immutable. */
typedef struct tug_model tug_model;

/* Sparse constraint rows, #H by #V: row r has values[starts[r]] to values[starts[r + 1] - 1] at the
 * vertices of the same places. One row with a single 1 pins one vertex. */
typedef struct tug_rows {
    const int32_t *starts;   /* count + 1 */
    const int32_t *vertices; /* starts[count] */
    const double *values;    /* starts[count] */
    int32_t count;
} tug_rows;

typedef struct tug_model_sizes {
    size_t struct_size;
    int32_t vertices, dimension, shapes, weights, rows, groups;
    int32_t unknowns; /* columns of the dictionary, #W (1 + #S k) */
    int32_t rank;     /* of them, those that are independent: the others are left out */
} tug_model_sizes;

/* shapes: #S by #V by k; shape 0 is the rest shape and need not equal the mesh's vertices.
 * weights: #V by #W, any functions whose span holds the constant. groups: #F, as from
 * tug_cluster_triangles. stiffness: #F, above zero, or NULL for one everywhere: a triangle's energy
 * is multiplied by it, so that stiff regions deform less than the others. smoothness: beta_sm of
 * (F 10), 0 or more: that many times half the Laplacian energies of how the shapes' coordinates and
 * the translation vary over the surface, (F 6), come beside E_d and count as part of it; no lengths
 * but those in parts of the rest shape's diagonal. Examples have none. A weight function needs no
 * row of its own: a free handle is a column of the weights that no row pins. Fails with
 * TUG_ERROR_HANDLES where the rows depend on each other. O(#V (#W #S k)^2) time. A model takes
 * about 4 (#G #S k)^2 bytes where weight functions are local, and making it 8 (#W (1 + #S k))^2
 * more; neither grows with #V. */
TUG_API tug_status tug_create_model(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
                                    const double *weights, int32_t weight_count,
                                    const tug_rows *rows, const int32_t *groups,
                                    int32_t group_count, const double *stiffness, double smoothness,
                                    tug_progress progress, void *user, tug_model **out);

/* A model that is the same but for its rows, in place of the model's own: handles added or taken
 * away, or the hundreds of points of a registration. The mesh is not looked at; a model of all
 * shapes is copied and what depends on the rows is found anew. firmness: NULL pins all rows, as
 * tug_create_model does. Else #H of the new rows, 1e-6 to 1e3: beta_lc of (F 10), so that the
 * energy has beta_r |X T - Y|_r^2 / 2 for each row; there may be more rows than unknowns then, and
 * rows may depend on each other. It counts in the costs of the group nearest to the row, and
 * tug_set_firmness puts its springs behind it. Fails with TUG_ERROR_HANDLES where pinned rows
 * depend on each other. O(unknowns^3 + (#G #S k + #H)^2 unknowns): some tens of milliseconds.
 * This and tug_set_firmness are for two things: here there are other rows, found anew for all
 * solvers; there one solver's rows are held more or less, a hundred times faster, since what they
 * are bound to stays. A row that comes and goes is best in the model from the start. */
TUG_API tug_status tug_change_rows(const tug_model *model, const tug_rows *rows,
                                   const double *firmness, tug_model **out);

/* No solver on it may be alive. NULL is allowed. */
TUG_API void tug_destroy_model(tug_model *model);

TUG_API tug_status tug_get_model_sizes(const tug_model *model, tug_model_sizes *sizes);

/* Bytes that tug_save_model writes. */
TUG_API size_t tug_model_blob_size(const tug_model *model);

/* Write the model as one versioned and checksummed blob of exactly tug_model_blob_size bytes, in
 * this machine's byte order. Fails where size is less. */
TUG_API tug_status tug_save_model(const tug_model *model, void *blob, size_t size);

/* Fails with TUG_ERROR_BLOB on anything but a whole, unchanged blob of this version. */
TUG_API tug_status tug_load_model(const void *blob, size_t size, tug_model **out);

/* ------------------------------------------------------------------------------------------------
 * Solver
 */

/* A workspace on a model: settings, and the last pose. Tens of kilobytes to some megabytes; with
 * thousands of pairs of group and shape hundreds are reserved, of which solves touch a tenth. */
typedef struct tug_solver tug_solver;

typedef enum tug_form {
    /* One rotation per group, shapes aligned at bind time, and a prior on the rotations: one true
     * objective, decreased by every step. The default: its pose is continuous in the handles. */
    TUG_FORM_STEADY = 0,
    /* The paper's own: a rotation per group and shape, the alternation of (A 20) and (A 22-23). It
     * need not converge. */
    TUG_FORM_PAPER = 1,
    /* No rotations (section 5.5): one convex problem, solved to its global optimum. */
    TUG_FORM_NO_ROTATIONS = 2,
    /* The paper's form made convergent (appendix A): a rotation per group and shape, each a
     * function of the pose, and a trust region that lowers (A 10) in every round. Ten times slower
     * than the steady form, and its pose may jump as the paper's does. */
    TUG_FORM_TRUST_REGION = 3,
    /* The average energy (F 9) of Shtern et al., by their algorithm 1: how far the pose is from
     * each shape as a whole, averaged. A rotation per group and shape; in all three no blends and
     * no costs. It tends to smooth details out, and not even an example is found exactly; with
     * `scale` it makes the shapes smaller than they should be. */
    TUG_FORM_AVERAGE = 4,
    /* The minimal energy (F 12), by their algorithm 2: each shape alone is carried to the targets,
     * in the whole dictionary, and the one that fits best is taken. An example is found exactly.
     * The pose jumps where another shape becomes the best. After ten rounds a shape goes on by
     * Newton's method, so that the tolerance is reached. */
    TUG_FORM_MINIMAL = 5,
    /* Their schedule: a round of the average, a round of the minimum, and all others with the shape
     * that is best by then; ten in all. The quickest of the three. */
    TUG_FORM_CLOSEST = 6
} tug_form;

typedef struct tug_solver_options {
    size_t struct_size;
    int32_t form;    /* a tug_form */
    int32_t squared; /* 1: without the square roots of (A 10); (F 9) and (F 12) have none */
    /* 1: one blend for the whole mesh instead of one per group, with the costs of (A 4-5). */
    int32_t single_blend;
    /* 1: start from the solver's last pose, as the paper does, instead of cold. The pose then
     * depends on the history of solves. */
    int32_t warm_start;
    /* 1: the shapes may all be larger or smaller by a common factor, (F 7), which is found with the
     * pose: only in the three forms of Shtern et al. */
    int32_t scale;
    int32_t
        max_rounds; /* of blend and rotations; 0, the default: 10 in TUG_FORM_CLOSEST, else 200 */
    double lambda;  /* weight of the costs in (A 10); default 0.5 */
    double prior;   /* weight of the steady form's priors; default 0.1 */
    double
        tolerance; /* a solve has converged when no rotation moves by more; radians; default 1e-6 */
} tug_solver_options;

typedef struct tug_solve_info {
    size_t struct_size;
    int32_t converged;
    int32_t rounds; /* of blend and rotations */
    /* (A 10), with springs, orientations and, in the steady form, priors below the root; in units
     * of length. In the three forms of Shtern et al. `energy`, with springs and priors. */
    double objective;
    double energy;   /* E_d of (A 9), or (F 9) or (F 12) */
    double gap;      /* of the last (A 20): the objective is at most this far above its optimum, up
                        to its rounding */
    double residual; /* how far the last round would have turned a rotation; radians */
    double increase; /* largest rise of the objective in a round: rounding, but in the paper's
                        form */
} tug_solve_info;

TUG_API void tug_default_solver_options(tug_solver_options *options);

/* The model must outlive the solver. All memory is allocated here. */
TUG_API tug_status tug_create_solver(const tug_model *model, const tug_solver_options *options,
                                     tug_solver **out);

/* NULL is allowed. */
TUG_API void tug_destroy_solver(tug_solver *solver);

/* How firmly each constraint row is held to its target, from here on: INFINITY, as at first, pins
 * it, 0 lets it go, and w between is a spring, w times as stiff as the surface is there: the energy
 * E_d then has w s_r |Y'_r - Y_r|^2 / 2 beside it for where the row comes to be, Y'_r, s_r being
 * what it takes to move row r alone by one. The pose is continuous in w, and a free row's target
 * does not count at all. An example is found whatever the firmness of the handles that sit on it.
 * firmness: #H. Fails with TUG_ERROR_HANDLES where a part of the mesh has only rows below about
 * 1e-8. A call that fails changes nothing. Nothing is bound anew: O(rows that are not pinned times
 * the size of the model's constants), which are copied; with every row pinned nothing is. */
TUG_API tug_status tug_set_firmness(tug_solver *solver, const double *firmness);

/* How the surface around each constraint row is turned, from here on: its orientation O, a rotation
 * from the rest shape, and how firmly it is kept. The term o w_g |R_g - O|^2 / 2 comes beside E_d
 * for the rotation R_g, relative to the rest shape, of the edge group whose weights are nearest to
 * the row's, w_g being the group's stiffness: o = 1 is as stiff as the surface. 0, as at first, is
 * none; INFINITY fixes the rotation, and counts as 1e7. Orientations of one group add up. The
 * paper's form turns each shape of the group so; the other forms refuse orientations. Handle
 * positions and orientations of an example give that example, and turning both turns the pose.
 * orientations: #H by k by k, rotations up to 1e-5; not looked at where the firmness is 0.
 * firmness: #H. Allocates nothing; a call that fails changes nothing. */
TUG_API tug_status tug_set_orientations(tug_solver *solver, const double *orientations,
                                        const double *firmness);

/* Find the pose for handle positions. targets: #H by k, one for each constraint row. Allocates
 * nothing; time does not depend on #V. A solve that failed leaves the last pose as it was. */
TUG_API tug_status tug_solve(tug_solver *solver, const double *targets, tug_solve_info *info);

/* The same from given rotations in place of cold: where a form starts from the optima of the shapes
 * alone, and where its priors hold, it has these, #G by #S by k by k as tug_get_rotations gives
 * them. The pose is a function of targets and rotations. Costs are those of a cold solve; the form
 * without rotations keeps what it is given. It serves a change of dictionary (F 24): a solver on a
 * model with few weight functions, where hardly anything can go wrong, starts the one on a model
 * with many, of the same groups and shapes. Refused with `warm_start`. */
TUG_API tug_status tug_solve_from(tug_solver *solver, const double *targets,
                                  const double *rotations, tug_solve_info *info);

/* The rotations of any pose, to start a solve from: for every group and shape the one that best
 * carries the shape's edges to the pose's, (A 22-23), whatever the size of the pose. shapes: #S by
 * #V by k. groups: #F. positions: #V by k. rotations: #G by #S by k by k. O(#F #S); allocates
 * nothing. */
TUG_API tug_status tug_find_rotations(const tug_mesh *mesh, const double *shapes,
                                      int32_t shape_count, const int32_t *groups,
                                      int32_t group_count, const double *positions,
                                      double *rotations);

/* The pose of least E_d for handle positions, a blend and rotations, in place of a solve: to mix
 * the blends and rotations of several solves, over time or between two poses. Rows are held as
 * firmly as set; orientations do not count. targets: #H by k. blend: #G by #S, not negative, rows
 * summing to one. rotations: #G by #S by k by k as tug_get_rotations gives them. There are no costs
 * to get after it, and a warm start after it is cold. Allocates nothing; a call that fails leaves
 * the last pose as it was. */
TUG_API tug_status tug_pose(tug_solver *solver, const double *targets, const double *blend,
                            const double *rotations);

/* What the last solve or pose found; TUG_ERROR_ARGUMENT before the first.
 * positions: #V by k, O(#V #W #S k). blend: #G by #S, rows sum to one. costs: sqrt(D_gs) of (A 10),
 * #G by #S, or D_gs with `squared`; refused in the three forms of Shtern et al., which have none.
 * rotations: #G by #S by k by k. */
TUG_API tug_status tug_get_positions(const tug_solver *solver, double *positions);
TUG_API tug_status tug_get_blend(const tug_solver *solver, double *blend);
TUG_API tug_status tug_get_costs(const tug_solver *solver, double *costs);
TUG_API tug_status tug_get_rotations(const tug_solver *solver, double *rotations);

/* How much larger the shapes are in the last pose than they were given, alpha of (F 7): 1 but with
 * the option `scale`. tug_pose takes them as they are given: for others divide its targets by the
 * scale, and multiply its positions. */
TUG_API tug_status tug_get_scale(const tug_solver *solver, double *scale);

/* ------------------------------------------------------------------------------------------------
 * The convex part alone
 */

typedef struct tug_blend_info {
    size_t struct_size;
    int32_t pivots;   /* changes of the active set */
    double objective; /* at the result */
    double gap;       /* the objective is at most this far above its optimum, up to its rounding */
} tug_blend_info;

/* (A 20) with the transforms eliminated: minimise sqrt(1/2 (B^T Q B + 2 c^T B + r)) + lambda d^T B,
 * or without the root where squared is 1, over group_count simplices of shape_count weights each.
 * Q: n by n, n = group_count shape_count, symmetric, with [Q c; c^T r] positive semidefinite up to
 * rounding. blend, in and out: n; a point of the simplices to start from, then the optimum. */
TUG_API tug_status tug_minimise_blend(int32_t group_count, int32_t shape_count, const double *Q,
                                      const double *c, double r, const double *d, double lambda,
                                      int32_t squared, double *blend, tug_blend_info *info);

/* ------------------------------------------------------------------------------------------------
 * Transforms without a pose
 */

typedef struct tug_elastic_net_info {
    size_t struct_size;
    int32_t converged; /* the gap is below 1e-12 for every column */
    int32_t rounds;    /* largest over the columns; 0 where sparsity is */
    /* Largest over the columns: the objective is at most this far above its optimum, in parts of
     * what it is at T = 0. 0 where sparsity is. */
    double gap;
} tug_elastic_net_info;

/* (F 20-23): minimise 1/2 fit |X T - Y|^2 + 1/2 smoothness tr(T^T Lambda T) + sparsity |T|_1, fit,
 * smoothness and sparsity being beta_lc, beta_sm and beta_sp; each column of T for itself.
 * X: #H by b. Y: #H by k. Lambda: b by b, positive semidefinite, of which the symmetric part
 * counts; (F 6) is diagonal. NULL: zero. T: b by k. fit is above zero, the others are not negative.
 * With sparsity 0 T is the minimiser of least norm, (F 22): directions whose curvature is below
 * 1e-12 of the largest count as open. Otherwise rounds of coordinate descent, each followed by the
 * exact minimiser on the entries that are not zero; where T is not unique (equal columns), it is
 * one of independent columns. TUG_ERROR_NUMERIC where T or a square of X or Y is not finite.
 * O(b^2 #H + b^3), and where sparsity is not zero O(b^2 + s^3) a round, s entries of a column being
 * other than zero. */
TUG_API tug_status tug_solve_elastic_net(int32_t rows, int32_t unknowns, int32_t columns,
                                         const double *X, const double *Y, const double *Lambda,
                                         double fit, double smoothness, double sparsity, double *T,
                                         tug_elastic_net_info *info);

/* ------------------------------------------------------------------------------------------------
 * Nearest points
 */

/* Points in order of place, a k-d tree. Immutable. */
typedef struct tug_points tug_points;

/* points: count by dimension, of 1 to 6; every coordinate within 1e150. Positions with normals,
 * these times a length, are points of dimension 6. O(count log count). */
TUG_API tug_status tug_create_points(const double *points, int32_t count, int32_t dimension,
                                     tug_points **out);

/* NULL is allowed. */
TUG_API void tug_destroy_points(tug_points *points);

/* For each query the nearest point no farther than `limit`, INFINITY for any; of several at one
 * distance the one of the least number. queries: count by dimension. nearest: count, -1 where there
 * is none. distances: count, INFINITY there. O(log) of the number of points, for each query that
 * has a near one. */
TUG_API tug_status tug_find_nearest(const tug_points *points, const double *queries, int32_t count,
                                    double limit, int32_t *nearest, double *distances);

#ifdef __cplusplus
}
#endif

#endif
