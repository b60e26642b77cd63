#include "world/synth/stroke.h"
#include <ctype.h>
#include <math.h>
#include <string.h>
#include "world/shapes/scalar.h"

// The font: polylines on a grid of 5 x 7 points. Two digits are a point, column 0..4 and row 0..6 from the
// top (7: below the line); a space lifts the pen.
static const char *glyph(char letter) {
    static const char *const capitals[26] = {"0602204246 0444",
                                             "003041423303 3344453606 0006",
                                             "4130100105163645",
                                             "00304145360600",
                                             "40000646 0333",
                                             "400006 0333",
                                             "41301001051636454323",
                                             "0006 4046 0343",
                                             "1030 2026 1636",
                                             "4045361605",
                                             "0006 400346",
                                             "000646",
                                             "0600234046",
                                             "06004640",
                                             "103041453616050110",
                                             "06003041423303",
                                             "103041453616050110 2446",
                                             "06003041423303 2346",
                                             "413010010213334445361605",
                                             "0040 2026",
                                             "000516364540",
                                             "002640",
                                             "0016233640",
                                             "0046 0640",
                                             "002340 2326",
                                             "00400646"};
    static const char *const digits[10] = {
        "103041453616050110 1432",     "112026 1636", "01103041420646",
        "01103041423313 334445361605", "36300444",    "400002324345361605",
        "413010010516364544331304",    "004016",      "103041423313020110 1304051636454433",
        "051636454130100102133342"};
    static const char marks[] = ".,-_:/!?+";
    static const char *const strokes[] = {
        "2526", "2617", "1333", "0646", "2122 2425", "0640", "2024 2526", "01103041422324 2526", "2125 0343"};
    if (letter >= '0' && letter <= '9') return digits[letter - '0'];
    const int capital = toupper((unsigned char)letter);
    if (capital >= 'A' && capital <= 'Z') return capitals[capital - 'A'];
    const char *mark = letter ? strchr(marks, letter) : NULL;
    return mark ? strokes[mark - marks] : "";
}

// Covers every pixel whose centre is within `reach` of the line from a to b; half a pixel of soft edge.
static void cover(const FfpPen *pen, const float a[2], const float b[2], float reach) {
    FfpImage *image = pen->image;
    const float pad = reach + 1, d[2] = {b[0] - a[0], b[1] - a[1]};
    const float square = ffp_max(d[0] * d[0] + d[1] * d[1], 1e-9F);
    const int left = (int)ffp_max(0, ffp_min(a[0], b[0]) - pad),
              top = (int)ffp_max(0, ffp_min(a[1], b[1]) - pad);
    const int right = (int)ffp_min((float)image->width, ffp_max(0, ffp_max(a[0], b[0]) + pad));
    const int bottom = (int)ffp_min((float)image->height, ffp_max(0, ffp_max(a[1], b[1]) + pad));
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            const float px = (float)x + 0.5F - a[0], py = (float)y + 0.5F - a[1];
            const float t = ffp_min(1, ffp_max(0, (px * d[0] + py * d[1]) / square));
            const real ink =
                (real)ffp_min(1, ffp_max(0, reach + 0.5F - hypotf(px - t * d[0], py - t * d[1])));
            real *p = image->data + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
            for (int c = 0; c < image->channels && c < 3 && ink > 0; c++)
                p[c] += ink * (pen->colour[c] - p[c]);
        }
}

void ffp_stroke_line(const FfpPen *pen, const float a[2], const float b[2]) {
    cover(pen, a, b, 0.5F * pen->width);
}

void ffp_stroke_disc(const FfpPen *pen, const float centre[2], float radius) {
    cover(pen, centre, centre, radius);
}

static const float ADVANCE = 6.0F / 6; // from letter to letter, in capital heights

float ffp_stroke_length(float height, const char *text) {
    return ADVANCE * height * (float)strlen(text);
}

static void draw_glyph(const FfpPen *pen, const float at[2], float unit, float angle, const char *points) {
    const float c = unit * cosf(angle), s = unit * sinf(angle);
    bool down = false;
    float last[2] = {0, 0};
    for (; *points; points++) {
        if (*points == ' ') {
            down = false;
            continue;
        }
        const float x = (float)(points[0] - '0'), y = (float)(points[1] - '0');
        const float here[2] = {at[0] + c * x - s * y, at[1] + s * x + c * y};
        if (down) ffp_stroke_line(pen, last, here);
        last[0] = here[0], last[1] = here[1];
        down = true;
        points++;
    }
}

float ffp_stroke_text(const FfpPen *pen, const float at[2], float height, float angle, const char *text) {
    for (size_t i = 0; text[i]; i++) {
        const float ahead = ADVANCE * height * (float)i;
        const float start[2] = {at[0] + ahead * cosf(angle), at[1] + ahead * sinf(angle)};
        draw_glyph(pen, start, height / 6, angle, glyph(text[i]));
    }
    return ffp_stroke_length(height, text);
}
