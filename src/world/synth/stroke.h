// Lines and letters drawn into an image with soft edges: patterns with writing on them, and labels.
#ifndef FFP_SYNTH_STROKE_H
#define FFP_SYNTH_STROKE_H

#include "core/image/image.h"

typedef struct FfpPen {
    FfpImage *image;
    float width;    // pixels, 1 or more
    real colour[3]; // as many as the image has channels; not above 3
} FfpPen;

// A line with round ends, from a to b in pixels; what lies outside the image is left out.
void ffp_stroke_line(const FfpPen *pen, const float a[2], const float b[2]);
// A closed disc.
void ffp_stroke_disc(const FfpPen *pen, const float centre[2], float radius);
// Capital letters, digits and . , - _ : / ! ? + in single strokes (small letters become capitals, anything
// else a gap). `at` is the upper left corner, `height` that of a capital, `angle` turns the line (radians,
// clockwise on the screen). Returns the length of the written line.
float ffp_stroke_text(const FfpPen *pen, const float at[2], float height, float angle, const char *text);
float ffp_stroke_length(float height, const char *text);

#endif
