// Checks that photographs of Gray codes are in the order in which they were shown, and finds those that are
// not.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"
#include "rig/graycode/edges.h"

#define RESOLVED 0.5    // of the pixels must tell a bit, or it counts as too fine
#define RESTLESS 0.3    // of the pixels at which a bit changes, from which on it may do so at random:
#define FINER 1.5       // that is where it has fewer edges than so many times the next coarser bit's
#define LINES_CHECKED 3 // edges across what is lit, by which one bit may have more than the next
#define STEPS_OVER                                                                                           \
    0.1            // of the neighbours that differ, those that do by several bits: codes are stepped over,
#define NEXT_MAX 7 // and numbers go on by up to as much
#define EDGES_CHECKED 50 // of a bit, from which its edges say something
#define GOES_ON 4        // blocks by which the other axis' code may change between neighbours on one surface
#define LONG 0.1         // of a line: what a bit's edge has of a stripe's at one place of the panel
#define JUMPS 0.5        // share of a bit's edges at which numbers jump
#define JUMPS_RIGHT 0.1  // where the order is right
#define BEYOND 0.05      // share of the pixels that a number beyond the panel may have
#define BEYOND_RIGHT 0.01

// Neighbours between which a bit changes, along rows and columns.
static size_t changes_of(const FfpGrayDecoder *d, int axis, int bit) {
    const uint8_t *signal = d->signal[axis][bit];
    size_t changes = 0;
    for (size_t i = (size_t)d->width; i < d->pixels; i++)
        for (size_t back = 1; d->checked[i]; back = (size_t)d->width) {
            changes +=
                d->checked[i - back] && (signal[i] > FFP_GRAY_NONE) != (signal[i - back] > FFP_GRAY_NONE);
            if (back > 1) break;
        }
    return changes;
}

// True if most pixels tell a bit from its inverse, and its stripes are not so fine that the camera's pixels
// show them at random: each bit has twice as many edges as the one before.
static bool is_resolved(const FfpGrayDecoder *d, int axis, int bit) {
    size_t told = 0, lit = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        if (!d->checked[i]) continue;
        lit++, told += abs(ffp_gray_signal(d->signal[axis][bit][i])) > FFP_GRAY_WEAK;
    }
    if ((double)told < RESOLVED * (double)lit) return false;
    const double here = (double)changes_of(d, axis, bit), before = (double)changes_of(d, axis, bit - 1);
    // Without its inverse what a blurred bit shows depends on how bright its surroundings are.
    const bool whole = ffp_gray_has_photograph(d, axis, bit, 0) && ffp_gray_has_photograph(d, axis, bit, 1);
    return (whole && here < RESTLESS * (double)lit) || here >= FINER * before;
}

void ffp_gray_drop_fine_bits(FfpGrayDecoder *d, int axis) {
    int bit = d->bits[axis] - 1 - d->missing[axis];
    while (bit > 0 && !is_resolved(d, axis, bit)) bit--;
    d->dropped[axis] = d->report->dropped[axis] = d->bits[axis] - 1 - bit;
}

// --- What tells the order. ---

// Between neighbouring pixels one bit changes at a time. Which photograph stands for which bit changes what
// the numbers are, but not that.
typedef struct Seen {
    int bits, block, size;           // used; panel pixels that share a code; the panel's
    unsigned numbers;                // that so many bits tell apart
    size_t lines[FFP_GRAY_BITS_MAX]; // pixels between which a bit changes
    uint32_t *words;                 // [1 << bits] pixels with these bits, the coarsest highest
    uint32_t *edges; // [bits, 1 << bits] of those, how many have a neighbour that differs in this bit alone
    double line;     // pixels of an edge across what is checked
    double count;    // of pixels with a code
    double singles, several; // neighbours that differ in one bit, and in more: a camera that steps over codes
} Seen;

// Two photographs or pairs changed over: a bit with another, or, the same twice, with its inverse.
typedef struct Swap {
    int first, second; // -1: none
} Swap;

static unsigned gray_of(int number) {
    return (unsigned)number ^ (unsigned)number >> 1;
}

