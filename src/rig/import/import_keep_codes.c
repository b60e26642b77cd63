// Import: photographs of Gray codes, taken for depth, as further patterns for fits.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/log.h"
#include "core/patterns/patterns.h"
#include "rig/import/import_steps.h"

#define WIDTH_LEAST 4.0 // of a code's stripes, pixels of the capture: narrower ones are not resolved
#define SAME 0.02       // mean difference of two patterns that are one and the same
#define SHOWN 0.5F      // of white: a pixel of the ideal projector's picture that is on the panel

// True if two patterns, or one and the other's inverse, are the same where the panel is.
static bool is_same(const FfpImage *a, const FfpImage *b, const FfpImage *white) {
    double off = 0, off_inverse = 0, area = 0;
    for (size_t i = 0; i < 3 * (size_t)white->width * (size_t)white->height; i++) {
        if (!(white->data[i] > SHOWN)) continue;
        off += fabs((double)(a->data[i] - b->data[i]));
        off_inverse += fabs((double)(1 - a->data[i] - b->data[i]));
        area++;
    }
    return fmin(off, off_inverse) < SAME * area;
}

// True if the capture has the pattern already, held out or not, itself or its inverse: of what is held out
// nothing may be seen.
static bool is_known(const FfpCapture *capture, const FfpPattern *code) {
    const FfpImage *white = &capture->patterns[capture->white].image;
    if (ffp_capture_find_pattern(capture, code->name) >= 0) return true;
    for (int p = 0; p < ffp_patterns_shown(capture); p++)
        if (p != capture->black && p != capture->white &&
            is_same(&code->image, &capture->patterns[p].image, white))
            return true;
    return false;
}

// The code with this number as the capture's last pattern, unless it has it already.
static bool add_code(FfpImporting *import, int index) {
    FfpCapture *capture = &import->capture;
    if (!import->shots.codes[index]) return false; // missing
    FfpPattern *code = &capture->patterns[capture->n_patterns];
    char name[32];
    if (capture->n_patterns == FFP_PATTERNS_MAX) return false;
    FfpImage raw = ffp_importing_code_pattern(&import->coded, index);
    ffp_gray_code_name(import->coded.width, index, name);
    snprintf(code->name, sizeof code->name, "%s", name);
    code->image = ffp_optics_rectify(&import->calibration.projector, &capture->views[0].projector, &raw);
    ffp_image_free(&raw);
    if (is_known(capture, code)) {
        ffp_image_free(&code->image);
        return false;
    }
    code->novel = true;
    capture->n_patterns++, capture->n_codes++;
    return true;
}

// Numbers of the chosen codes, [ffp_importing_codes_looked_at], those to be held out last: of columns and
// rows in turn, from the finest that the capture's pixels resolve to coarser ones; every other one of an axis
// as its inverse, so that no part of the panel is dark in all of them. Returns how many there are.
static int choose(FfpImporting *import, int *chosen) {
    const int size[2] = {import->coded.width, import->coded.height};
    const int bits[2] = {ffp_gray_code_bits(size[0]), ffp_gray_code_bits(size[1])};
    int bit[2], taken[2] = {0}, n = 0;
    for (int axis = 0; axis < 2; axis++) {
        bit[axis] = bits[axis] - 1;
        while (bit[axis] > 0 && ldexp(1, bits[axis] - bit[axis]) < WIDTH_LEAST * import->code_step)
            bit[axis]--;
    }
    for (int axis = 0; n < ffp_importing_codes_looked_at(import) && (bit[0] >= 0 || bit[1] >= 0);
         axis = 1 - axis) {
        while (bit[axis] >= 0) {
            if (import->unlike[axis] >> bit[axis] & 1U) {
                bit[axis]--;
                continue;
            }
            const int pair = (axis ? bits[0] : 0) + bit[axis]--, wanted = 2 * pair + taken[axis] % 2,
                      index = import->shots.codes[wanted] ? wanted : wanted ^ 1;
            if (!add_code(import, index)) continue;
            chosen[n++] = index;
            taken[axis]++;
            break;
        }
    }
    return n;
}

