// Which photograph shows what: orders of other programs, by what the pictures themselves tell.
#include "rig/graycode/orders.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/photograph.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"

#define PIXELS_MOST 3e5  // of a photograph that is looked at
#define BRIGHT 0.25      // of the typical light: pixels that are looked at
#define SURE 12          // of 127: a pixel is on one side of an edge
#define DIRECTION 0.5    // what an edge's direction counts beside what a pair counts
#define IGNORED 0.3      // cost of a black or white photograph that is not believed
#define ODD 0.005        // and of each thing that few sets have
#define COST_SURE 0.1    // of an order that needs no other
#define COST_MOST 0.28   // of an order, from 0, as it should be, to 1, the opposite; chance gives 0.5
#define COST_OF_GAP 0.03 // less of it for each photograph that is missing or too many
#define PAIR_MOST (-0.5) // correlation of two that are each other's inverse, where both are clear:
#define CLEAR 0.2        // mean square of sides
#define PLAINLY 0.5      // light of black and white, at least
#define TERMS 8          // that a code has at most: its pair (2), and the light, direction and edges of both
enum { FILES_MOST = 2 * 2 * FFP_GRAY_BITS_MAX + 16, LIT_LEAST = 64, STRIDE = 4 };

// --- What was seen. ---

typedef struct Sight {
    int n, width, height;
    signed char *side;                     // [pixels, n] -127 dark to 127 light; 0 all along: not looked at
    unsigned char *seen;                   // [pixels]
    double light[FILES_MOST];              // mean of sides, -1 to 1
    double alike[FILES_MOST][FILES_MOST];  // mean product of sides: -1, each other's inverse
    double apart[FILES_MOST][FILES_MOST];  // mean size of the sum of their sides: 0, they add up to white
    double beside[FILES_MOST][FILES_MOST]; // light of the second at the edges of the first
    double upright[FILES_MOST];            // share of its edges that separate columns
    bool edged[FILES_MOST];                // it has enough of them to tell
} Sight;

