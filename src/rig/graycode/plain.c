// Which photographs are black and white.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/image/photograph.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"
#include "rig/graycode/orders.h"

#define NOISE 0.1    // of the brighter one: a smaller difference is noise
#define OUTSIDE 0.05 // linear: a code is nowhere darker than black, or brighter than white, by as much
#define APART 0.1    // of their light: sums of pairs that are the same
#define FEW_LEAST 6  // photographs
#define BRIGHTER 0.9 // share of the light in pixels of which white must be the brighter

// Two photographs one after the other, as light.
typedef struct Plain {
    const char *const *files;
    float *grey[2];   // black and white, if that is what they are
    FfpImage luma[2]; // of files
    bool turned;      // white comes first
    bool lit;         // they differ
    int width, height;
    double share; // of the light by which pixels differ, in those of which white is the brighter
    double added; // light, of all pixels together
} Plain;

static void compare(Plain *p) {
    const size_t pixels = (size_t)p->width * (size_t)p->height;
    size_t lit = 0;
    double light = 0, more = 0; // a pixel counts by its light, so that a dark picture's noise does not
    for (size_t i = 0; i < pixels; i++) {
        const double a = (double)p->grey[0][i], b = (double)p->grey[1][i];
        p->added += b - a;
        if (fabs(b - a) < fmax(FFP_GRAY_LIT, NOISE * fmax(a, b))) continue;
        lit++, light += fabs(b - a), more += fmax(b - a, 0);
    }
    p->lit = lit > pixels / 1000;
    p->share = p->lit ? more / light : 0.5;
    p->turned = p->share < 0.5;
    if (!p->turned) return;
    float *const swap = p->grey[0];
    p->grey[0] = p->grey[1], p->grey[1] = swap;
    p->share = 1 - p->share, p->added = -p->added;
}

// With luma where there is a cache to keep it on.
static bool read_plain(Plain *p, const FfpGrayPhotographs *from, FfpError *err) {
    int width, height;
    FfpImage *luma = from->cache ? p->luma : NULL;
    if (!ffp_gray_read(&p->grey[0], luma, NULL, &p->width, &p->height, p->files[0], from->linear,
                       from->shrink, err) ||
        !ffp_gray_read(&p->grey[1], luma ? luma + 1 : NULL, NULL, &width, &height, p->files[1], from->linear,
                       from->shrink, err))
        return false;
    if (width != p->width || height != p->height)
        return ffp_fail(err, FFP_ERROR_FILE, p->files[1], "image is %d x %d, but '%.200s' is %d x %d", width,
                        height, ffp_basename(p->files[0]), p->width, p->height);
    compare(p);
    return true;
}

// True if another picture is nowhere much darker than black nor brighter than white.
static bool lies_between(const Plain *p, const Plain *other, int k) {
    const size_t pixels = (size_t)p->width * (size_t)p->height;
    size_t lit = 0, outside = 0;
    if (p->width != other->width || p->height != other->height) return true; // is said later
    for (size_t i = 0; i < pixels; i++) {
        const double black = (double)p->grey[0][i], white = (double)p->grey[1][i],
                     here = (double)other->grey[k][i];
        lit += white - black > FFP_GRAY_LIT, outside += here < black - OUTSIDE || here > white + OUTSIDE;
    }
    return (double)outside < (1 - BRIGHTER) * (double)lit;
}

// True if one of the last two photographs or the other is brighter than white, as under another light.
static bool is_outshone(const Plain *front, const Plain *back) {
    const size_t pixels = (size_t)front->width * (size_t)front->height;
    const bool alike = back->grey[0] && back->width == front->width && back->height == front->height;
    size_t lit = 0, brighter = 0;
    for (size_t i = 0; alike && i < pixels; i++) {
        const double black = (double)front->grey[0][i], white = (double)front->grey[1][i];
        if (white - black < FFP_GRAY_LIT) continue;
        lit++, brighter += fmax((double)back->grey[0][i], (double)back->grey[1][i]) > white + OUTSIDE;
    }
    return 2 * brighter > lit;
}

