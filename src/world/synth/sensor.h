// Imperfections of real devices, added to the ideal pictures: FfpSensor of synth.h, all of it off by default.
#ifndef FFP_SYNTH_SENSOR_H
#define FFP_SYNTH_SENSOR_H

#include <stdint.h>
#include "core/base/rng.h"
#include "world/synth/synth.h"

// Within limits: nothing negative but exposure and gamma, nothing that is not finite.
bool ffp_sensor_check(const FfpSensor *sensor, FfpError *err);
// True if the projector sends out anything but its pattern's values.
bool ffp_sensor_changes_light(const FfpSensor *sensor);
// The projector's light for a pattern (linear, relative to white): gamma, black level, then defocus. A new
// image.
FfpImage ffp_sensor_emit(const FfpImage *pattern, const FfpSensor *sensor);
// The same for a picture's file over black. Errors: reading it.
bool ffp_sensor_emit_file(FfpImage *emitted, const char *path, const FfpSensor *sensor, FfpError *err);
// A linear pixel value with the noise of its shot (variance shot * value) and of reading (deviation read);
// two keys that name the pixel and the picture. The value itself where both are 0.
float ffp_sensor_noise(float value, float shot, float read, uint32_t pixel, uint32_t picture);
// The noise on every value of a linear picture, in place; `picture` keys it.
void ffp_sensor_expose(FfpImage *light, const FfpSensor *sensor, uint32_t picture);
// Moves a device's written pose: deviations of its turn (radians) and its place (world units), each axis by
// itself.
void ffp_sensor_misplace(FfpCamera *device, float turn, float shift, FfpRng *rng);

#endif
