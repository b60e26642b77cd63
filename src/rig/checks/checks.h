// Checks for faults of a capture: what measure.h measures is judged by the rules of the findings. faults.c
// has what calls refuse, checks.c the page of `info`, hypotheses.h the mistakes that are tried.
#ifndef FFP_RIG_CHECKS_H
#define FFP_RIG_CHECKS_H

#include "core/capture/capture.h"
#include "rig/findings/tell.h"

// Checks whether a capture can be reconstructed well: where the projector's frustum lies, exposure and
// clipping, ambient light, how far the rig is from what the shipped model was trained on, silhouettes, how
// well looking up the pattern explains the pictures, and what moved. Adds a finding for each, ok or in doubt.
// `taken` has the size of the photographs, of which the capture may hold reduced ones.
void ffp_rig_checks(FfpFindings *found, const FfpCapture *capture, const FfpCamera *taken);

// The mistakes that make a reconstruction wrong. Looks at devices (behind or inside the object, in another
// unit or with other axes), at brightness (photographs exchanged or taken twice, a dark projector, an
// inverted mask), at silhouettes that contradict the others', and at how well structured light explains the
// photographs. People's mistakes are tried (hypotheses.h). Adds a fault, with its view and remedy, where one
// of these explains what is wrong, and returns false; what is doubtful but unexplained, and what only makes
// the result worse, is added as notes.
bool ffp_rig_faults(FfpFindings *found, const FfpCapture *capture);
// Both: faults first, and each thing once.
void ffp_rig_look(FfpFindings *found, const FfpCapture *capture, const FfpCamera *taken);
// Faults before the work of a call, whose caller is told of notes. Fails with FFP_ERROR_FAULT.
bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err);

#endif
