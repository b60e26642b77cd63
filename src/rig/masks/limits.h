// Limits that masks are judged by: the thresholds of this room that its steps share or documents name.
// Numbers of a single step, sizes of working memory and of drawings are in their files.
#ifndef FFP_MASKS_LIMITS_H
#define FFP_MASKS_LIMITS_H

// --- Pictures, smoothed, and by how much two of one thing differ (layers.c). ---

#define SMOOTH 0.7             // pixels
#define LAYER_NOISE_LEAST 6e-4 // linear: two steps of an 8-bit picture where it is dark
#define LAYER_NOISE_FACTOR 2.2 // times the differences' deviation
#define LAYER_RELATIVE 0.06    // of the light
#define LAYER_EDGE 0.15        // of what a pixel's neighbours differ by

// --- A view beside the stage (stage_pixels.c). ---

#define STAGE_NOISE_MOST 0.1 // of what pictures can hold: more is another room
#define LIT_NOISE 10         // times the noise that white adds
#define ALIKE 2.0            // mean squared error of what is alike, and
#define STAGE_OTHER 6.0      // of what is not
#define STAGE_FULL_LEAST 0.8 // factor of the stage's light, of what has all of it: at least, and
#define STAGE_FULL_MOST 1.25 // at most
#define STAGE_CONTINUES 0.2  // of the light, by which a look may differ from the stage around
#define STAGE_INDIRECT 0.1   // of what white adds where the stage is well lit: less comes from other surfaces
#define STAGE_DIMMED 0.3     // factor of that light which an object leaves at least
#define STAGE_SHADOW_MOST 0.3 // factor of the stage's light that is left in a shadow
#define STAGE_ROOM_LEAST 0.5  // and of the room's light
#define STAGE_GAIN_MOST 1.5   // either way
#define STAGE_SEEN_LEAST 0.1  // of the pixels

// --- Shadows on the stage (shade.c). ---

#define SHADE_SMOOTH 0.8        // pixels
#define SHADE_COLOUR_SMOOTH 2.0 // under black, which is noisy
#define SHADE_OBJECT_SMOOTH 6.0 // how far away the object's colour is looked for
#define SHADE_DIRECT_SMOOTH 1.5 // for the light that patterns add
#define SHADE_DARK 0.25         // of the light that white adds to the stage: less is dark
#define SHADE_UMBRA_MOST 0.15   // of white on the stage: shadows elsewhere count up to this
#define SHADE_DARKNESS 1.6      // times the median of these
#define SHADE_NO_COLOUR 1.2     // the same where black says nothing
#define SHADE_COLOUR_OFF 0.02   // by which the stage's chromaticity must fit better than the object's
#define SHADE_COLOUR_LEAST 1.5  // times the noise that black must have
#define SHADE_COLOUR_SURE 0.08  // the same, and
#define SHADE_BLACK_SURE 2.0    // times the noise that black must have, where
#define SHADE_KEPT_LEAST 0.75   // less of the stage's black is left: the room's lamp has its shadows, too
#define SHADE_KEPT_EVER 0.22    // of it that every shadow keeps: below, the object is darker than the stage
#define SHADE_KEPT_MOST 1.2     // of the stage's black: the object is brighter
#define SHADE_DIRECT 1.5        // squared error, in variances, of light that cannot be bounced
#define SHADE_DIRECT_NOISE 0.3  // of the noise: what is left of it in a local mean
#define SHADE_DIRECT_OFF 0.15   // of the light: bounced light differs from place to place
#define SHADE_UMBRA_LEAST 30    // pixels
#define SHADE_PIECE_LEAST 12    // pixels of a shadow

// --- The hull around what is object (carve.c). ---

#define REACH 1.1            // of the radius that bounds what is surely object
#define CARVE_SEEN_SHARE 0.5 // of all views, which must have a point in their pictures
#define CARVE_MARGIN 0.04    // of the radius that a point must lie before a surface to be seen through

// --- Masks from the hull (stage_masks.c). ---

#define HULL_VIEWS_LEAST 3   // that carve
#define HULL_RUN_LEAST 0.045 // of the sphere's radius that a ray must run through the hull

// --- What cameras and projectors see through (free_space.c). ---

#define FREE_CONFIDENCE 0.2 // of a depth that is believed
#define FREE_VIOLATION 0.3  // share of the views that may see past it
#define FREE_COVERED 0.5    // share of a pixel that counts as the object's

// --- Shares along outlines (soft_edges.c). ---

#define EDGE_BAND 2           // pixels on either side of an outline
#define EDGE_SIGMA 1.5        // pixels over which object and stage are averaged
#define EDGE_RELATIVE 0.05    // of the light: texture and noise
#define EDGE_UNEVEN 0.3       // of the light: what differs from place to place
#define EDGE_CONTRAST 8       // standard deviations between object and stage that make shares sure
#define EDGE_INSIDE 0.3       // share that pixels have at least that are not at the outline itself
#define EDGE_SHARE_LEAST 0.06 // less is none
#define EDGE_BRIGHTEST 1.3    // of the stage near the object over the empty one