static int lowest(unsigned bits) {
    int at = 0;
    for (; !(bits & 1U); bits >>= 1) at++;
    return at;
}

// True if two neighbours may lie on one surface: at a silhouette the other axis' code jumps as well.
static bool goes_on(const FfpGrayDecoder *d, int axis, size_t a, size_t b) {
    const int *other = d->code[1 - axis];
    return other[a] >= 0 && other[b] >= 0 && abs(other[a] - other[b]) <= GOES_ON;
}

static void see_pair(const FfpGrayDecoder *d, int axis, size_t a, size_t b, Seen *seen) {
    if (!goes_on(d, axis, a, b)) return;
    if (d->checked[a] && d->checked[b])
        for (int bit = 0; bit < seen->bits; bit++)
            seen->lines[bit] +=
                (d->signal[axis][bit][a] > FFP_GRAY_NONE) != (d->signal[axis][bit][b] > FFP_GRAY_NONE);
    if (d->code[axis][a] < 0 || d->code[axis][b] < 0) return;
    const unsigned word = gray_of(d->code[axis][a]), difference = word ^ gray_of(d->code[axis][b]);
    if (difference == 0) return;
    const bool single = (difference & (difference - 1)) == 0;
    *(single ? &seen->singles : &seen->several) += 1;
    if (!single) return;
    const size_t bit = (size_t)(seen->bits - 1 - lowest(difference));
    seen->edges[bit * seen->numbers + word]++;
}

static void see(const FfpGrayDecoder *d, int axis, Seen *seen) {
    const size_t width = (size_t)d->width, rows = (size_t)d->height;
    const int bits =
        d->bits[axis] > d->dropped[axis] ? d->bits[axis] - d->dropped[axis] : 1; // the coarsest stays
    size_t checked = 0;
    *seen = (Seen){.bits = bits,
                   .numbers = 1U << bits,
                   .block = 1 << d->dropped[axis],
                   .size = axis ? d->from->height : d->from->width,
                   .words = ffp_alloc(1U << bits, sizeof(uint32_t)),
                   .edges = ffp_alloc((size_t)bits << bits, sizeof(uint32_t))};
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < width; x++) {
            const size_t i = y * width + x;
            checked += d->checked[i];
            if (d->checked[i] && d->code[axis][i] >= 0)
                seen->words[gray_of(d->code[axis][i])]++, seen->count++;
            if (x + 1 < width) see_pair(d, axis, i, i + 1, seen);
            if (y + 1 < rows) see_pair(d, axis, i, i + width, seen);
        }
    seen->line = sqrt((double)checked);
}

// The number of a word of bits after a swap.
static int number_of(const Seen *seen, unsigned word, const Swap *swap) {
    bool bits[FFP_GRAY_BITS_MAX];
    for (int k = 0; k < seen->bits; k++) bits[k] = word >> (seen->bits - 1 - k) & 1U;
    if (swap->first >= 0) {
        const bool held = bits[swap->first];
        bits[swap->first] = swap->first == swap->second ? !held : bits[swap->second];
        if (swap->first != swap->second) bits[swap->second] = held;
    }
    return ffp_gray_decode(bits, seen->bits);
}

// Each bit has twice the edges of the one before, give or take those at the rim of what is lit: the first
// that has fewer, -1: none.
static int broader_bit(const Seen *seen, const Swap *swap) {
    double before = 0;
    for (int bit = 0; bit < seen->bits; bit++) {
        const int shown = bit == swap->first ? swap->second : bit == swap->second ? swap->first : bit;
        const double here = (double)seen->lines[shown];
        if (before > 1.5 * here + LINES_CHECKED * seen->line) return bit;
        before = here;
    }
    return -1;
}

