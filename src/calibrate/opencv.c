// Loads the module with OpenCV's part (opencv_module.h) when it is first wanted.
#include <dlfcn.h>
#include <omp.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "base/alloc.h"
#include "base/file.h"
#include "calibrate/opencv_module.h"

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const FfpCvModule *module; // NULL: there is none
static char reason[256];          // why not, where the file is there

static void load_from(const char *path) {
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const FfpCvModule *(*get)(void) = NULL;
    if (!handle) {
        const char *why = dlerror();
        if (strchr(path, '/') && !reason[0] && access(path, F_OK) == 0)
            snprintf(reason, sizeof reason, "%s", why ? why : "no reason is given");
        return;
    }
    *(void **)&get = dlsym(handle, FFP_CV_MODULE_SYMBOL); // POSIX's own way to a function
    const FfpCvModule *found = get ? get() : NULL;
    if (found && found->version == FFP_CV_MODULE_VERSION) {
        module = found; // stays loaded
        return;
    }
    dlclose(handle);
}

// Beside the library or the program, or in the lib folder of the program's prefix; else where the system
// looks.
static void load(void) {
    static const char *const places[] = {FFP_CV_MODULE, "../lib/" FFP_CV_MODULE};
    char folder[FFP_PATH_MAX], path[FFP_PATH_MAX];
    const bool known = ffp_own_folder(folder);
    for (size_t i = 0; known && !module && i < sizeof places / sizeof *places; i++)
        if (ffp_join_path(path, folder, places[i])) load_from(path);
    if (!module) load_from(FFP_CV_MODULE);
}

bool ffp_cv_there(FfpError *err) {
    pthread_once(&once, load);
    if (!module && reason[0])
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, FFP_CV_MODULE,
                        "calibrations are fitted by OpenCV, which cannot be loaded: %s", reason);
    return module ||
           ffp_fail(
               err, FFP_ERROR_UNSUPPORTED, FFP_CV_MODULE,
               "calibrations are fitted by OpenCV, and the part of this program that uses it is not there: "
               "install OpenCV (Debian's libopencv-calib3d-dev), then configure and build again");
}

// One thread: OpenCV's fits solve thousands of small systems by LAPACK, whose threads would wait for each
// other.
static int begin_alone(void) {
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    return threads;
}

static bool end_alone(int threads, FfpCvOutcome outcome, const FfpCvMessage *message, FfpError *err) {
    omp_set_num_threads(threads);
    if (outcome == FFP_CV_NO_MEMORY)
        return ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory while %s", message->text);
    return outcome == FFP_CV_DONE ||
           ffp_fail(err, FFP_ERROR_FILE, NULL, "OpenCV failed while %s", message->text);
}

bool ffp_cv_chessboard(const unsigned char *grey, int width, int height, int columns, int rows,
                       double *corners, bool *found, FfpError *err) {
    FfpCvMessage m;
    if (!ffp_cv_there(err)) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->chessboard(grey, width, height, columns, rows, corners, found, &m), &m,
                     err);
}

bool ffp_cv_homography(const double *from, const double *to, int n, double tolerance, double h[9],
                       unsigned char *inside, bool *found, FfpError *err) {
    FfpCvMessage m;
    if (!ffp_cv_there(err)) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->homography(from, to, n, tolerance, h, inside, found, &m), &m, err);
}

bool ffp_cv_calibrate(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                      FfpError *err) {
    FfpCvMessage m;
    if (!ffp_cv_there(err)) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->calibrate(views, fixed, device, poses, &m), &m, err);
}

bool ffp_cv_pair(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second, double r[9],
                 double t[3], double *rms, double *whole, FfpError *err) {
    FfpCvMessage m;
    if (!ffp_cv_there(err)) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->pair(views, first, second, r, t, rms, whole, &m), &m, err);
}
