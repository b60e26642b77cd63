// The view of the panel at each place: one projector that stands still shows its codes, and the camera
// decodes them where it walks, or at each stop of a turntable that stands still too.
#ifndef FFP_SELFCAL_PLACES_H
#define FFP_SELFCAL_PLACES_H

#include <stdbool.h>
#include "core/base/error.h"
#include "core/image/image.h"

enum { FFP_PLACES_MAX = 64 };

typedef struct FfpCameraPlace {
    char name[256];      // of its folder
    char problem[768];   // why it is left out; "": it is not
    const char *finding; // the code of the finding behind it; NULL: there is none
    int seen;            // tracks that it sees
    double focal_35mm;   // of the camera, mm, as its files tell it; 0: not
} FfpCameraPlace;

// A spot of the panel, and where each place sees it. Pixel centres lie at integers + 0.5.
typedef struct FfpTrack {
    double panel[2];
    int first, n; // its sightings
    float light;  // of the surface there under white, 0 to 1
} FfpTrack;

typedef struct FfpSighting {
    int place;
    bool used; // false: out of line
    double at[2];
    double slope[4]; // x over the panel's x and y, then y: how `at` moves with the spot
    float light;     // of the surface there under white, 0 to 1
} FfpSighting;

typedef struct FfpTracks {
    int width, height, panel_width, panel_height; // of all photographs, and of the panel
    double focal_35mm;                            // that of most places, mm, as their files tell it; 0: not
    int n_places, n, n_sightings;
    FfpCameraPlace *places; // [n_places]
    FfpTrack *tracks;       // [n]
    FfpSighting *sightings; // [n_sightings], those of a track one behind the other
    int columns, rows;      // of the grid over the panel
    double pitch;           // of the grid, panel pixels
    int *grid;              // [rows, columns] the track of each spot; -1: none
} FfpTracks;

// Spots on a grid over the panel, a few thousand at most, seen by as many places as decode them: each by a
// plane, position in the picture over position on the panel, through all pixels near the spot, so that
// rounding and noise average out and edges of surfaces have none.
//
// maps [n_places]: of ffp_gray_decode_view, [h,w,3], each pixel `shrink` of the photograph's; empty: not
// decoded. whites [n_places]: as the surface looks under white, [h,w,1]. step: median distance of
// neighbouring pixels' positions, panel pixels. Sets tracks and sightings of the sizes and places given.
void ffp_tracks_find(FfpTracks *tracks, const FfpImage *maps, const FfpImage *whites, int shrink,
                     double step);
void ffp_tracks_free(FfpTracks *tracks);

// Of those that are left out how many they are, and why the first that a finding tells of, or otherwise the
// first: "3 left out, NAME: WHY".
enum { FFP_LEFT_OUT_SIZE = 640 };
void ffp_places_left_out(const FfpTracks *tracks, char text[FFP_LEFT_OUT_SIZE]);
// Refuses to go on with too few of them. Returns false.
bool ffp_places_refuse_few(const FfpTracks *tracks, int used, int least, const char *what, FfpError *err);

// The noise in the errors of a fit, which neighbours do not share: the root of half the mean square of
// the difference between those of tracks side by side. `miss`: from a track's sighting at a place to where
// the fit puts it; false: it is not used there.
double ffp_tracks_noise(const FfpTracks *tracks, const void *fit,
                        bool (*miss)(const void *fit, int track, int place, double off[2]));

#endif