// Where one bit alone changes, a number must go on to the next, or to one near it where the camera steps over
// codes. Where photographs have changed places, it jumps at the edges of coarser bits: the finest bit with
// such edges, -1: none. The edge of a stripe is one and the same change along a line; single changes, as
// silhouettes have them, do not count.
static int jumping_bit(const Seen *seen, const Swap *swap, double most) {
    const int next = seen->several > STEPS_OVER * seen->singles ? NEXT_MAX : 1;
    for (int bit = seen->bits - 1; bit >= 0; bit--) {
        double jumps = 0, edges = 0;
        for (unsigned word = 0; word < seen->numbers; word++) {
            const double n = seen->edges[(size_t)bit * seen->numbers + word];
            if (!(n > LONG * seen->line)) continue;
            const unsigned other = word ^ 1U << (seen->bits - 1 - bit);
            edges += n;
            jumps += abs(number_of(seen, word, swap) - number_of(seen, other, swap)) > next ? n : 0;
        }
        if (edges >= EDGES_CHECKED && jumps >= most * edges) return bit;
    }
    return -1;
}

// Share of the pixels whose number is beyond the panel.
static double beyond_panel(const Seen *seen, const Swap *swap) {
    double beyond = 0;
    for (unsigned word = 0; word < seen->numbers; word++)
        if (seen->words[word] > 0 && number_of(seen, word, swap) * seen->block >= seen->size)
            beyond += seen->words[word];
    return beyond / fmax(1, seen->count);
}

// --- What is said of it. ---

// Puts the one swap after which everything is in order into words; "" where there is none, or several.
static void explain(const FfpGrayDecoder *d, int axis, const Seen *seen, char text[400]) {
    Swap found = {-1, -1};
    int explanations = 0;
    for (int i = 0; i < seen->bits; i++)
        for (int j = i; j < seen->bits; j++) {
            const Swap swap = {i, j};
            if (broader_bit(seen, &swap) >= 0 || beyond_panel(seen, &swap) > BEYOND_RIGHT ||
                jumping_bit(seen, &swap, JUMPS_RIGHT) >= 0)
                continue;
            found = swap, explanations++;
        }
    text[0] = 0;
    if (explanations != 1) return;
    const bool inverse = found.first == found.second;
    snprintf(text, 400, "%s%.120s and %.120s", inverse ? "" : "the pairs of ",
             ffp_basename(ffp_gray_photograph(d, axis, found.first, 0)),
             ffp_basename(ffp_gray_photograph(d, axis, found.second, inverse)));
}

static bool tell(const FfpGrayDecoder *d, int axis, const Seen *seen, FfpError *err) {
    const Swap none = {-1, -1};
    char swap[400];
    const int broader = broader_bit(seen, &none), jumping = jumping_bit(seen, &none, JUMPS);
    const double beyond = beyond_panel(seen, &none);
    // Where the sides are exchanged, the rows' coarsest code comes earlier or later than it should.
    const int apart = d->bits[axis] - d->bits[1 - axis], rows_from = axis == 0 ? d->bits[1] : apart;
    const int at = broader >= 0               ? broader
                   : jumping < 0              ? 0
                   : jumping + 1 < seen->bits ? jumping + 1
                                              : jumping;
    const char *where = ffp_gray_photograph(d, axis, at, 0);
    if (broader < 0 && jumping < 0 && !(beyond > BEYOND)) return true;
    if (broader > 0 && apart > 0 && broader == rows_from)
        return ffp_fail_by(FFP_RULE_PANEL_SIDES, &(FfpFacts){.x = d->from->width, .y = d->from->height},
                           where, err);
    explain(d, axis, seen, swap);
    if (broader < 0 && jumping < 0)
        return ffp_fail_by(FFP_RULE_PANEL_SIZE,
                           &(FfpFacts){.figure = beyond,
                                       .limit = BEYOND,
                                       .a = axis ? "rows" : "columns",
                                       .b = swap[0] ? swap : "columns and rows",
                                       .x = seen->size},
                           where, err);
    return ffp_fail_by(swap[0] ? FFP_RULE_CODES_SWAPPED : FFP_RULE_CODES_ORDER,
                       &(FfpFacts){.a = swap,
                                   .b = broader >= 0 ? "its stripes are wider than those before it"
                                                     : "numbers jump at its neighbour's edges"},
                       where, err);
}

bool ffp_gray_check_order(const FfpGrayDecoder *d, int axis, FfpError *err) {
    Seen seen;
    see(d, axis, &seen);
    const bool ok = tell(d, axis, &seen, err);
    ffp_free(seen.words), ffp_free(seen.edges);
    return ok;
}