// The pair that is black and white; NULL: neither.
static const Plain *choose(const Plain *front, const Plain *back) {
    // The coarsest code may be as plain where half of the panel is seen: then the contrast tells.
    const bool both = front->share > BRIGHTER && back->share > BRIGHTER;
    const bool at_front = both ? front->added > back->added : front->share > back->share;
    const Plain *chosen = at_front ? front : back, *other = at_front ? back : front;
    const bool plain =
        chosen->share >= BRIGHTER && lies_between(chosen, other, 0) && lies_between(chosen, other, 1);
    return plain ? chosen : NULL;
}

// Onto the cache, with the luma of white.
static void keep_plain(FfpGrayCache *cache, Plain *p, const char *white) {
    for (int k = 0; k < 2; k++) {
        const int file = p->turned ? 1 - k : k, at = cache->n++;
        const char *path = p->files[file];
        cache->files[at].path = path, cache->files[at].grey = p->grey[k];
        cache->files[at].width = p->width, cache->files[at].height = p->height;
        p->grey[k] = NULL;
        if (path != white) continue;
        cache->files[at].luma = p->luma[file];
        p->luma[file] = (FfpImage){0};
    }
}

static void free_plain(Plain *p) {
    for (int k = 0; k < 2; k++) ffp_free(p->grey[k]), ffp_image_free(&p->luma[k]);
}

// Share of the pixels at the camera's limit in the lighter of two.
static double clipped_share(const Plain *p) {
    const size_t pixels = (size_t)p->width * (size_t)p->height;
    size_t clipped = 0;
    for (size_t i = 0; i < pixels; i++) clipped += (double)p->grey[1][i] >= FFP_GRAY_CLIPPED;
    return (double)clipped / (double)pixels;
}

// True if the photographs from the k-th on are pairs of a code and its inverse: two of them add up to the
// same light as the next two.
static bool are_pairs(const char *const *files, int k, const FfpGrayPhotographs *from) {
    float *grey[4] = {NULL};
    int width[4], height[4];
    double apart = 0, sum = 0;
    FfpError none = {0};
    bool ok = true;
    for (int i = 0; ok && i < 4; i++)
        ok = files[k + i] &&
             ffp_gray_read(&grey[i], NULL, NULL, &width[i], &height[i], files[k + i], from->linear,
                           from->shrink, &none) &&
             width[i] == width[0] && height[i] == height[0];
    for (size_t i = 0; ok && i < (size_t)width[0] * (size_t)height[0]; i++)
        sum += (double)(grey[0][i] + grey[1][i]),
            apart += (double)fabsf(grey[0][i] + grey[1][i] - grey[2][i] - grey[3][i]);
    for (int i = 0; i < 4; i++) ffp_free(grey[i]);
    return ok && apart < APART * sum;
}

// True if codes follow black and white: pairs, and nowhere darker than black.
static bool has_codes_behind(const Plain *front, const FfpGrayPhotographs *from) {
    const size_t pixels = (size_t)front->width * (size_t)front->height;
    Plain codes = {.files = front->files + 2};
    FfpGrayPhotographs without_cache = *from;
    size_t lit = 0, darker = 0;
    without_cache.cache = NULL;
    bool ok = are_pairs(front->files, 2, from) && read_plain(&codes, &without_cache, NULL) &&
              codes.width == front->width && codes.height == front->height;
    for (size_t i = 0; ok && i < pixels; i++) {
        const double black = (double)front->grey[0][i], white = (double)front->grey[1][i],
                     code = (double)fminf(codes.grey[0][i], codes.grey[1][i]);
        const bool here = white - fmin(black, code) > FFP_GRAY_LIT;
        lit += here, darker += here && code < black - NOISE * white;
    }
    free_plain(&codes);
    return ok && (double)darker < (1 - BRIGHTER) * (double)lit;
}

