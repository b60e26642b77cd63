#include "calibrate/codes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/alloc.h"
#include "base/call.h"
#include "base/file.h"
#include "patterns/patterns.h"

#define LIT 0.04F        // what white adds to black, encoded: below it a pixel is dark
#define OUTSIDE 0.12F    // more than noise in the dark, which the encoding enlarges
#define BRIGHTER 0.9     // share of lit pixels of which white must be the brighter
#define CERTAIN 0.05F    // of white minus black: a smaller difference of code and inverse leaves a bit open
#define NOISE 0.012F     // and the least difference, three steps of 8 bits
#define SUM_OFF 0.25F    // of white minus black: code and inverse together differ from black and white
#define DECIDED 0.65F    // the same: one of a pair is light and the other dark; blurred stripes differ less
#define BOTH_ALIKE 0.75F // the same for both light, or both dark
#define SUM_SHARE 0.25   // of the pixels: the pictures do not belong together
#define ONE_WAY 0.85     // of those: all brighter, or all darker
#define RESOLVED 0.3     // share of the lit pixels that must know a bit
enum { BITS_MAX = 15, LOST_MAX = 2 };

bool ffp_read_grey(FfpImage *grey, const char *path, FfpError *err) {
    FfpImage image;
    if (!ffp_image_read(&image, path, FFP_COLOUR_ENCODED, err)) return false;
    *grey = ffp_image_new(image.width, image.height, 1);
    const size_t pixels = (size_t)image.width * (size_t)image.height;
    for (size_t i = 0; i < pixels; i++) { // luma of BT.601, as corner detectors have it
        const real *c = image.data + 4 * i;
        grey->data[i] = 0.299F * c[0] + 0.587F * c[1] + 0.114F * c[2];
    }
    ffp_image_free(&image);
    return true;
}

static int bits_of(const FfpCodeShots *shots, int axis) {
    return ffp_gray_code_bits(axis == 0 ? shots->width : shots->height);
}

int ffp_code_shots_count(int width, int height) {
    return 2 + 2 * (ffp_gray_code_bits(width) + ffp_gray_code_bits(height));
}

// --- Black and white. ---

// Share of the pixels that differ by light of which a is the brighter; 0.5 where there are none.
static double brighter(const FfpImage *a, const FfpImage *b) {
    const size_t pixels = (size_t)a->width * (size_t)a->height;
    size_t lit = 0, more = 0;
    for (size_t i = 0; i < pixels; i++) {
        const real d = a->data[i] - b->data[i];
        if (fabsf((float)d) < LIT) continue;
        lit++;
        more += d > 0;
    }
    return lit > pixels / 1000 ? (double)more / (double)lit : 0.5;
}

static bool same_size(const FfpImage *a, const FfpImage *b, const char *path, const char *other,
                      FfpError *err) {
    return (a->width == b->width && a->height == b->height) ||
           ffp_fail(err, FFP_ERROR_FILE, path, "is of %d x %d pixels, %s of %d x %d", a->width, a->height,
                    ffp_basename(other), b->width, b->height);
}

// How plainly the pictures at `at` and behind it are black and white: the share, of the brighter one.
static bool try_pair(const FfpCodeShots *shots, int at, FfpImage pair[2], double *share, FfpError *err) {
    const char *const *files = shots->files + at;
    if (!ffp_read_grey(&pair[0], files[0], err)) return false;
    if (!ffp_read_grey(&pair[1], files[1], err) || !same_size(&pair[1], &pair[0], files[1], files[0], err)) {
        ffp_image_free(&pair[0]), ffp_image_free(&pair[1]);
        return false;
    }
    *share = brighter(&pair[1], &pair[0]);
    if (*share < 0.5) { // black behind white
        const FfpImage swap = pair[0];
        pair[0] = pair[1], pair[1] = swap;
        *share = 1 - *share;
    }
    return true;
}

// Whether a picture is nowhere much darker than black nor brighter than white.
static bool lies_between(const FfpImage *image, const FfpImage *black, const FfpImage *white) {
    const size_t pixels = (size_t)black->width * (size_t)black->height;
    size_t lit = 0, outside = 0;
    if (image->width != black->width || image->height != black->height) return true; // is said later
    for (size_t i = 0; i < pixels; i++) {
        lit += white->data[i] - black->data[i] > LIT;
        outside += image->data[i] < black->data[i] - OUTSIDE || image->data[i] > white->data[i] + OUTSIDE;
    }
    return (double)outside < (1 - BRIGHTER) * (double)lit;
}

