// Words: those that values of several commands' options may be, and a command's as one types them.
#include "cli.h"
#include "product/studio/typed.h"

const FfpWord ffp_cli_framings[] = {{"cover", FFP_FRAMING_COVER},
                                    {"contain", FFP_FRAMING_CONTAIN},
                                    {"stretch", FFP_FRAMING_STRETCH},
                                    {"pixel", FFP_FRAMING_PIXEL},
                                    {0}};
const FfpWord ffp_cli_auto[] = {{"auto", -1}, {0}}; // FFP_POLISH_AUTO and FFP_NOISE_ESTIMATED
const FfpWord ffp_cli_layers[] = {{"auto", FFP_LAYERS_AUTO}, {"all", 0}, {0}};
const FfpWord ffp_cli_forms[] = {
    {"ours", FFP_FORM_OURS}, {"paper", FFP_FORM_PAPER}, {"gs-procams", FFP_FORM_GS_PROCAMS}, {0}};
const FfpWord ffp_cli_page_forms[] = {{"ours", FFP_FORM_OURS}, {"paper", FFP_FORM_PAPER}, {0}};
const FfpWord ffp_cli_devices[] = {{"cpu", 0}, {"cuda", 1}, {0}};
const FfpWord ffp_cli_none[] = {{"none", 0}, {0}};

void ffp_cli_type(FILE *out, const FfpList *words) {
    for (int i = 0; i < words->count; i++) {
        if (i > 0) fputc(' ', out);
        ffp_studio_type(out, words->values[i]);
    }
    fputc('\n', out);
    fflush(out);
}
