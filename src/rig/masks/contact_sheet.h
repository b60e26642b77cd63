// All masks of an import in one picture, to be looked at.
#ifndef FFP_RIG_CONTACT_SHEET_H
#define FFP_RIG_CONTACT_SHEET_H

#include "core/capture/capture.h"

// A small copy of a linear photograph, at most 240 pixels wide.
FfpImage ffp_contact_thumb(const FfpImage *photograph);
// One view, encoded for a PNG: what is not the object is dark and blue, and a red line goes round it.
FfpImage ffp_contact_picture(const FfpImage *thumb, const FfpImage *coverage);
// thumbs [n_views], in rows and in the views' order.
FfpImage ffp_contact_sheet(const FfpCapture *capture, const FfpImage *thumbs);

#endif
