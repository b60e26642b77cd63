// The pictures in the order to show them.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/patterns/patterns.h"

static int gray_code_pictures(const FfpShow *show) {
    return 2 * (ffp_gray_code_bits(show->width) + ffp_gray_code_bits(show->height));
}

static int part_count(const FfpShow *show, FfpShowPart part) {
    switch (part) {
    case FFP_SHOW_FOCUS:
        return show->focus ? 1 : 0;
    case FFP_SHOW_CAPTURE:
        return show->capture ? 2 + show->lollipops + show->greys : 0;
    case FFP_SHOW_GRAY_CODES:
        return show->gray_codes ? gray_code_pictures(show) : 0;
    }
    return 0;
}

int ffp_show_count(const FfpShow *show) {
    int count = 0;
    for (int part = FFP_SHOW_FOCUS; part <= FFP_SHOW_GRAY_CODES; part++)
        count += part_count(show, (FfpShowPart)part);
    return count;
}

static FfpImage gray_code(const FfpShow *show, int index, char name[32]) {
    int axis, bit;
    ffp_gray_code_place(show->width, index, &axis, &bit);
    ffp_gray_code_name(show->width, index, name);
    return ffp_pattern_gray_code(show->width, show->height, axis, bit, index % 2 == 1);
}

int ffp_show_grey(int greys, int index) {
    return (255 * (index + 1) + (greys + 1) / 2) / (greys + 1);
}

int ffp_grey_named(const char *name) {
    char again[32];
    if (strncmp(name, "grey_", 5) != 0) return 0;
    const long value = strtol(name + 5, NULL, 10);
    if (value < 1 || value > 254) return 0;
    snprintf(again, sizeof again, "grey_%03d", (int)value);
    return strcmp(again, name) == 0 ? (int)value : 0;
}

static FfpImage for_capture(const FfpShow *show, int index, char name[32]) {
    if (index >= 2 + show->lollipops) {
        const int value = ffp_show_grey(show->greys, index - 2 - show->lollipops);
        snprintf(name, 32, "grey_%03d", value);
        return ffp_pattern_plain(show->width, show->height, value);
    }
    if (index >= 2) {
        snprintf(name, 32, "lollipop_%d", index - 2);
        return ffp_pattern_round_lollipop(show->width, show->height, (uint64_t)(index - 2));
    }
    snprintf(name, 32, "%s", index == 0 ? "black" : "white");
    return ffp_pattern_plain(show->width, show->height, index == 0 ? 0 : 255);
}

FfpImage ffp_show_picture(const FfpShow *show, int index, char name[32], FfpShowPart *part) {
    int at = FFP_SHOW_FOCUS;
    for (; index >= part_count(show, (FfpShowPart)at); at++) index -= part_count(show, (FfpShowPart)at);
    *part = (FfpShowPart)at;
    if (at == FFP_SHOW_CAPTURE) return for_capture(show, index, name);
    if (at == FFP_SHOW_GRAY_CODES) return gray_code(show, index, name);
    snprintf(name, 32, "focus");
    return ffp_pattern_focus(show->width, show->height);
}

int ffp_show_number(const FfpShow *show, int index) {
    return show->focus ? index : index + 1;
}