static int by_value(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// Sides of each pixel between its second darkest and its second brightest photograph: one may be wrong.
static bool find_sides(Sight *s, float *const *grey) {
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    float *middle = ffp_alloc(pixels, sizeof *middle), *range = ffp_alloc(pixels, sizeof *range);
    double sum = 0, lit = 0, count = 0;
    for (size_t p = 0; p < pixels; p++) {
        float values[FILES_MOST];
        for (int i = 0; i < s->n; i++) values[i] = grey[i][p];
        qsort(values, (size_t)s->n, sizeof *values, by_value);
        range[p] = values[s->n - 2] - values[1], middle[p] = (values[s->n - 2] + values[1]) / 2;
        if ((double)range[p] > FFP_GRAY_LIT) sum += (double)range[p], lit++;
    }
    for (size_t p = 0; p < pixels; p++) {
        s->seen[p] = (double)range[p] > fmax(FFP_GRAY_LIT, BRIGHT * sum / fmax(lit, 1));
        count += s->seen[p];
        for (int i = 0; s->seen[p] && i < s->n; i++)
            s->side[p * (size_t)s->n + (size_t)i] =
                (signed char)lrintf(127 * fmaxf(-1, fminf(2 * (grey[i][p] - middle[p]) / range[p], 1)));
    }
    ffp_free(middle), ffp_free(range);
    return count >= LIT_LEAST;
}

// Adds what lies beside the edges between two pixels.
static void see_edges(Sight *s, size_t a, size_t b, bool upright, double *edges) {
    const signed char *x = s->side + a * (size_t)s->n, *y = s->side + b * (size_t)s->n;
    if (!s->seen[a] || !s->seen[b]) return;
    for (int i = 0; i < s->n; i++) {
        if ((x[i] > 0) == (y[i] > 0) || abs(x[i]) < SURE || abs(y[i]) < SURE) continue;
        edges[i]++, s->upright[i] += upright;
        for (int k = 0; k < s->n; k++) s->beside[i][k] += (x[k] + y[k]) / 254.0;
    }
}

static void look(Sight *s) {
    const size_t width = (size_t)s->width, pixels = width * (size_t)s->height;
    double edges[FILES_MOST] = {0}, count = 0;
    for (size_t p = 0; p < pixels; p++) {
        const signed char *x = s->side + p * (size_t)s->n;
        if ((p + 1) % width != 0) see_edges(s, p, p + 1, true, edges);
        if (p + width < pixels) see_edges(s, p, p + width, false, edges);
        if (!s->seen[p] || p % STRIDE != 0) continue;
        count++;
        for (int i = 0; i < s->n; i++) {
            s->light[i] += x[i] / 127.0;
            for (int k = 0; k <= i; k++) {
                s->alike[i][k] += x[i] * x[k] / (127.0 * 127.0);
                s->apart[i][k] += abs(x[i] + x[k]) / 127.0;
            }
        }
    }
    for (int i = 0; i < s->n; i++) {
        s->light[i] /= fmax(count, 1), s->upright[i] /= fmax(edges[i], 1);
        for (int k = 0; k < s->n; k++) s->beside[i][k] /= fmax(edges[i], 1);
        s->edged[i] = edges[i] >= LIT_LEAST / 4;
        for (int k = 0; k <= i; k++) {
            s->alike[k][i] = s->alike[i][k] /= fmax(count, 1);
            s->apart[k][i] = s->apart[i][k] /= fmax(count, 1);
        }
    }
}

static bool see(Sight *s, const FfpGrayPhotographs *from, const char *const *files, int n) {
    float *grey[FILES_MOST] = {NULL};
    FfpError none = {0};
    int width, height, shrink = 1;
    bool ok = ffp_photograph_read_size(&width, &height, files[0], &none);
    while (ok && shrink < 8 && (double)width * height > PIXELS_MOST * shrink * shrink) shrink *= 2;
    *s = (Sight){.n = n};
    for (int i = 0; ok && i < n; i++) {
        ok = ffp_gray_read(&grey[i], NULL, NULL, &width, &height, files[i], from->linear, shrink, &none) &&
             (i == 0 || (width == s->width && height == s->height));
        s->width = width, s->height = height;
        ffp_cancel_point();
    }
    const size_t pixels = ok ? (size_t)s->width * (size_t)s->height : 1;
    s->side = ffp_alloc(pixels * (size_t)n, 1), s->seen = ffp_alloc(pixels, 1);
    ok = ok && find_sides(s, grey);
    if (ok) look(s);
    for (int i = 0; i < n; i++) ffp_free(grey[i]);
    ffp_free(s->side), ffp_free(s->seen);
    return ok;
}

// --- The table of orders. ---

typedef enum Inverses { BESIDE, APART, APART_BY_AXIS, WITHOUT, INVERSES } Inverses;
typedef enum Plain { FIRST, LAST, AROUND, NOWHERE, PLAINS } Plain; // AROUND: black first, white last
enum { GAPS = FFP_GRAY_GAPS };

// Numbers of the slots without a file, then of the files without a slot.
typedef struct Gaps {
    int at[GAPS], n_lost, n_extra;
} Gaps;

typedef struct Order {
    bool rows_first, finest_first, inverse_first, equal_bits, ignore_plain;
    Inverses inverses;
    Plain plain;
    int others; // photographs of other patterns between black and white and the codes
    bool alone; // none of them, though there may be some
} Order;

enum { BLACK = -1, WHITE = -2, CONSTANT = -3, LIT_CONSTANT = -4, OTHER = -5 }; // slots without a code

// The photographs of an order, slot by slot: the codes' numbers as graycode.h has them, or those above.
// Returns how many there are.
static int list_slots(const Order *o, const int bits[2], int slots[FILES_MOST]) {
    const int most = bits[0] > bits[1] ? bits[0] : bits[1];
    const int used[2] = {o->equal_bits ? most : bits[0], o->equal_bits ? most : bits[1]};
    const int signs = o->inverses == WITHOUT ? 1 : 2, all = used[0] + used[1];
    const int count = signs * all + o->others + (o->plain != NOWHERE ? 2 : 0);
    int at = 0;
    if (count > FILES_MOST - 1) return 0;
    if (o->plain == FIRST || o->plain == AROUND) slots[at++] = BLACK;
    if (o->plain == FIRST) slots[at++] = WHITE;
    for (int k = 0; k < o->others; k++) slots[at++] = OTHER;
    for (int k = 0; k < signs * all; k++) {
        // Place among the pairs in the order shown, and which of the pair.
        const int first = o->rows_first ? used[1] : used[0], half = k < signs * first ? first : all - first;
        const int in_axis = k < signs * first ? k : k - signs * first;
        int pair = k / signs, second = k % signs;
        if (o->inverses == APART) pair = k % all, second = k / all;
        if (o->inverses == APART_BY_AXIS)
            pair = in_axis % half + (k < signs * first ? 0 : first), second = in_axis / half;
        const int axis = (pair >= first) != o->rows_first;
        const int place = pair - (pair >= first ? first : 0);
        const int bit = (o->finest_first ? used[axis] - 1 - place : place) - (used[axis] - bits[axis]);
        const int inverse = (second == 1) != o->inverse_first && signs == 2;
        slots[at++] = bit >= 0  ? 2 * ((axis ? bits[0] : 0) + bit) + inverse
                      : inverse ? LIT_CONSTANT
                                : CONSTANT;
    }
    if (o->plain == LAST) slots[at++] = BLACK;
    if (o->plain == LAST || o->plain == AROUND) slots[at++] = WHITE;
    return at;
}

// --- How well an order explains what was seen. ---

typedef struct Cost {
    double sum, terms;
} Cost;

static void cost_of(Cost *cost, double weight, double is, double should) {
    cost->sum += weight * fabs(is - should) / 2, cost->terms += weight;
}

// Of a code's photographs: each other's inverse; light at the edges of the next coarser code, and dark at
// those of the one before. One that is lost is a fine one: without a coarse one no set could be read.
static void cost_of_code(Cost *cost, const Sight *s, const int (*file)[2], int axis, int bit, int bits) {
    const int *own = file[bit];
    if (own[0] < 0 && own[1] < 0) cost_of(cost, 2, -1, 1 - 2.0 * bit / bits);
    if (own[0] >= 0 && own[1] >= 0) {
        const double clear[2] = {s->alike[own[0]][own[0]], s->alike[own[1]][own[1]]};
        const double alike = s->alike[own[0]][own[1]] / sqrt(fmax(clear[0] * clear[1], 1e-6));
        cost_of(cost, 1, alike, -1);
        cost_of(cost, 1, s->apart[own[0]][own[1]], 0);
        if (alike > PAIR_MOST && fmin(clear[0], clear[1]) > CLEAR) cost->sum = INFINITY;
    }
    for (int inverse = 0; inverse < 2; inverse++) {
        const int sign = inverse ? -1 : 1;
        if (own[inverse] < 0) continue;
        cost_of(cost, DIRECTION, fabs(s->light[own[inverse]]), 0); // a code's pair is neither black nor white
        if (s->edged[own[inverse]]) cost_of(cost, DIRECTION, 2 * s->upright[own[inverse]] - 1, axis ? -1 : 1);
        for (int k = 0; k < 4; k++) {
            const int back = k / 2 + 1, other = bit >= back ? file[bit - back][k % 2] : -1;
            if (other >= 0 && s->edged[other])
                cost_of(cost, 0.5, s->beside[other][own[inverse]], back == 1 ? sign : -sign);
        }
    }
}

// Infinite as soon as it is more than `most`.
static double cost_of_order(const Sight *s, const Order *o, const int *slots, const int *files, int count,
                            const int bits[2], double most) {
    int file[2 * FFP_GRAY_BITS_MAX][2];
    Cost cost = {o->ignore_plain ? 2 * IGNORED : 0, o->ignore_plain ? 2 : 0};
    double plain[2] = {0};
    memset(file, -1, sizeof file);
    for (int k = 0; k < count; k++) {
        if (files[k] < 0) continue;
        if (slots[k] >= 0) file[slots[k] / 2][slots[k] % 2] = files[k];
        if (slots[k] == BLACK || slots[k] == WHITE) plain[slots[k] == WHITE] = s->light[files[k]];
        if (slots[k] == CONSTANT || slots[k] == LIT_CONSTANT)
            cost_of(&cost, 1, s->light[files[k]], slots[k] == CONSTANT ? -1 : 1);
    }
    // Which of two side by side comes first, their light tells.
    for (int k = 0; k < 2 && o->plain != NOWHERE && !o->ignore_plain; k++) {
        const bool darker = plain[k] < plain[1 - k] || (plain[1 - k] == 0 && plain[k] < 0);
        if (plain[k] != 0) cost_of(&cost, 1, plain[k], (o->plain == AROUND ? k == 0 : darker) ? -1 : 1);
        // Apart from each other, a code could stand for either.
        if (o->plain == AROUND && plain[k] != 0 && (k ? 1 : -1) * plain[k] < PLAINLY) return INFINITY;
    }
    const double terms = cost.terms + TERMS * (bits[0] + bits[1]);
    for (int axis = 0; axis < 2; axis++)
        for (int bit = 0; bit < bits[axis]; bit++) {
            cost_of_code(&cost, s, (const int(*)[2])(file + (axis ? bits[0] : 0)), axis, bit, bits[axis]);
            if (cost.sum > most * terms) return INFINITY;
        }
    return cost.sum / fmax(cost.terms, 1);
}

typedef struct Best {
    double cost;
    Order order;
    Gaps gaps;
    int slots[FILES_MOST], files[FILES_MOST], count;
} Best;

static bool among(const int *numbers, int n, int number) {
    for (int i = 0; i < n; i++)
        if (numbers[i] == number) return true;
    return false;
}

// The files in an order's places, with gaps.
static void place(Best *b, int n) {
    const Gaps *g = &b->gaps;
    for (int k = 0, i = 0; k < b->count; k++) {
        while (among(g->at + g->n_lost, g->n_extra, i)) i++;
        b->files[k] = among(g->at, g->n_lost, k) || i >= n ? -1 : i++;
    }
}

static void try_gaps(const Sight *s, Best *b, const int bits[2], Best *best) {
    const Order *o = &b->order;
    const int gaps = b->gaps.n_lost + b->gaps.n_extra;
    place(b, s->n);
    b->cost = cost_of_order(s, o, b->slots, b->files, b->count, bits, best->cost) +
              ODD * (o->ignore_plain + o->equal_bits + o->alone + 2 * gaps);
    // More gaps must explain clearly more.
    const int more = gaps - best->gaps.n_lost - best->gaps.n_extra;
    if (b->cost < best->cost - fmax(1e-9, COST_OF_GAP * more)) *best = *b;
}

// All places of as many gaps.
static void try_order(const Sight *s, const Order *o, const int bits[2], int gaps, Best *best) {
    Best b = {.order = *o};
    b.count = list_slots(o, bits, b.slots);
    const int more = b.count - s->n; // lost - extra
    // Where black and white pass for a code, too, most numbers of photographs would do.
    const int most = o->plain == NOWHERE ? 1 : GAPS;
    if (b.count == 0 || gaps > most || abs(more) > gaps || (gaps - more) % 2 != 0) return;
    b.gaps.n_lost = (gaps + more) / 2, b.gaps.n_extra = gaps - b.gaps.n_lost;
    int ends[GAPS];
    for (int i = 0; i < GAPS; i++) {
        ends[i] = i < b.gaps.n_lost ? b.count : s->n;
        if (i >= gaps) ends[i] = 1;
    }
    for (int i = 0; i < ends[0]; i++)
        for (int k = gaps == GAPS && b.gaps.n_lost != 1 ? i + 1 : 0; k < ends[1]; k++) {
            b.gaps.at[0] = i, b.gaps.at[1] = k;
            try_gaps(s, &b, bits, best);
        }
}

static void try_orders(const Sight *s, const int bits[2], int others, bool alone, int gaps, Best *best) {
    for (int k = 0; k < 32 * INVERSES * PLAINS; k++) {
        const Order o = {.rows_first = k & 1,
                         .finest_first = k >> 1 & 1,
                         .inverse_first = k >> 2 & 1,
                         .equal_bits = k >> 3 & 1,
                         .ignore_plain = k >> 4 & 1,
                         .inverses = (Inverses)((k >> 5) % INVERSES),
                         .plain = (Plain)((k >> 5) / INVERSES),
                         .others = others,
                         .alone = alone};
        const bool twice = (o.equal_bits && bits[0] == bits[1]) || (o.ignore_plain && o.plain >= AROUND) ||
                           (o.inverse_first && o.inverses == WITHOUT);
        if (!twice && (others == 0 || o.plain == FIRST)) try_order(s, &o, bits, gaps, best);
    }
}

// An order that is sure needs no more gaps.
static void find(const Sight *s, const int bits[2], int others, Best *best) {
    *best = (Best){.cost = COST_MOST};
    for (int gaps = 0; gaps <= GAPS && best->cost > COST_SURE; gaps++) {
        try_orders(s, bits, 0, others > 0, gaps, best);
        if (others > 0) try_orders(s, bits, others, false, gaps, best);
    }
}

// --- And what it is called. ---

static void put_order(const Order *o, char text[200]) {
    static const char *const inverses[INVERSES] = {
        "", "all inverses after the patterns", "the inverses after the patterns of each side", "no inverses"};
    const char *const parts[] = {o->plain == LAST     ? "black and white last"
                                 : o->plain == AROUND ? "white last"
                                                      : "",
                                 o->plain == NOWHERE ? "no black and white" : "",
                                 o->rows_first ? "rows first" : "",
                                 o->finest_first ? "finest stripes first" : "",
                                 o->inverse_first ? "inverses first" : "",
                                 o->equal_bits ? "as many codes of rows as of columns" : "",
                                 inverses[o->inverses]};
    text[0] = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        const size_t used = strlen(text);
        if (parts[i][0]) snprintf(text + used, 200 - used, "%s%s", used > 0 ? ", " : "", parts[i]);
    }
}

