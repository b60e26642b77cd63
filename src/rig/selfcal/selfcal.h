// A calibration without a board: from what a camera sees of the codes, at several places or of a turntable.
#ifndef FFP_SELFCAL_SELFCAL_H
#define FFP_SELFCAL_SELFCAL_H

#include "core/base/error.h"
#include "ffprocams.h" // options and results, types alone (engine/pipeline/reconstruct.h says why)
#include "rig/selfcal/bundle.h"
#include "rig/selfcal/turning.h"

// The work of ffp_self_calibrate (ffprocams/rig.h). `stats` may be NULL.
bool ffp_self_calibration_run(const FfpSelfCalibration *options, FfpSelfCalibrationStats *stats,
                              FfpError *err);

// Reads the photographs of all places. A place whose photographs cannot be used gets a problem; errors: of
// all places, or of what was shown.
bool ffp_places_read(const FfpSelfCalibration *options, FfpTracks *tracks, FfpError *err);

// All devices of a bundle that has its tracks, told and judged. Errors: ffp_bundle_start's; fewer than two
// places are left; a focal length that they do not tell.
bool ffp_self_calibration_fit(FfpBundle *bundle, FfpError *err);

// All of a turntable that has its tracks and angles, judged likewise. Errors: those of ffp_turning_start,
// fewer than three sound stops, angles or numbers that the photographs do not tell.
bool ffp_self_calibration_turn(FfpTurning *turning, FfpError *err);
// The work of ffp_self_calibrate for a turntable whose tracks are read.
bool ffp_self_calibration_turntable(const FfpSelfCalibration *options, FfpTracks *tracks,
                                    FfpSelfCalibrationStats *stats, FfpError *err);

enum { FFP_FOCAL_35MM_LEAST = 5, FFP_FOCAL_35MM_MOST = 2000 };
// The focal length by the lens of photographs of this size: the one that is given or, if that is 0, the one
// that their files tell, with a note.
FfpKnownFocal ffp_known_focal(double focal_35mm, const FfpTracks *tracks);
// True if a focal length that was found contradicts the one that was known. Where the fit kept to that one,
// try again without it, and report it by ffp_tell_known_focal if the photographs alone, with their deviation,
// contradict it too; where they hardly tell, the known one is right.
bool ffp_focal_contradicts(const FfpKnownFocal *known, double found, double deviation);
void ffp_tell_known_focal(const FfpKnownFocal *known, double found);
// Tells by a rule if errors are shared by neighbours, as noise is not: something moved, or a lens or shutter
// is not as it is modelled.
void ffp_tell_misfit(double rms, double noise, int rule);
// Tells of a fit that ended before it settled.
void ffp_tell_end(FfpFitEnd end);
// True if the projector's pixels, whose aspect and skew were free, are certain not to be square.
bool ffp_panel_unsquare(const double optics[FFP_BUNDLE_OPTICS], const double *deviation);
// Tells of such a panel that is stretched; false, with an error, where its picture is corrected for keystone,
// which no calibration of a lens describes.
bool ffp_judge_panel(const double optics[FFP_BUNDLE_OPTICS], const double *deviation, FfpError *err);
// Refuses a focal length whose logarithm deviates too much. `doubt`: the rule of one that is nearly certain
// enough.
bool ffp_judge_focal(double deviation, const char *device, int doubt, FfpError *err);

// COLMAP's text model in a new folder: cameras.txt (RADIAL), images.txt with a picture for each known place
// and calib.jpg, which is the projector, and points3D.txt. The world is the first known place's camera; every
// length is times `scale`.
bool ffp_self_calibration_write(const FfpBundle *bundle, double scale, const char *folder, FfpError *err);

#endif
