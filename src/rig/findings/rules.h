// The rules: one row for each finding that there is, with its code, severity, limit and words. Rooms that
// measure (checks, masks, import, calibrations) name a row and give it numbers and names; telling is
// tell.h's.
#ifndef FFP_RIG_FINDINGS_RULES_H
#define FFP_RIG_FINDINGS_RULES_H

#include <stdio.h>
#include "ffprocams/findings.h"

// docs/guide/troubleshooting.md has them in this order.
typedef enum FfpRuleId {
    // Devices.
    FFP_RULE_FRUSTA,
    FFP_RULE_OBJECT_BEHIND,
    FFP_RULE_OBJECT_CUT_OFF,
    FFP_RULE_PATTERN_TOO_SMALL,
    FFP_RULE_LIT_PIXELS,
    FFP_RULE_LIT_WHERE_NONE,
    FFP_RULE_AXES,
    FFP_RULE_DEVICE_BEHIND,
    FFP_RULE_DEVICE_INSIDE,
    FFP_RULE_DEVICE_FAR,
    FFP_RULE_TOGETHER,
    // Silhouettes.
    FFP_RULE_SILHOUETTES,
    FFP_RULE_VIEW_CONTRADICTS,
    FFP_RULE_VIEWS_CONTRADICT,
    FFP_RULE_NOTE_VIEW_CONTRADICTS,
    FFP_RULE_NOTE_VIEWS_CONTRADICT,
    FFP_RULE_VIEW_TURNED,
    FFP_RULE_VIEWS_EXCHANGED,
    FFP_RULE_OTHER_DIRECTION,
    FFP_RULE_CAMERA_SIZE,
    FFP_RULE_MASK_INVERTED,
    FFP_RULE_MASK_EMPTY,
    // Light.
    FFP_RULE_CLIPPING,
    FFP_RULE_CLIPPED,
    FFP_RULE_NOTE_CLIPPED,
    FFP_RULE_EXPOSURE,
    FFP_RULE_UNDEREXPOSED,
    FFP_RULE_NOTE_UNDEREXPOSED,
    FFP_RULE_BLACK_LEVEL,
    FFP_RULE_WHITE_DARKER,
    FFP_RULE_EXCHANGED,
    FFP_RULE_BLACK_LIT,
    FFP_RULE_SAME_PHOTOGRAPH,
    FFP_RULE_SAME_VIEW,
    FFP_RULE_PROJECTOR_DARK,
    FFP_RULE_LAMP,
    FFP_RULE_BRIGHT_ROOM,
    FFP_RULE_BLURRED,
    FFP_RULE_LIT_SHARE,
    FFP_RULE_LITTLE_LIT,
    // The rig, against those that the shipped model was trained on: ok, and far from that.
    FFP_RULE_CAMERA_DISTANCE,
    FFP_RULE_PROJECTOR_DISTANCE,
    FFP_RULE_CAMERA_HEIGHT,
    FFP_RULE_BETWEEN,
    FFP_RULE_CAMERA_FIELD,
    FFP_RULE_PROJECTOR_FIELD,
    FFP_RULE_ROLL,
    FFP_RULE_AMBIENT,
    FFP_RULE_UNUSUAL, // the first of eight, in the same order
    FFP_RULE_VIEWS = FFP_RULE_UNUSUAL + FFP_RULE_UNUSUAL - FFP_RULE_CAMERA_DISTANCE,
    FFP_RULE_FEW_VIEWS,
    FFP_RULE_SIZE,
    FFP_RULE_LARGE,
    FFP_RULE_SMALL,
    // The pattern.
    FFP_RULE_PATTERN,
    FFP_RULE_PATTERN_BLIND,
    FFP_RULE_NONE_LIT,
    FFP_RULE_PATTERN_MIRRORED,
    FFP_RULE_ALL_MIRRORED,
    FFP_RULE_RED_AND_BLUE,
    FFP_RULE_PROJECTOR_SIZE,
    FFP_RULE_PROJECTOR_INVERTED,
    FFP_RULE_ENCODING,
    FFP_RULE_GREY,
    FFP_RULE_OTHER_PATTERN,
    FFP_RULE_OTHER_PATTERN_ONCE,
    FFP_RULE_PATTERN_EXCHANGED,
    FFP_RULE_EXPOSED_OTHERWISE,
    FFP_RULE_PATTERN_NOT_THERE,
    FFP_RULE_PATTERN_MOVED,
    FFP_RULE_VIEW_MOVED,
    FFP_RULE_VIEW_SPOILT,
    FFP_RULE_CHANCE,
    FFP_RULE_NOTE_CHANCE,
    // Things that moved.
    FFP_RULE_SURFACES,
    FFP_RULE_SLIPPED,
    FFP_RULE_SLIPPED_VIEWS,
    FFP_RULE_APART,
    // Whole scenes.
    FFP_RULE_DEPTH,
    FFP_RULE_PARALLAX,
    FFP_RULE_NO_PARALLAX,
    FFP_RULE_WIDE_PARALLAX,
    FFP_RULE_SCENE_LIT,
    FFP_RULE_SCENE_DARK,
    // Photographs, as they are imported.
    FFP_RULE_MASKS_EMPTY,
    FFP_RULE_NO_OBJECT,
    FFP_RULE_STAGE_EXCHANGED,
    FFP_RULE_STAGE_DIFFERS,
    FFP_RULE_STAGE_UNLIKE,
    FFP_RULE_STAGE_ELSEWHERE,
    FFP_RULE_VIEW_ELSEWHERE,
    FFP_RULE_STAGE_LIGHT,
    FFP_RULE_STAGE_GAIN,
    FFP_RULE_LIT_BACKGROUND,
    FFP_RULE_MASKS_DISAGREE,
    FFP_RULE_VIEW_LIGHT,
    FFP_RULE_TOO_BRIGHT,
    FFP_RULE_FEW_BITS,
    FFP_RULE_FEW_BITS_AS_SRGB,
    FFP_RULE_CODES_LEFT_OUT,
    FFP_RULE_RESPONSE,
    FFP_RULE_TAGS_DIFFER,
    FFP_RULE_TAGS_MIXED,
    FFP_RULE_TURNED_PICTURES,
    FFP_RULE_RAW_AND_JPEG,
    FFP_RULE_NUMBERS_WRAP,
    FFP_RULE_ONE_LATE,
    FFP_RULE_LATE_FROM,
    FFP_RULE_WHITE_IS_BLACK,
    FFP_RULE_COUNT,
    FFP_RULE_NO_PLAIN,
    FFP_RULE_NO_PLAIN_LIT,
    FFP_RULE_PLAIN_SWAPPED,
    FFP_RULE_NOTHING_LIT,
    FFP_RULE_BOTH_CLIPPED,
    FFP_RULE_CODES_SWAPPED,
    FFP_RULE_CODES_ORDER,
    FFP_RULE_CODES_NO_PAIR,
    FFP_RULE_CODES_EXPOSURE,
    FFP_RULE_CODES_ELSEWHERE,
    FFP_RULE_CODES_MISSING,
    FFP_RULE_CODES_LINEAR,
    FFP_RULE_PANEL_SIDES,
    FFP_RULE_PANEL_SIZE,
    FFP_RULE_CODES_FEW_BITS,
    FFP_RULE_PLAIN_CLIPPED,
    FFP_RULE_CODES_CLIPPED,
    // Calibrations.
    FFP_RULE_PROJECTOR_FITS_BADLY,
    FFP_RULE_BOARD_DARK,
    FFP_RULE_BOARD_UNEVEN,
    FFP_RULE_BOARD_MIRRORED,
    FFP_RULE_ATTITUDE,
    FFP_RULE_FOCAL,
    FFP_RULE_AXIS_UNIT,
    FFP_RULE_PLACE_LEFT_OUT,
    FFP_RULE_STOP_LEFT_OUT,
    FFP_RULE_PLACES_FOCAL,
    FFP_RULE_STOPS_FOCAL,
    FFP_RULE_LENS_DIFFERS,
    FFP_RULE_TERMS_FIX,
    FFP_RULE_TERMS_OPEN,
    FFP_RULE_TERMS_UNTRIED,
    FFP_RULE_BOARD_CLIPPED,
    FFP_RULES
} FfpRuleId;

// Sentence and advice are templates: {view}, {other}, {a}, {b} and {c} are texts; {figure}, {limit}, {x}, {y}
// and {z} numbers, with the digits behind a colon: {figure:.2f}, {x:.3g}, or {figure:.1%}, which is a share
// in percent.
typedef struct FfpRule {
    const char *code;
    FfpSeverity severity;
    const char *subject;
    const char *measure; // what its figure is; NULL: it has none
    double limit;        // of the figure; 0: the room that measures sets it
    const char *sentence, *advice, *setting;
} FfpRule;

const FfpRule *ffp_rule(FfpRuleId id);

// docs/guide/troubleshooting.md, from these tables.
void ffp_write_troubleshooting(FILE *out);

#endif