// --- The stage from what the views share, where it was not photographed (stage_common.c). ---

#define COMMON_SHARE_LEAST 0.3  // of the views, which must share a look
#define COMMON_BRIGHTER 2.0     // times as much of white: the other look is a shadow
#define COMMON_SHADOWED 8.0     // likewise where two views alone show it
#define COMMON_ABOVE_LEAST 0.02 // of the mean mask, which must stand above the platter
#define COMMON_SURE 0.02        // share of a Gaussian that must be known
#define COMMON_GOES_ON 0.12     // of the light, by which a look may differ from the stage beside it

// --- What stands above the platter (place.c). ---

#define PLACE_NEAREST 0.5        // of the camera's distance from the object, of depths that are tried
#define PLACE_FARTHEST 3.0       // of it
#define PLACE_SMOOTH 0.6         // pixels, of a Gaussian, for the stage's pictures,
#define PLACE_WINDOW 1.2         // and for squared differences
#define PLACE_BLUR 2.0           // pixels of the camera, over which the pattern is averaged
#define PLACE_RELATIVE 0.08      // of what white adds: the error to allow in what a pattern adds
#define PLACE_COST_MOST 8.0      // of a place that is believed: its three channels' squared errors, their sum
#define PLACE_CLEARLY 0.5        // of the cost of any place that the object cannot reach; or
#define PLACE_EVEN 0.05          // of the radius: depths that differ by less, around a pixel,
#define PLACE_COST_LIMIT 30.0    // of one
#define PLACE_LIT 5.0            // times the noise that white adds
#define PLACE_BIN 0.02           // of the sphere's radius, of heights among which the platter's is looked for
#define PLACE_ABOVE 0.06         // of it, by which something stands above the platter
#define PLACE_AS_MANY 0.5        // of the pixels at the commonest height
#define PLACE_PLATTER_LEAST 0.05 // of the pixels within reach, which must lie at the platter's height

// --- Whether masks are good, and the room's light steady (complete.c). ---

#define MASKS_MISFIT_LEAST 0.12 // of the pixels, which contradict the other views' masks: those show a wall
#define MASKS_LIT_LEAST 0.5     // of what is lit that must stay the same
#define MASKS_MISFIT_MORE 0.01  // by which masks of all light may contradict each other more than others
#define MASKS_LACKING_MOST 0.02 // of the masks' pixels, which all light does not show
#define MASKS_VIEWS_TURNED 5    // that tell it
#define MASKS_LIGHT_LEAST 0.01  // of full scale, by which the light under black may change, and
#define LIGHT_CHANGE 0.25       // of the brighter one, here and against the empty stage
#define MASKS_AGREE_LEAST 0.9   // of the masks' pixels
#define MASKS_GAIN_MOST 1.1     // either way, by which the light may have changed without a word
#define MASKS_VIEWS_GROWN 4     // from which on views know enough of each other

// --- The room's light under black, against the empty stage's (stage_doubts.c). ---

#define ROOM_LIGHT_LEAST 0.001 // of full scale, by which the room's light must differ, and LIGHT_CHANGE

// --- An empty stage from another place (stage_moved.c). ---

#define MOVED_WIDTH 160     // pixels, about, at which pictures are compared
#define MOVED_REACH 0.06    // of the width: the largest displacement
#define MOVED_OFF_MOST 0.25 // of what a pixel counts
#define MOVED_DARK 0.02     // of the mean light: less says nothing
#define MOVED_CLEARLY 0.8   // of the difference without a displacement

// --- An object before darkness (dark.c). ---

#define DARK_SIGMAS 5.0          // of the background's noise, by which the object is brighter
#define DARK_NOISE_LEAST 1e-4    // linear: a third of the first step of 8 bits
#define DARK_EVEN 0.03           // of the object's light
#define DARK_COVERED_MOST 0.6    // of a picture: its darker half must be background
#define DARK_STAGE_QUANTILE 0.99 // of the empty stage's pixels, which must be dark

// --- Shadows that other views show lit (grow_masks.c). ---

#define GROW_NEAR 3         // voxels that a point must lie behind what shadows it
#define GROW_ADDED_MOST 0.4 // of what is lit in all views
#define GROW_LIT_SHARE 6    // views that show light for one that has a shadow

// --- Pieces of a mask (mask.c). ---

#define MASK_PIECE_LEAST 20  // of the largest piece's size a piece must have one such part, and
#define MASK_SPECK_LEAST 200 // background inside it, which is none below that

#endif
