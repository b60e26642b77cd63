// Lens distortion, and pictures without it.
#ifndef FFP_RIG_LENS_H
#define FFP_RIG_LENS_H

#include "core/base/lens.h"
#include "ffprocams.h" // FfpCalibratedAt
#include "rig/optics/calibration.h"

// The device's pixels at the size its pictures have. `what` ("camera", "projector") is for errors; `path` is
// a picture of that size.
bool ffp_optics_settle(FfpOptics *optics, const FfpCalibratedAt *at, int width, int height, const char *what,
                       const char *path, FfpError *err);
// The pinhole camera that shows the same field at `width` pixels (0: as many as before). Pose not touched.
void ffp_optics_pinhole(const FfpOptics *optics, int width, FfpCamera *pinhole);
// Widens the pinhole's frame, at the same focal lengths, to hold all that the optics' picture shows, as far
// as a quarter of a side beyond it, and `border` pixels around that.
void ffp_optics_frame_all(const FfpOptics *optics, int border, FfpCamera *pinhole);
// The largest whole number up to `most`, or 1, that divides both sides of the optics' pictures; and the
// optics of pictures that have one pixel for so many, a side.
int ffp_optics_shrink_by(const FfpOptics *optics, double most);
FfpOptics ffp_optics_shrunk(const FfpOptics *optics, int shrink);
// The picture as the pinhole would have seen it: for each of its pixels the mean of n x n bilinear samples,
// n being how many old pixels a new one spans. Taken on the values given, which should be linear radiance:
// what a pixel's area receives adds up. Black beyond the old picture. A pinhole that changes nothing copies.
FfpImage ffp_optics_rectify(const FfpOptics *optics, const FfpCamera *pinhole, const FfpImage *image);
// The way back, for masks: the pinhole's picture as the optics would have seen it, one bilinear sample a
// pixel; 0 beyond the pinhole's picture.
FfpImage ffp_optics_distort(const FfpOptics *optics, const FfpCamera *pinhole, const FfpImage *image);

#endif
