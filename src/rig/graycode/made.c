// Black and white that nobody photographed, from the codes.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/image/photograph.h"
#include "core/numerics/rank.h"
#include "rig/graycode/decoder.h"

#define POWER 12
#define LEAST 0.003F // linear light: a difference that counts

static const char made_black[] = "black, made from the codes", made_white[] = "white, made from the codes";

// Sums over pairs of photographs. A pair counts by a high power of its difference: of stripes that are not
// resolved both show the same, and beside narrow ones a dark pixel has light of those that are lit.
typedef struct Sums {
    const FfpGrayPhotographs *from;
    bool rough;                      // ffp_photograph_read_reduced
    FfpImage dark, light;            // [h,w,3] weighted darker and lighter ones
    float *weights, *both, *squares; // [h,w] of weights; what whole pairs add up to in grey, and its squares
    int width, height, pairs, whole; // of the pairs, those of a code and its inverse
} Sums;

static float grey_of(const FfpImage *rgb, size_t pixel) {
    const real *p = rgb->data + 3 * pixel;
    return (float)(p[0] + p[1] + p[2]) / 3;
}

static void add_pair(Sums *s, const FfpImage pair[2], bool whole) {
    for (size_t i = 0; i < (size_t)s->width * (size_t)s->height; i++) {
        const float a = grey_of(&pair[0], i), b = grey_of(&pair[1], i);
        const float weight = powf(fabsf(a - b) + LEAST, POWER);
        s->weights[i] += weight;
        for (size_t c = 3 * i; c < 3 * i + 3; c++) {
            s->dark.data[c] += (real)weight * pair[a > b].data[c];
            s->light.data[c] += (real)weight * pair[a <= b].data[c];
        }
        if (whole) s->both[i] += a + b, s->squares[i] += (a + b) * (a + b);
    }
    s->pairs++, s->whole += whole;
}

static void take_means(Sums *s) {
    for (size_t c = 0; c < 3 * (size_t)s->width * (size_t)s->height; c++)
        s->dark.data[c] /= (real)s->weights[c / 3], s->light.data[c] /= (real)s->weights[c / 3];
}

static bool read_code(Sums *s, FfpImage *rgb, const char *path, FfpError *err) {
    const int shrink = s->from->shrink > 0 ? s->from->shrink : 1;
    int whole[2];
    if (!ffp_photograph_read_reduced(rgb, NULL, whole, path, s->from->linear, shrink, s->rough, NULL, err))
        return false;
    if (!s->weights) {
        const size_t pixels = (size_t)rgb->width * (size_t)rgb->height;
        s->width = rgb->width, s->height = rgb->height;
        s->weights = ffp_alloc(pixels, sizeof(float));
        s->both = ffp_alloc(pixels, sizeof(float)), s->squares = ffp_alloc(pixels, sizeof(float));
        s->dark = ffp_image_new(s->width, s->height, 3), s->light = ffp_image_new(s->width, s->height, 3);
    }
    ffp_cancel_point();
    return (rgb->width == s->width && rgb->height == s->height) ||
           ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, but the others are %d x %d", rgb->width,
                    rgb->height, s->width, s->height);
}

// Any two photographs are a pair where they differ; of a code and its inverse what they add up to tells the
// noise, too.
static bool read_sums(Sums *s, FfpError *err) {
    const FfpGrayPhotographs *from = s->from;
    FfpImage single = {0};
    bool ok = true;
    for (int i = 0; ok && i < ffp_gray_photographs(from->width, from->height); i += 2) {
        FfpImage pair[2] = {0};
        for (int k = 0; ok && k < 2; k++)
            if (from->codes[i + k]) ok = read_code(s, &pair[k], from->codes[i + k], err);
        const bool whole = pair[0].data && pair[1].data;
        if (ok && !whole && (pair[0].data || pair[1].data)) {
            const FfpImage own = pair[0].data ? pair[0] : pair[1], none = {0};
            pair[0] = single, pair[1] = single.data ? own : none;
            single = single.data ? none : own;
        }
        if (ok && pair[0].data && pair[1].data) add_pair(s, pair, whole);
        ffp_image_free(&pair[0]), ffp_image_free(&pair[1]);
    }
    ffp_image_free(&single);
    if (ok && s->pairs > 0) take_means(s);
    return ok && (s->pairs > 0 || ffp_fail(err, FFP_ERROR_FILE, NULL, "no photographs of Gray codes"));
}

static void free_sums(Sums *s) {
    ffp_free(s->weights), ffp_free(s->both), ffp_free(s->squares);
    ffp_image_free(&s->dark), ffp_image_free(&s->light);
}

bool ffp_gray_make_pictures(FfpImage plain[2], const FfpGrayPhotographs *from, FfpError *err) {
    Sums s = {.from = from};
    const bool ok = read_sums(&s, err);
    if (ok) {
        plain[0] = s.dark, plain[1] = s.light;
        s.dark = s.light = (FfpImage){0};
    }
    free_sums(&s);
    return ok;
}

// Deviation of what white adds to black, if both had been photographed.
static double noise_of(const Sums *s) {
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    real *variance = ffp_alloc(pixels, sizeof *variance);
    for (size_t i = 0; i < pixels; i++) {
        const double mean = (double)s->both[i] / s->whole;
        variance[i] = (real)fmax((double)s->squares[i] / s->whole - mean * mean, 0);
    }
    const double noise = sqrt((double)ffp_median(variance, pixels));
    ffp_free(variance);
    return noise;
}

// Onto the cache, white with its luma.
static const char *put_made(FfpGrayCache *cache, FfpImage *made, const char *name) {
    const int at = cache->n++;
    const size_t pixels = (size_t)made->width * (size_t)made->height;
    float *grey = ffp_alloc(pixels, sizeof *grey);
    for (size_t i = 0; i < pixels; i++) grey[i] = grey_of(made, i);
    cache->files[at].path = name, cache->files[at].width = made->width,
    cache->files[at].height = made->height;
    cache->files[at].grey = grey;
    if (name == made_white) cache->files[at].luma = ffp_photograph_luma(made);
    return name;
}

bool ffp_gray_make_plain(FfpGrayPhotographs *photographs, FfpError *err) {
    Sums s = {.from = photographs, .rough = true};
    if (photographs->black && photographs->white) return true;
    const bool ok = read_sums(&s, err);
    if (ok && s.whole > 1) photographs->noise = noise_of(&s);
    if (ok && !photographs->black) photographs->black = put_made(photographs->cache, &s.dark, made_black);
    if (ok && !photographs->white) photographs->white = put_made(photographs->cache, &s.light, made_white);
    free_sums(&s);
    return ok;
}
