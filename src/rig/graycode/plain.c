// Which photographs are black and white.
#include <math.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"

#define NOISE 0.1    // of the brighter one: a smaller difference is noise
#define OUTSIDE 0.05 // linear: a code is nowhere darker than black, or brighter than white, by as much
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
    if (!ffp_gray_read(&p->grey[0], luma, &p->width, &p->height, p->files[0], from->linear, from->shrink,
                       err) ||
        !ffp_gray_read(&p->grey[1], luma ? luma + 1 : NULL, &width, &height, p->files[1], from->linear,
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

// Says what was seen in place of black and white.
static bool fail_plain(const Plain *front, const Plain *back, const FfpGrayPhotographs *from, FfpError *err) {
    const char *const *files = front->files;
    Plain middle = {.files = files + 1}; // every photograph may show the pattern before its own
    FfpGrayPhotographs without_cache = *from;
    without_cache.cache = NULL;
    const bool read = read_plain(&middle, &without_cache, err);
    const bool late =
        read && !middle.turned && choose(&middle, back) == &middle && choose(&middle, front) == &middle;
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

bool ffp_gray_find_plain(FfpGrayPhotographs *photographs, const char *const *files, int n, FfpError *err) {
    const int count = 2 + ffp_gray_photographs(photographs->width, photographs->height);
    char panel[32];
    snprintf(panel, sizeof panel, "%d x %d", photographs->width, photographs->height);
    if (n != count)
        return ffp_fail_by(FFP_RULE_COUNT, &(FfpFacts){.x = n, .y = count, .a = panel}, NULL, err);
    Plain front = {.files = files}, back = {.files = files + count - 2};
    const Plain *chosen = NULL;
    const bool ok = read_plain(&front, photographs, err) && read_plain(&back, photographs, err);
    if (ok) chosen = choose(&front, &back);
    const bool good = ok && check_range(chosen ? chosen : &front, photographs, err) &&
                      (chosen || fail_plain(&front, &back, photographs, err));
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
    return good;
}