static double mean(const FfpImage *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) sum += (double)image->data[i];
    return sum / (double)pixels;
}

bool ffp_code_shots_open(const FfpCodeShots *shots, FfpImage *black, FfpImage *white, int *first,
                         FfpError *err) {
    const int count = ffp_code_shots_count(shots->width, shots->height);
    if (shots->n_files != count)
        return ffp_fail(
            err, FFP_ERROR_FILE, NULL,
            "there are %d photographs, and for a projector of %d x %d pixels it must be %d: black, "
            "white and %d pairs of Gray codes",
            shots->n_files, shots->width, shots->height, count, count / 2 - 1);
    FfpImage front[2] = {{0}}, back[2] = {{0}};
    double shares[2] = {0, 0};
    if (!try_pair(shots, 0, front, &shares[0], err)) return false;
    if (!try_pair(shots, count - 2, back, &shares[1], err)) {
        ffp_image_free(&front[0]), ffp_image_free(&front[1]);
        return false;
    }
    // The coarsest code may be as plain where the board sees half of the panel: then the contrast tells.
    bool at_front = shares[0] > shares[1];
    if (shares[0] > BRIGHTER && shares[1] > BRIGHTER)
        at_front = mean(&front[1]) - mean(&front[0]) > mean(&back[1]) - mean(&back[0]);
    *first = at_front ? 2 : 0;
    FfpImage *keep = at_front ? front : back, *drop = at_front ? back : front;
    const bool plain = fmax(shares[0], shares[1]) >= BRIGHTER && lies_between(&drop[0], &keep[0], &keep[1]) &&
                       lies_between(&drop[1], &keep[0], &keep[1]);
    ffp_image_free(&drop[0]), ffp_image_free(&drop[1]);
    if (!plain) {
        ffp_image_free(&keep[0]), ffp_image_free(&keep[1]);
        return ffp_fail(
            err, FFP_ERROR_FILE, shots->files[0],
            "neither the first two photographs nor the last two are the projector black and white");
    }
    *black = keep[0], *white = keep[1];
    return true;
}

// --- Whether a pair belongs to the others. ---

typedef struct Pair {
    const FfpImage *black, *white, *code, *inverse;
    const char *files[2];
} Pair;

// Where one of a pair is light and the other dark, they light a pixel as black and white together do,
// whatever the camera's tone curve; stripes that the camera does not resolve are grey in both, and say
// nothing. Where the sums are off, and all one way, the light was another one; both ways, or with both
// pictures light or both dark, they are not each other's inverse.
static bool check_sums(const Pair *p, const unsigned char *region, FfpError *err) {
    const size_t pixels = (size_t)p->black->width * (size_t)p->black->height;
    size_t lit = 0, over = 0, under = 0;
    for (size_t i = 0; i < pixels; i++) {
        const real black = p->black->data[i], range = p->white->data[i] - black;
        if (!region[i] || range < 2 * LIT) continue;
        const real code = (p->code->data[i] - black) / range, inverse = (p->inverse->data[i] - black) / range;
        const real off = code + inverse - 1;
        const bool decided = fabsf(code - inverse) > DECIDED || fabsf(off) > BOTH_ALIKE;
        lit++;
        over += decided && off > SUM_OFF, under += decided && off < -SUM_OFF;
    }
    const double wrong = (double)(over + under), most = (double)(over > under ? over : under);
    if (wrong <= SUM_SHARE * (double)lit) return true;
    const char *second = ffp_basename(p->files[1]);
    if (most >= ONE_WAY * wrong)
        return ffp_fail(
            err, FFP_ERROR_FILE, p->files[0],
            "this picture and %s are together %s than black and white: exposure, aperture, ISO and "
            "white balance must stay the same",
            second, over > under ? "brighter" : "darker");
    return ffp_fail(err, FFP_ERROR_FILE, p->files[0],
                    "this picture and %s are not each other's inverse: their numbering is not the order in "
                    "which they were shown, or the board moved",
                    second);
}

// --- Bits. ---

typedef struct Bits {
    unsigned *codes;     // [pixels], coarsest bit highest
    unsigned *uncertain; // [pixels], likewise: bits in doubt
    size_t pixels;
} Bits;