// Says what was seen in place of black and white.
static bool fail_plain(const Plain *front, const Plain *back, int n, const FfpGrayPhotographs *from,
                       FfpError *err) {
    const char *const *files = front->files;
    Plain middle = {.files = files + 1}; // every photograph may show the pattern before its own
    FfpGrayPhotographs without_cache = *from;
    without_cache.cache = NULL;
    const bool read = !files[2] || read_plain(&middle, &without_cache, err);
    // Between white and the codes other patterns may have been shown.
    const bool late =
        read &&
        ((middle.lit && !middle.turned && choose(&middle, back) == &middle &&
          choose(&middle, front) == &middle) ||
         (n > 6 && are_pairs(files, 3, from) && !are_pairs(files, 1, from) && !are_pairs(files, 2, from)));
    free_plain(&middle);
    if (!read) return false;
    const char *lighter = files[front->turned ? 0 : 1];
    const double clipped = clipped_share(front);
    const FfpFacts facts = {.a = ffp_basename(files[0]), .b = ffp_basename(files[1])};
    if (late) return ffp_fail_by(FFP_RULE_ONE_LATE, &facts, files[0], err);
    if (clipped > ffp_rule(FFP_RULE_PLAIN_CLIPPED)->limit)
        return ffp_fail_by(FFP_RULE_PLAIN_CLIPPED, &(FfpFacts){.a = ffp_basename(lighter), .figure = clipped},
                           lighter, err);
    if (!(front->lit || back->lit)) return ffp_fail_by(FFP_RULE_NO_PLAIN_LIT, &facts, files[0], err);
    if (!front->lit) return ffp_fail_by(FFP_RULE_WHITE_IS_BLACK, &facts, files[0], err);
    if (front->share >= BRIGHTER && is_outshone(front, back))
        return ffp_fail_by(
            FFP_RULE_PLAIN_OUTSHONE,
            &(FfpFacts){.a = ffp_basename(lighter), .b = ffp_basename(back->files[back->turned ? 0 : 1])},
            files[0], err);
    return ffp_fail_by(FFP_RULE_NO_PLAIN, &facts, files[0], err);
}

// Checks that the lighter of two uses the file's range.
static bool check_range(const Plain *p, const FfpGrayPhotographs *from, FfpError *err) {
    const char *lighter = p->files[p->turned ? 0 : 1];
    float most = 0;
    for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) most = fmaxf(most, p->grey[1][i]);
    const double value = (double)ffp_srgb_encode((real)most);
    return from->linear || value <= 0 || value > ffp_rule(FFP_RULE_CODES_FEW_BITS)->limit ||
           ffp_fail_by(FFP_RULE_CODES_FEW_BITS, &(FfpFacts){.a = ffp_basename(lighter), .figure = value},
                       lighter, err);
}

void ffp_gray_tell_made(const bool missing[2], const char *const *codes) {
    const char *which = !missing[1] ? "black" : "white";
    if (missing[0] && missing[1]) which = "black or white";
    while (!*codes) codes++;
    if (missing[0] || missing[1]) ffp_tell(FFP_RULE_PLAIN_MADE, &(FfpFacts){.a = *codes, .b = which});
}

// Those of the size that most of the files have: a stray one may be a thumbnail. Returns how many there are.
static int take_usual_size(const char **usual, const char *const *files, int n) {
    int(*sizes)[2] = ffp_alloc((size_t)n + 1, sizeof *sizes), most = -1, best = 0, kept = 0;
    FfpError none = {0};
    for (int i = 0; i < n; i++)
        if (files[i]) ffp_photograph_read_size(&sizes[i][0], &sizes[i][1], files[i], &none);
    for (int i = 0; i < n; i++) {
        int count = 0;
        for (int k = 0; k < n; k++) count += memcmp(sizes[i], sizes[k], sizeof *sizes) == 0;
        if (files[i] && count > best) most = i, best = count;
    }
    for (int i = 0; i < n; i++)
        if (files[i] && memcmp(sizes[i], sizes[most], sizeof *sizes) == 0) usual[kept++] = files[i];
    ffp_free(sizes);
    return kept;
}

