// A film's description of its pictures, and the filters of ffmpeg that make pictures of this program of them:
// square pixels, sRGB, straight alpha.
#ifndef FFP_IMAGE_STREAM_H
#define FFP_IMAGE_STREAM_H

#include "core/base/error.h"

enum { FFP_STREAM_WORD = 32, FFP_STREAM_FILTER = 640 };

typedef struct FfpRate {
    int frames, seconds; // so many frames in so many seconds
} FfpRate;
void ffp_rate_print(FfpRate rate, char text[FFP_STREAM_WORD]); // as ffmpeg takes it

typedef struct FfpStream { // "": it does not say
    char codec[FFP_STREAM_WORD], pixels[FFP_STREAM_WORD], range[FFP_STREAM_WORD], matrix[FFP_STREAM_WORD],
        transfer[FFP_STREAM_WORD], primaries[FFP_STREAM_WORD], aspect[FFP_STREAM_WORD],
        fields[FFP_STREAM_WORD];
    int width, height;
    double seconds;         // it lasts; 0: not known
    FfpRate rate;           // of its frames; 0 frames: not known
    bool alpha, interlaced; // interlaced: its first frame is
} FfpStream;

// The first film of a file, by ffprobe; without that program, nothing is known.
void ffp_stream_probe(FfpStream *stream, const char *file);
bool ffp_stream_has_sound(const char *file); // by ffprobe likewise
// Decoder and format that ffmpeg has to be told before the file, NULL: its own choice.
const char *ffp_stream_decoder(const FfpStream *stream);
const char *ffp_stream_format(const FfpStream *stream);
// The filters. Interlaced frames are made whole. Pixels are made square by stretching. Without a matrix that
// of BT.709 is taken from 720 lines or 1280 columns on, and BT.601 below, as by most players. HLG and PQ
// become sRGB with white at 203 cd/m2 (ITU-R BT.2408), above which 1000 cd/m2 are rolled off; colours of
// BT.2020 and P3 are clipped to sRGB.
void ffp_stream_filter(const FfpStream *stream, bool alpha, char filter[FFP_STREAM_FILTER]);
// Notes what the filters assume or change, if anything. `hdr_only`: only what changes light.
void ffp_stream_note(const FfpStream *stream, const char *path, bool hdr_only);

#endif
