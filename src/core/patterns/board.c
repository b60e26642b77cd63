// The chessboard on paper, at true size, as SVG and as PDF: rectangles, and a ruler to check the print with.
#include <math.h>
#include <stdio.h>
#include "core/base/file.h"
#include "core/patterns/patterns.h"

#define A4_WIDTH 297.0 // mm, on its side
#define A4_HEIGHT 210.0
#define POINT (25.4 / 72) // mm: PDF's unit (ISO 32000-1, 8.3.2.3)

enum { RULER = 12, BESIDE = 10 }; // mm: room for it below the board; least margin

// Millimetres from the upper left corner.
typedef struct Rectangle {
    double x, y, width, height;
} Rectangle;

typedef struct Paper {
    double width, height, x, y; // of the page; the board's corner
    int columns, rows;          // of squares
    double square, ruler;       // its length, whole centimetres
    char note[160];
} Paper;

// A4 where the board fits on it, otherwise as much as it needs with a square around it.
static Paper lay_out(int columns, int rows, double square) {
    Paper p = {.columns = columns + 1, .rows = rows + 1, .square = square};
    const double width = p.columns * square, height = p.rows * square;
    const bool fits = width + 2 * BESIDE <= A4_WIDTH && height + 2 * BESIDE + RULER <= A4_HEIGHT + 2;
    p.width = fits ? A4_WIDTH : width + 2 * fmax(square, BESIDE);
    p.height = fits ? A4_HEIGHT : height + 2 * fmax(square, BESIDE) + RULER;
    p.x = (p.width - width) / 2, p.y = (p.height - RULER - height) / 2;
    p.ruler = fmax(10, fmin(100, 10 * floor(width / 10)));
    snprintf(p.note, sizeof p.note,
             "%d x %d inner corners, squares of %.6g mm. Print at 100 %%, without fitting to the page: the "
             "ruler is %.0f mm long.",
             columns, rows, square, p.ruler);
    return p;
}

// Black squares, the first one in the corner; then the ruler's line and its centimetres. False: no more.
static bool rectangle(const Paper *p, int index, Rectangle *r) {
    const int squares = p->columns * p->rows;
    const double line = 0.25, below = p->y + p->rows * p->square + 5;
    if (index < squares) {
        const int column = index % p->columns, row = index / p->columns;
        const bool black = (column + row) % 2 == 0;
        *r = (Rectangle){p->x + column * p->square, p->y + row * p->square, black ? p->square : 0, p->square};
        return true;
    }
    const int mark = index - squares;
    if (mark == 0)
        *r = (Rectangle){p->x, below, p->ruler, line};
    else
        *r = (Rectangle){p->x + 10 * (mark - 1) - line / 2, below - 2, line, 2 + line};
    return 10 * (mark - 1) <= p->ruler;
}

static void write_svg(const Paper *p, FILE *f) {
    Rectangle r;
    fprintf(f,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.6gmm\" height=\"%.6gmm\" viewBox=\"0 0 %.6g "
            "%.6g\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n<path d=\"",
            p->width, p->height, p->width, p->height);
    for (int i = 0; rectangle(p, i, &r); i++)
        if (r.width > 0) fprintf(f, "M%.6g %.6gh%.6gv%.6gh%.6gz", r.x, r.y, r.width, r.height, -r.width);
    fprintf(
        f, "\"/>\n<text x=\"%.6g\" y=\"%.6g\" font-family=\"sans-serif\" font-size=\"3\">%s</text>\n</svg>\n",
        p->x, p->y + p->rows * p->square + 9.5, p->note);
}

static void draw_pdf(const Paper *p, FILE *f) {
    Rectangle r;
    fprintf(f, "%.9g 0 0 %.9g 0 %.9g cm\n", 1 / POINT, -1 / POINT, p->height / POINT); // mm, y down
    for (int i = 0; rectangle(p, i, &r); i++)
        if (r.width > 0) fprintf(f, "%.6g %.6g %.6g %.6g re\n", r.x, r.y, r.width, r.height);
    fprintf(f, "f\nBT /F 3 Tf 1 0 0 -1 %.6g %.6g Tm (%s) Tj ET\n", p->x, p->y + p->rows * p->square + 9.5,
            p->note);
}

// ISO 32000-1, 7.5: objects, where each begins, and where that table does.
static void write_pdf(const Paper *p, FILE *f) {
    long at[7] = {0};
    fputs("%PDF-1.4\n", f);
    at[1] = ftell(f);
    fputs("1 0 obj\n<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>\nendobj\n",
          f);
    at[2] = ftell(f);
    fputs("2 0 obj\n<< /Type /Pages /Kids [3 0 R] /Count 1 >>\nendobj\n", f);
    at[3] = ftell(f);
    fprintf(
        f,
        "3 0 obj\n<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.9g %.9g] /Contents 4 0 R\n   /Resources << "
        "/Font << /F 6 0 R >> >> >>\nendobj\n",
        p->width / POINT, p->height / POINT);
    at[4] = ftell(f);
    fputs("4 0 obj\n<< /Length 5 0 R >>\nstream\n", f);
    const long begin = ftell(f);
    draw_pdf(p, f);
    const long end = ftell(f);
    fputs("endstream\nendobj\n", f);
    at[5] = ftell(f);
    fprintf(f, "5 0 obj\n%ld\nendobj\n", end - begin);
    at[6] = ftell(f);
    fputs("6 0 obj\n<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>\nendobj\n", f);
    const long table = ftell(f);
    fputs("xref\n0 7\n0000000000 65535 f \n", f);
    for (int i = 1; i < 7; i++) fprintf(f, "%010ld 00000 n \n", at[i]);
    fprintf(f, "trailer\n<< /Size 7 /Root 1 0 R >>\nstartxref\n%ld\n%%%%EOF\n", table);
}

static bool write_one(const Paper *paper, const char *folder, const char *name,
                      void (*write)(const Paper *, FILE *), FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpOutput out;
    if (!ffp_join_path(path, folder, name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
    if (!ffp_output_open(&out, path, err)) return false;
    write(paper, out.stream);
    const bool ok = ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}

bool ffp_board_write(const char *folder, int columns, int rows, double square, FfpError *err) {
    const Paper paper = lay_out(columns, rows, square);
    return write_one(&paper, folder, "chessboard.svg", write_svg, err) &&
           write_one(&paper, folder, "chessboard.pdf", write_pdf, err);
}
