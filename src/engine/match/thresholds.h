// Thresholds shared by all stages of the match room: for lit, for on a surface and for seen through.
#ifndef FFP_MATCH_THRESHOLDS_H
#define FFP_MATCH_THRESHOLDS_H

#define FFP_LIT_MIN 0.06F      // share of the typical light below which a pixel counts as not lit
#define FFP_SUPPORT_SLACK 2.0F // footprints, or cells of a projector's picture, off a surface that are on it
#define FFP_FREE_TRUST                                                                                       \
    0.3F // trust, beyond that of views that agree, that it takes to call a point seen through

#endif
