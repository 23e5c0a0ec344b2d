/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Deformation gradients as turns and stretches: they come back, and their derivatives match
 * differences. */
#include "baselines/features.h"

#include "dense/rotation.h"
#include "fixture.h"
#include "test.h"

static void logarithms_undo_turns(void)
{
    uint64_t random = 39;
    for (int trial = 0; trial < 300; trial++) {
        int32_t k = 2 + trial % 2;
        double w[3], R[9], back[3], length = 0.0, pi = 3.14159265358979323846;
        double angle = trial % 3 == 0 ? pi - pow(10.0, random_between(&random, -7.0, 0.0))
                                      : pow(10.0, random_between(&random, -9.0, 0.4));
        for (int32_t a = 0; a < tangent_size(k); a++) {
            w[a] = random_between(&random, -1.0, 1.0);
            length += w[a] * w[a];
        }
        for (int32_t a = 0; a < tangent_size(k); a++) {
            w[a] *= angle / sqrt(length);
        }
        identity_matrix(k, R);
        turn(k, w, R);
        rotation_logarithm(k, R, back);
        for (int32_t a = 0; a < tangent_size(k); a++) {
            CHECK_NEAR(back[a], w[a], 1e-9 + 1e-6 * (angle > 3.0));
        }
    }
}

static void feature_derivatives_match_differences(void)
{
    uint64_t random = 40;
    for (int trial = 0; trial < 40; trial++) {
        int32_t k = 2 + trial % 2, S = 4;
        double F[9], w[4], M[9], dM[4 * 9], ahead[9], behind[9], scale = trial < 4 ? 1e-4 : 1.0;
        feature_set features;
        CHECK(features_create(k, 1, S, &features));
        for (int32_t s = 0; s < S; s++) {
            identity_matrix(k, F);
            for (int32_t i = 0; i < k * k; i++) {
                F[i] += scale * random_between(&random, -1.0, 1.0);
            }
            set_feature(&features, 0, s, F);
            double alone[4] = {s == 0, s == 1, s == 2, s == 3};
            blend_features(&features, 0, alone, M);
            for (int32_t i = 0; i < k * k; i++) {
                CHECK_NEAR(M[i], F[i], 1e-9); /* R S = F */
            }
        }
        random_blend(&random, 1, S, w);
        differentiate_features(&features, 0, w, dM);
        for (int32_t s = 0; s < S; s++) {
            double kept = w[s];
            w[s] = kept + 1e-5;
            blend_features(&features, 0, w, ahead);
            w[s] = kept - 1e-5;
            blend_features(&features, 0, w, behind);
            w[s] = kept;
            for (int32_t i = 0; i < k * k; i++) {
                CHECK_NEAR(dM[s * k * k + i], (ahead[i] - behind[i]) / 2e-5, 1e-7);
            }
        }
        features_destroy(&features);
    }
}

int main(int argc, char **argv)
{
    RUN(logarithms_undo_turns);
    RUN(feature_derivatives_match_differences);
    return TEST_RESULT;
}
