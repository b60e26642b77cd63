#include "core/capture/small.h"
#include <math.h>
#include "core/capture/reduce.h"

#define SIDE_MAX 176 // pixels

FfpCapture ffp_small_new(const FfpCapture *capture, int active) {
    const FfpCamera *camera = &capture->views[0].camera;
    const double shrink = fmin(1, (double)SIDE_MAX / fmax(camera->width, camera->height));
    const int width = (int)fmax(8, round(camera->width * shrink)),
              height = (int)fmax(8, round(camera->height * shrink));
    const int kept[3] = {capture->black, capture->white, active};
    return ffp_capture_reduced(capture, capture->n_views, kept, 3, width, height);
}
