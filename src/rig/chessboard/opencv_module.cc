// No exception leaves this file, and no call of the library is left from inside it, since it takes no memory
// of theirs.
#include "rig/chessboard/opencv_module.h"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <new>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace {

const int REFINE_MOST = 11;   // half a side of the window that a corner is refined in, pixels
const int SEARCH_MOST = 1600; // longest side of the picture that a board is looked for in
const cv::TermCriteria fine(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);

int quiet(int, const char *, const char *, const char *, int, void *) {
    return 0;
}

FfpCvOutcome failed(FfpCvMessage *message, const char *what, const char *why) {
    std::snprintf(message->text, sizeof message->text, "%s: %s", what, why);
    return FFP_CV_FAILED;
}

FfpCvOutcome no_memory(FfpCvMessage *message, const char *what) {
    std::snprintf(message->text, sizeof message->text, "%s", what);
    return FFP_CV_NO_MEMORY;
}

// Does the work; what OpenCV throws becomes a message, and is not printed.
template <class Work> FfpCvOutcome guarded(const char *what, FfpCvMessage *message, const Work &work) {
    const cv::ErrorCallback before = cv::redirectError(quiet);
    FfpCvOutcome outcome = FFP_CV_DONE;
    try {
        work();
    } catch (const std::bad_alloc &) {
        outcome = no_memory(message, what);
    } catch (const cv::Exception &e) {
        outcome =
            e.code == cv::Error::StsNoMem ? no_memory(message, what) : failed(message, what, e.err.c_str());
    } catch (const std::exception &e) {
        outcome = failed(message, what, e.what());
    }
    cv::redirectError(before);
    return outcome;
}

// Least distance between neighbours along rows and columns.
double spacing(const std::vector<cv::Point2f> &corners, int columns, int rows) {
    double least = INFINITY;
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            const cv::Point2f &here = corners[(size_t)(y * columns + x)];
            if (x > 0) least = std::min(least, cv::norm(here - corners[(size_t)(y * columns + x - 1)]));
            if (y > 0) least = std::min(least, cv::norm(here - corners[(size_t)((y - 1) * columns + x)]));
        }
    return least;
}

// Looks in a smaller picture where this one is large: the search is slow there, and finds less.
bool search(const cv::Mat &picture, int columns, int rows, std::vector<cv::Point2f> &corners) {
    const float scale = std::max(1.F, (float)std::max(picture.cols, picture.rows) / (float)SEARCH_MOST);
    cv::Mat smaller = picture;
    if (scale > 1) cv::resize(picture, smaller, cv::Size(), 1 / scale, 1 / scale, cv::INTER_AREA);
    const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FILTER_QUADS;
    if (!cv::findChessboardCorners(smaller, cv::Size(columns, rows), corners, flags)) return false;
    for (cv::Point2f &c : corners) c = scale * (c + cv::Point2f(0.5F, 0.5F)) - cv::Point2f(0.5F, 0.5F);
    return true;
}

typedef std::vector<std::vector<cv::Point3f>> Boards;
typedef std::vector<std::vector<cv::Point2f>> Pictures;

Boards boards_of(const FfpCvViews *views) {
    Boards out((size_t)views->n);
    const double *at = views->board;
    for (int i = 0; i < views->n; i++)
        for (int k = 0; k < views->counts[i]; k++, at += 3)
            out[(size_t)i].emplace_back((float)at[0], (float)at[1], (float)at[2]);
    return out;
}

Pictures pictures_of(const FfpCvViews *views, const double *at) {
    Pictures out((size_t)views->n);
    for (int i = 0; i < views->n; i++)
        for (int k = 0; k < views->counts[i]; k++, at += 2)
            out[(size_t)i].emplace_back((float)at[0], (float)at[1]);
    return out;
}

int flags_of(unsigned fixed) {
    int flags = 0;
    if (fixed & FFP_CV_FIX_K1) flags |= cv::CALIB_FIX_K1;
    if (fixed & FFP_CV_FIX_K2) flags |= cv::CALIB_FIX_K2;
    if (fixed & FFP_CV_FIX_K3) flags |= cv::CALIB_FIX_K3;
    if (fixed & FFP_CV_FIX_TANGENTIAL) flags |= cv::CALIB_ZERO_TANGENT_DIST;
    if (fixed & FFP_CV_FIX_CENTRE) flags |= cv::CALIB_FIX_PRINCIPAL_POINT;
    if (fixed & FFP_CV_FIX_ASPECT) flags |= cv::CALIB_FIX_ASPECT_RATIO;
    return flags;
}

cv::Mat matrix_of(const FfpCvDevice *device) {
    return cv::Mat(3, 3, CV_64F, const_cast<double *>(device->matrix)).clone();
}

cv::Mat lens_of(const FfpCvDevice *device) {
    return cv::Mat(1, 5, CV_64F, const_cast<double *>(device->lens)).clone();
}

void store(const cv::Mat &from, double *to, int n) {
    const cv::Mat flat = from.reshape(1, 1);
    for (int i = 0; i < n && i < flat.cols; i++) to[i] = flat.at<double>(i);
}