static void describe(FfpGrayOrder *order, const Best *b, int width, const char *const *files) {
    const Gaps *g = &b->gaps;
    *order = (FfpGrayOrder){.first = files[0]};
    put_order(&b->order, order->text);
    for (int i = 0; i < g->n_extra; i++) order->extra[i] = files[g->at[g->n_lost + i]];
    for (int i = 0; i < g->n_lost; i++) {
        const int slot = g->at[i];
        FfpGrayLost *lost = &order->lost[order->n_lost];
        if (b->slots[slot] < 0) continue; // ffp_gray_find_plain says that black or white is
        int before = slot;
        while (before > 0 && b->files[before] < 0) before--;
        ffp_gray_code_name(width, b->slots[slot], lost->name);
        lost->after = b->files[before] >= 0, lost->beside = files[lost->after ? b->files[before] : 0];
        for (int k = 0; k < b->count; k++)
            lost->made = lost->made || (b->files[k] >= 0 && b->slots[k] == (b->slots[slot] ^ 1));
        order->n_lost++;
    }
}

void ffp_gray_tell_lost(const FfpGrayLost *lost) {
    char where[FFP_PATH_MAX + 16];
    snprintf(where, sizeof where, "%s '%s'", lost->after ? "after" : "before", lost->beside);
    ffp_tell(FFP_RULE_CODES_LOST,
             &(FfpFacts){.a = lost->name,
                         .b = where,
                         .c = lost->made ? "it is made from the other one of its pair"
                                         : "it and the finer ones of its side are left out"});
}