static void take_bit(const Pair *p, int shift, Bits *bits) {
    for (size_t i = 0; i < bits->pixels; i++) {
        const float range = (float)(p->white->data[i] - p->black->data[i]);
        const float d = (float)(p->code->data[i] - p->inverse->data[i]);
        bits->codes[i] |= (unsigned)(d > 0) << shift;
        bits->uncertain[i] |= (unsigned)(fabsf(d) < fmaxf(NOISE, CERTAIN * range)) << shift;
    }
}

static bool read_pair(const FfpCodeShots *shots, int at, Pair *p, FfpImage images[2], FfpError *err) {
    for (int i = 0; i < 2; i++) p->files[i] = shots->files[at + i];
    bool ok = ffp_read_grey(&images[0], p->files[0], err) && ffp_read_grey(&images[1], p->files[1], err);
    for (int i = 0; ok && i < 2; i++) ok = same_size(&images[i], p->white, p->files[i], "white", err);
    p->code = &images[0], p->inverse = &images[1];
    return ok;
}

static bool read_bits(const FfpCodeShots *shots, int first, int count, const Pair *frame,
                      const unsigned char *region, Bits *bits, FfpError *err) {
    for (int bit = 0; bit < count; bit++) {
        FfpImage images[2] = {{0}};
        Pair pair = *frame;
        ffp_cancel_point();
        const bool ok =
            read_pair(shots, first + 2 * bit, &pair, images, err) && check_sums(&pair, region, err);
        if (ok) take_bit(&pair, count - 1 - bit, bits);
        ffp_image_free(&images[0]), ffp_image_free(&images[1]);
        if (!ok) return false;
    }
    return true;
}

// Finest bits that most pixels of the region do not know: the camera or the projector's lens is too coarse.
static int lost_bits(const Bits *bits, const Pair *frame, const unsigned char *region) {
    for (int lost = 0;; lost++) {
        size_t lit = 0, known = 0;
        for (size_t i = 0; i < bits->pixels; i++) {
            if (!region[i] || frame->white->data[i] - frame->black->data[i] < 2 * LIT) continue;
            lit++;
            known += !(bits->uncertain[i] >> lost & 1U);
        }
        if (lost == LOST_MAX || (double)known >= RESOLVED * (double)lit) return lost;
    }
}

static void decode(const Bits *bits, const Pair *frame, int count, int lost, int size, float *out) {
    bool list[BITS_MAX];
    for (size_t i = 0; i < bits->pixels; i++) {
        out[i] = -1;
        if (frame->white->data[i] - frame->black->data[i] < LIT || bits->uncertain[i] >> lost) continue;
        for (int k = 0; k < count - lost; k++) list[k] = bits->codes[i] >> (count - 1 - k) & 1U;
        const int step = 1 << lost, value = ffp_gray_decode(list, count - lost) * step;
        if (value < size) out[i] = (float)value + 0.5F * (float)(step - 1);
    }
}

bool ffp_code_map_read(FfpCodeMap *map, const FfpCodeShots *shots, int first, const FfpImage *black,
                       const FfpImage *white, const unsigned char *region, FfpError *err) {
    const size_t pixels = (size_t)white->width * (size_t)white->height;
    const Pair frame = {.black = black, .white = white};
    *map = (FfpCodeMap){.width = white->width, .height = white->height};
    map->column = ffp_alloc(pixels, sizeof *map->column), map->row = ffp_alloc(pixels, sizeof *map->row);
    bool ok = true;
    for (int axis = 0; ok && axis < 2; axis++) {
        const int count = bits_of(shots, axis), size = axis == 0 ? shots->width : shots->height;
        Bits bits = {ffp_alloc(pixels, sizeof(unsigned)), ffp_alloc(pixels, sizeof(unsigned)), pixels};
        ok = read_bits(shots, first, count, &frame, region, &bits, err);
        map->lost[axis] = ok ? lost_bits(&bits, &frame, region) : 0;
        if (ok) decode(&bits, &frame, count, map->lost[axis], size, axis == 0 ? map->column : map->row);
        ffp_free(bits.codes), ffp_free(bits.uncertain);
        first += 2 * count;
    }
    if (!ok) ffp_code_map_free(map);
    return ok;
}

void ffp_code_map_free(FfpCodeMap *map) {
    ffp_free(map->column), ffp_free(map->row);
    *map = (FfpCodeMap){0};
}