// True if the files are a set in another order, or one of which one is missing or too many.
static bool find_other_order(FfpGrayPhotographs *photographs, const char *const *files, int n,
                             FfpError *err) {
    FfpGrayCache *cache = photographs->cache;
    if (!cache) return false;
    cache->codes = ffp_alloc((size_t)ffp_gray_photographs(photographs->width, photographs->height),
                             sizeof *cache->codes);
    FfpGrayOrder order = {0};
    const char **there = ffp_alloc((size_t)n + 1, sizeof *there);
    const int n_there = take_usual_size(there, files, n);
    const bool found = ffp_gray_find_order(photographs, &order, there, n_there, cache->codes);
    // One too many of as many as there should be: every photograph may be late (fail_plain).
    const bool late =
        n == 2 + ffp_gray_photographs(photographs->width, photographs->height) && order.extra[0];
    const bool missing[2] = {!photographs->black, !photographs->white};
    const bool made = found && !late && ffp_gray_make_plain(photographs, err);
    for (int i = 0, k = 0; made && i < n; i++) {
        if (k < n_there && files[i] == there[k])
            k++;
        else if (files[i])
            ffp_tell(FFP_RULE_CODES_EXTRA, &(FfpFacts){.a = files[i]});
    }
    ffp_free(there);
    if (!made) return false;
    ffp_gray_tell_made(missing, cache->codes);
    ffp_gray_tell_order(&order);
    const int at = cache->n;
    for (int i = 0; i < at; i++)
        if (cache->files[i].luma.data) return true; // white is made
    cache->files[at].path = photographs->white;
    cache->n += ffp_gray_read(&cache->files[at].grey, &cache->files[at].luma, NULL, &cache->files[at].width,
                              &cache->files[at].height, photographs->white, photographs->linear,
                              photographs->shrink, err);
    return cache->n > at;
}

bool ffp_gray_find_plain(FfpGrayPhotographs *photographs, const char *const *files, int n, FfpError *err) {
    const int count = 2 + ffp_gray_photographs(photographs->width, photographs->height);
    char panel[32];
    snprintf(panel, sizeof panel, "%d x %d", photographs->width, photographs->height);
    const bool few = n >= FEW_LEAST && n <= count / 2; // the first of them, to see whether all is well
    if (n != count && find_other_order(photographs, files, n, err)) return true;
    if (n != count && !few)
        return ffp_fail_by(FFP_RULE_COUNT, &(FfpFacts){.x = n, .y = count, .a = panel}, NULL, err);
    Plain front = {.files = files}, back = {.files = files + n - 2};
    const Plain *chosen = NULL;
    const bool ok = read_plain(&front, photographs, err) &&
                    (!back.files[0] || !back.files[1] || read_plain(&back, photographs, err));
    if (ok) chosen = choose(&front, &back);
    // All that was shown but for one may be as many as black, white and the codes.
    const bool doubtful =
        chosen == &front && n == count && photographs->others > 0 && !has_codes_behind(&front, photographs);
    bool good = ok && check_range(chosen ? chosen : &front, photographs, err);
    if (good && (!chosen || doubtful) && !few && find_other_order(photographs, files, n, err))
        chosen = NULL;
    else if (good && !chosen)
        good = fail_plain(&front, &back, n, photographs, err);
    if (good && chosen) {
        photographs->codes = files + (chosen == &front ? 2 : 0);
        photographs->black = chosen->files[chosen->turned ? 1 : 0];
        photographs->white = chosen->files[chosen->turned ? 0 : 1];
    }
    if (good && chosen && photographs->cache) {
        keep_plain(photographs->cache, &front, photographs->white);
        keep_plain(photographs->cache, &back, photographs->white);
    }
    free_plain(&front), free_plain(&back);
    if (good && few) return ffp_gray_fail_few(photographs, n - 2, err);
    return good;
}