void ffp_gray_tell_order(const FfpGrayOrder *order) {
    if (order->text[0]) ffp_tell(FFP_RULE_CODES_SORTED, &(FfpFacts){.a = order->first, .b = order->text});
    for (int i = 0; i < FFP_GRAY_GAPS && order->extra[i]; i++)
        ffp_tell(FFP_RULE_CODES_EXTRA, &(FfpFacts){.a = order->extra[i]});
    for (int i = 0; i < order->n_lost; i++) ffp_gray_tell_lost(&order->lost[i]);
}

bool ffp_gray_find_order(FfpGrayPhotographs *photographs, FfpGrayOrder *order, const char *const *files,
                         int n, const char **codes) {
    const int bits[2] = {ffp_gray_code_bits(photographs->width), ffp_gray_code_bits(photographs->height)};
    Best best = {.cost = COST_MOST};
    if (n < 4 || n >= FILES_MOST || bits[0] > FFP_GRAY_BITS_MAX || bits[1] > FFP_GRAY_BITS_MAX) return false;
    Sight *s = ffp_alloc(1, sizeof *s);
    if (see(s, photographs, files, n)) find(s, bits, photographs->others, &best);
    const char *plain[2] = {NULL, NULL};
    double most[2] = {0, 0};
    for (int k = 0; k < best.count; k++) {
        const char *file = best.files[k] >= 0 ? files[best.files[k]] : NULL;
        if (best.slots[k] >= 0) codes[best.slots[k]] = file;
        if (!file || best.order.ignore_plain || (best.slots[k] != BLACK && best.slots[k] != WHITE)) continue;
        const double light = s->light[best.files[k]];
        const int which = light >= 0;
        if (fabs(light) >= most[which]) plain[which] = file, most[which] = fabs(light);
    }
    photographs->codes = codes, photographs->black = plain[0], photographs->white = plain[1];
    ffp_free(s);
    if (best.count > 0) describe(order, &best, photographs->width, files);
    return best.count > 0;
}