FfpCvOutcome chessboard(const unsigned char *grey, int width, int height, int columns, int rows,
                        double *corners, bool *found, FfpCvMessage *message) {
    *found = false;
    return guarded("looking for a chessboard", message, [&] {
        const cv::Mat picture(height, width, CV_8U, const_cast<unsigned char *>(grey));
        std::vector<cv::Point2f> points;
        if (!search(picture, columns, rows, points) || (int)points.size() != columns * rows) return;
        const int half = std::min(REFINE_MOST, std::max(2, (int)(0.4 * spacing(points, columns, rows))));
        cv::cornerSubPix(picture, points, cv::Size(half, half), cv::Size(-1, -1),
                         cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-3));
        for (size_t i = 0; i < points.size(); i++) {
            corners[2 * i] = (double)points[i].x;
            corners[2 * i + 1] = (double)points[i].y;
        }
        *found = true;
    });
}

FfpCvOutcome homography(const double *from, const double *to, int n, double tolerance, double h[9],
                        unsigned char *inside, bool *found, FfpCvMessage *message) {
    *found = false;
    return guarded("fitting a homography", message, [&] {
        if (n < 4) return;
        const cv::Mat a(n, 1, CV_64FC2, const_cast<double *>(from)),
            b(n, 1, CV_64FC2, const_cast<double *>(to));
        cv::Mat mask;
        const cv::Mat fit = cv::findHomography(a, b, cv::RANSAC, tolerance, mask);
        if (fit.empty()) return;
        store(fit, h, 9);
        for (int i = 0; i < n; i++) inside[i] = mask.at<unsigned char>(i);
        *found = true;
    });
}

FfpCvOutcome calibrate(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                       FfpCvMessage *message) {
    return guarded("fitting a device", message, [&] {
        cv::Mat matrix = cv::Mat::eye(3, 3, CV_64F),
                lens = cv::Mat::zeros(1, 5, CV_64F); // fixed terms stay so
        cv::Mat deviations, poses_deviations, errors;
        std::vector<cv::Mat> turns, shifts;
        device->rms = cv::calibrateCamera(
            boards_of(views), pictures_of(views, views->first), cv::Size(device->width, device->height),
            matrix, lens, turns, shifts, deviations, poses_deviations, errors, flags_of(fixed), fine);
        store(matrix, device->matrix, 9);
        store(lens, device->lens, 5);
        store(deviations, device->deviation, 9);
        for (size_t i = 0; i < turns.size(); i++) {
            store(turns[i], poses + 6 * i, 3);
            store(shifts[i], poses + 6 * i + 3, 3);
        }
    });
}

FfpCvOutcome fit_pair(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second,
                      double r[9], double t[3], double *rms, double *whole, FfpCvMessage *message) {
    return guarded("fitting the projector's pose", message, [&] {
        cv::Mat m[2] = {matrix_of(first), matrix_of(second)}, lens[2] = {lens_of(first), lens_of(second)};
        cv::Mat rotation, translation, essential, fundamental, errors;
        *whole = cv::stereoCalibrate(boards_of(views), pictures_of(views, views->first),
                                     pictures_of(views, views->second), m[0], lens[0], m[1], lens[1],
                                     cv::Size(first->width, first->height), rotation, translation, essential,
                                     fundamental, errors, cv::CALIB_FIX_INTRINSIC, fine);
        store(rotation, r, 9);
        store(translation, t, 3);
        store(errors, rms, 2 * views->n);
    });
}

// OpenCV's rotation matrices and vectors, and our arrays.
void store_motion(const cv::Mat &rotation, const cv::Mat &translation, double r[9], double t[3]) {
    store(rotation, r, 9);
    store(translation, t, 3);
}

FfpCvOutcome relative(const double *first, const double *second, int n, double tolerance, double r[9],
                      double t[3], unsigned char *inside, bool *found, FfpCvMessage *message) {
    *found = false;
    return guarded("finding how two places of the camera lie", message, [&] {
        if (n < 8) return;
        const cv::Mat a(n, 1, CV_64FC2, const_cast<double *>(first)),
            b(n, 1, CV_64FC2, const_cast<double *>(second)), unit = cv::Mat::eye(3, 3, CV_64F);
        cv::Mat mask, rotation, translation;
        const cv::Mat essential = cv::findEssentialMat(a, b, unit, cv::RANSAC, 0.9999, tolerance, mask);
        if (essential.rows != 3 || essential.cols != 3) return;
        if (cv::recoverPose(essential, a, b, unit, rotation, translation, mask) < 8) return;
        store_motion(rotation, translation, r, t);
        for (int i = 0; i < n; i++) inside[i] = mask.at<unsigned char>(i) != 0;
        *found = true;
    });
}

FfpCvOutcome pose(const double *points, const double *rays, int n, double tolerance, double r[9], double t[3],
                  unsigned char *inside, bool *found, FfpCvMessage *message) {
    *found = false;
    return guarded("finding a place of the camera", message, [&] {
        if (n < 6) return;
        const cv::Mat world(n, 1, CV_64FC3, const_cast<double *>(points)),
            seen(n, 1, CV_64FC2, const_cast<double *>(rays)), unit = cv::Mat::eye(3, 3, CV_64F);
        cv::Mat turn, translation, rotation;
        std::vector<int> kept;
        if (!cv::solvePnPRansac(world, seen, unit, cv::noArray(), turn, translation, false, 300,
                                (float)tolerance, 0.999, kept))
            return;
        cv::Rodrigues(turn, rotation);
        store_motion(rotation, translation, r, t);
        std::fill(inside, inside + n, (unsigned char)0);
        for (const int i : kept) inside[i] = 1;
        *found = true;
    });
}

} // namespace

const FfpCvModule ffp_opencv_module = {
    FFP_CV_MODULE_VERSION, chessboard, homography, calibrate, fit_pair, relative, pose};
