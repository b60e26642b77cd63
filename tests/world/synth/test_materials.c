// The materials: within their limits, unlike each other, and wide enough apart as a set.
#include <math.h>
#include "support.h"
#include "world/synth/material.h"
#include "world/synth/synth.h"

static void materials_vary_within_their_limits(void **state) {
    (void)state;
    assert_int_equal(ffp_material_count(), 43);
    double darkest = 1, brightest = 0;
    for (int m = 0; m < ffp_material_count(); m++)
        for (uint64_t seed = 0; seed < 6; seed++) {
            const FfpMaterial material = ffp_material_make(m, seed);
            double mean = 0;
            for (int i = 0; i < 500; i++) {
                const float p[3] = {0.9F * sinf((float)i), 0.9F * sinf(1.7F * (float)i),
                                    0.9F * cosf(2.3F * (float)i)};
                float albedo[3], roughness, normal[3] = {0.6F, 0, 0.8F};
                ffp_material_look(&material, p, albedo, &roughness);
                ffp_material_bump(&material, p, normal);
                for (int c = 0; c < 3; c++) {
                    assert_true(albedo[c] >= 0.02F && albedo[c] <= 0.95F);
                    mean += albedo[c] / 1500;
                }
                assert_true(roughness >= 0.15F && roughness <= 0.95F);
                assert_float_equal(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2], 1,
                                   1e-4);
                assert_true(0.6F * normal[0] + 0.8F * normal[2] > 0.5F);
            }
            darkest = fmin(darkest, mean), brightest = fmax(brightest, mean);
        }
    assert_true(darkest < 0.15 && brightest > 0.6);
}

typedef struct Figures {
    double colour[3], contrast, rough, least_rough, most_rough, bent;
} Figures;

static void measure(const FfpMaterial *material, Figures *out) {
    enum { POINTS = 400 };
    double sum = 0, square = 0;
    *out = (Figures){.least_rough = 1};
    for (int i = 0; i < POINTS; i++) {
        const float p[3] = {0.7F * sinf((float)i), 0.7F * sinf(1.7F * (float)i),
                            0.7F * cosf(2.3F * (float)i)};
        float albedo[3], roughness, normal[3] = {0.6F, 0, 0.8F};
        ffp_material_look(material, p, albedo, &roughness);
        ffp_material_bump(material, p, normal);
        const double mean = ((double)albedo[0] + (double)albedo[1] + (double)albedo[2]) / 3;
        sum += mean, square += mean * mean;
        for (int c = 0; c < 3; c++) out->colour[c] += (double)albedo[c] / POINTS;
        out->rough += (double)roughness / POINTS;
        out->least_rough = fmin(out->least_rough, (double)roughness);
        out->most_rough = fmax(out->most_rough, (double)roughness);
        out->bent += hypot((double)normal[1], 0.8 * (double)normal[0] - 0.6 * (double)normal[2]) / POINTS;
    }
    out->contrast = sqrt(fmax(0, square / POINTS - sum * sum / POINTS / POINTS)) / (sum / POINTS);
}

static void the_set_spans_what_objects_are_made_of(void **state) {
    (void)state;
    double darkest = 1, brightest = 0, greyest = 1, purest = 0, plainest = 9, busiest = 0, glossy = 1,
           matt = 0;
    int bumpy = 0;
    for (int m = 0; m < ffp_material_count(); m++)
        for (uint64_t seed = 0; seed < 4; seed++) {
            const FfpMaterial material = ffp_material_make(m, seed);
            Figures f;
            measure(&material, &f);
            const double high = fmax(f.colour[0], fmax(f.colour[1], f.colour[2]));
            const double low = fmin(f.colour[0], fmin(f.colour[1], f.colour[2])), mean = 0.5 * (high + low);
            darkest = fmin(darkest, mean), brightest = fmax(brightest, mean);
            greyest = fmin(greyest, 1 - low / high), purest = fmax(purest, 1 - low / high);
            plainest = fmin(plainest, f.contrast), busiest = fmax(busiest, f.contrast);
            glossy = fmin(glossy, f.least_rough), matt = fmax(matt, f.most_rough);
            bumpy += f.bent > 0.02;
        }
    print_message(
        "albedo %.3f..%.3f, saturation %.2f..%.2f, contrast %.2f..%.2f, roughness %.2f..%.2f, %d bumpy\n",
        darkest, brightest, greyest, purest, plainest, busiest, glossy, matt, bumpy);
    assert_true(darkest < 0.05 && brightest > 0.75);
    assert_true(greyest < 0.05 && purest > 0.8);
    assert_true(plainest < 0.1 && busiest > 0.6);
    assert_true(glossy < 0.17 && matt > 0.93);
    assert_in_range(bumpy, 30, 120); // of 172
}

// Every name once, and a material depends on its number and its seed alone.
static void materials_are_themselves(void **state) {
    (void)state;
    for (int m = 0; m < ffp_material_count(); m++) {
        for (int other = 0; other < m; other++)
            assert_string_not_equal(ffp_material_name(m), ffp_material_name(other));
        const FfpMaterial a = ffp_material_make(m, 3), b = ffp_material_make(m, 3),
                          c = ffp_material_make(m, 4);
        Figures x, y, z;
        measure(&a, &x);
        measure(&b, &y);
        measure(&c, &z);
        assert_memory_equal(&x, &y, sizeof x);
        assert_memory_not_equal(&x, &z, sizeof x);
    }
    assert_string_equal(ffp_material_name(-1), "unknown");
    assert_string_equal(ffp_material_name(ffp_material_count()), "unknown");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_vary_within_their_limits),
        cmocka_unit_test(the_set_spans_what_objects_are_made_of),
        cmocka_unit_test(materials_are_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