static bool load_view(FfpImporting *import, int stop, const int *chosen, int n, FfpError *err) {
    FfpView *view = &import->capture.views[stop];
    const int first = ffp_patterns_shown(&import->capture);
    FfpImage *alphas = ffp_alloc((size_t)n, sizeof *alphas);
    const char **paths = ffp_alloc((size_t)n, sizeof *paths);
    for (int k = 0; k < n; k++)
        paths[k] = import->shots.codes[(ptrdiff_t)stop * import->shots.n_codes + chosen[k]];
    const bool ok = ffp_importing_read_pictures(import, paths, n, stop, view->images + first, alphas, err);
    for (int k = 0; k < n; k++) {
        if (ok && paths[k] && !alphas[k].data) ffp_mask_apply(&view->coverage, &view->images[first + k]);
        ffp_image_free(&alphas[k]);
    }
    ffp_free(alphas);
    ffp_free(paths);
    return ok;
}

// The last n of k elements of this size, moved to index `to`.
static void bring_forward(void *array, size_t size, int to, int k, int n) {
    char *base = array, *moved = ffp_alloc((size_t)n, size);
    memcpy(moved, base + (size_t)(k - n) * size, (size_t)n * size);
    memmove(base + (size_t)(to + n) * size, base + (size_t)to * size, (size_t)(k - n - to) * size);
    memcpy(base + (size_t)to * size, moved, (size_t)n * size);
    ffp_free(moved);
}

static void drop_last_code(FfpCapture *capture) {
    const int last = capture->n_patterns - 1;
    for (int v = 0; v < capture->n_views; v++) ffp_image_free(&capture->views[v].images[last]);
    ffp_image_free(&capture->patterns[last].image);
    capture->n_patterns--, capture->n_codes--;
}

// The last codes become patterns that are held out, if fits have as many as they are to have without them.
// Otherwise no more are looked at than without any held out.
static void hold_out(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    const int n = ffp_importing_codes_held_out(import), all = capture->n_patterns,
              to = ffp_patterns_shown(capture);
    if (n == 0) return;
    if (capture->n_codes - n < import->settings->kept_codes) {
        while (capture->n_codes > ffp_importing_codes_looked_at(import) - n) drop_last_code(capture);
        return;
    }
    bring_forward(capture->patterns, sizeof *capture->patterns, to, all, n);
    for (int v = 0; v < capture->n_views; v++)
        bring_forward(capture->views[v].images, sizeof(FfpImage), to, all, n);
    capture->n_codes -= n;
    ffp_note("%s and %s are held out: no fit sees their photographs, by which it is judged",
             capture->patterns[to].name, capture->patterns[to + 1].name);
}

bool ffp_importing_look_at_codes(FfpImporting *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    const bool cut = import->settings->projector.fit == FFP_FIT_CROPPED; // codes are of the whole panel
    if (!import->shots.codes || cut) return true;
    int *chosen = ffp_alloc((size_t)ffp_importing_codes_looked_at(import), sizeof *chosen);
    const int n = choose(import, chosen);
    bool ok = true;
    for (int v = 0; v < capture->n_views && ok; v++)
        if (capture->views[v].correspondence.data) ok = load_view(import, v, chosen, n, err);
    ffp_free(chosen);
    if (ok) hold_out(import);
    return ok;
}

void ffp_importing_keep_codes(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    while (capture->n_codes > import->settings->kept_codes) drop_last_code(capture);
    if (capture->n_codes > 0)
        ffp_note("photographs of %d Gray codes, from %s to %s, are kept for fits", capture->n_codes,
                 capture->patterns[ffp_patterns_shown(capture)].name,
                 capture->patterns[capture->n_patterns - 1].name);
}
