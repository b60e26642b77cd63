// One self-contained HTML page: input, G-buffers, predictions beside the truth, figures and times.
#ifndef FFP_EVAL_REPORT_H
#define FFP_EVAL_REPORT_H

#include "core/capture/capture.h"
#include "engine/render/render.h"
#include "ffprocams.h"

typedef struct FfpReport FfpReport;

// `predictor`: the name of the predictor, for the heading.
FfpReport *ffp_report_new(const char *predictor);
void ffp_report_free(FfpReport *report);

// Sections appear in the order of the calls. Pictures are reduced to a size suitable for a page.
void ffp_report_title(FfpReport *report, const char *title); // of a capture's sections
// A picture as large as the page allows; several are side by side if there is room.
void ffp_report_large(FfpReport *report, const FfpImage *encoded, const char *caption);
// The n photographs given (indices into the capture's patterns) of the first views.
void ffp_report_input(FfpReport *report, const FfpCapture *capture, const int *given, int n);
void ffp_report_stats(FfpReport *report, const FfpReconstructionStats *stats);
void ffp_report_maps(FfpReport *report, const char *view, const FfpGbuffer *gbuffer);
void ffp_report_heading(FfpReport *report, const char *title, const char *explanation);
void ffp_report_prediction(FfpReport *report, const char *view, const char *pattern, const FfpImage *truth,
                           const FfpImage *prediction, double psnr);
void ffp_report_picture(FfpReport *report, const FfpImage *encoded, const char *caption);

// The page: the sections, then the table of scores. `viewer`: a page to link to at the top, or NULL.
bool ffp_report_write(FfpReport *report, const FfpScore *scores, int n_scores, const char *viewer,
                      const char *path, FfpError *err);

#endif
