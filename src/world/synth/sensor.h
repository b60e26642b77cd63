// Imperfections of real devices, added to the ideal pictures: FfpSensor of synth.h, all of it off by default.
#ifndef FFP_SYNTH_SENSOR_H
#define FFP_SYNTH_SENSOR_H

#include <jansson.h>
#include <stdint.h>
#include "core/base/rng.h"
#include "world/synth/synth.h"

// Within limits: nothing negative but exposure and gamma, nothing that is not finite.
bool ffp_sensor_check(const FfpSensor *sensor, FfpError *err);
// True if the projector sends out anything but its pattern's values.
bool ffp_sensor_changes_light(const FfpSensor *sensor);
// The projector's light for a pattern (linear, relative to white): gamma or power, black level, spread, then
// defocus. A new image.
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

// --- real_light.c ---

// Draws what real_light asks for and nothing else says, by the seed alone, and sets reaches and the focal
// plane that are needed and 0.
void ffp_sensor_settle(FfpSensor *sensor, uint64_t seed);
// True if the camera changes the light of its pictures.
bool ffp_sensor_has_lens(const FfpSensor *sensor);
// The camera's lens on a linear picture, in place: vignetting about its principal point, then glare.
void ffp_sensor_see(FfpImage *light, const FfpSensor *sensor, const FfpCamera *camera);
// The projector's spread on its light, in place.
void ffp_sensor_spread(FfpImage *light, const FfpSensor *sensor);
// The share of light that vignetting `fall` leaves at (u, v).
float ffp_sensor_vignette(float fall, const FfpCamera *device, float u, float v);
// The projector's deviation at depth z of its frame, where the focal plane is at `focus`, pixels of the
// panel.
float ffp_sensor_softness(const FfpSensor *sensor, int panel_width, float focus, float z);
// The truth of a settled sensor's real light for a file; NULL: none.
json_t *ffp_sensor_truth(const FfpSensor *sensor);

#endif
