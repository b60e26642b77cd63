// The reference of all options (docs/reference/options.md), made of the tables.
#include <ctype.h>
#include <string.h>
#include "help.h"

// Text in which nothing steers Markdown; what is between backquotes stays code.
static void put_text(FILE *out, const char *text, int length) {
    bool code = false;
    for (int i = 0; i < length; i++) {
        code ^= text[i] == '`';
        if (text[i] == '|' || (!code && strchr("*<[", text[i]))) fputc('\\', out);
        fputc(text[i], out);
    }
}

static void put_row(FILE *out, const char *term, const char *text) {
    fputs("| `", out);
    for (const char *at = term; *at; at++) fprintf(out, *at == '|' ? "\\|" : "%c", *at);
    fputs("` | ", out);
    put_text(out, text, (int)strlen(text));
    fputs(" |\n", out);
}

static void put_prose(FILE *out, const char *text) {
    bool list = false;
    while (*text) {
        const FfpProse prose = ffp_cli_prose(&text);
        const bool item = prose.kind != FFP_PROSE_PARAGRAPH;
        if (!item || !list) fputc('\n', out);
        list = item;
        if (item) fputs("- ", out);
        if (prose.kind == FFP_PROSE_DEFINITION) fprintf(out, "`%.*s`: ", prose.term_length, prose.term);
        put_text(out, prose.text, prose.length);
        fputc('\n', out);
    }
}

static void put_options(FILE *out, const FfpOption *options) {
    char label[128], cell[512];
    const char *group = NULL;
    for (const FfpOption *option = options; option->name; option++) {
        if (option->group && (!group || strcmp(group, option->group) != 0))
            fprintf(out, "| **%s** | |\n", option->group);
        group = option->group;
        ffp_cli_option_label(option, label, sizeof label);
        snprintf(cell, sizeof cell, "%s%s", label + strspn(label, " "), option->repeated ? ".." : "");
        put_row(out, cell, option->help);
    }
}

static void put_examples(FILE *out, const FfpExample *examples) {
    for (; examples && examples->command; examples++) {
        fputc('\n', out);
        if (examples->about) {
            put_text(out, examples->about, (int)strlen(examples->about));
            fputs("\n\n", out);
        }
        fprintf(out, "```console\n%s\n```\n", examples->command);
    }
}

static void put_command(FILE *out, const FfpCommand *command) {
    fprintf(out, "\n## %s\n\n%c%s.\n", command->name, toupper((unsigned char)command->purpose[0]),
            command->purpose + 1);
    if (command->prose) put_prose(out, command->prose);
    fputs("\n| | |\n|---|---|\n", out);
    if (command->positional.name) put_row(out, command->positional.name, command->positional.help);
    put_options(out, command->options);
    if (command->epilogue) put_prose(out, command->epilogue);
    put_examples(out, command->examples);
}

void ffp_cli_reference(const FfpProgram *program, FILE *out) {
    fprintf(out,
            "# Options\n\nWritten by `%s --pages` from the tables that `--help` and the manual pages come "
            "from; [commands](commands.md) says which command does what.\n",
            program->name);
    for (const FfpCommand *const *at = program->commands; *at; at++) put_command(out, *at);
    fprintf(out, "\n## %s\n\nIn place of a command:\n\n| | |\n|---|---|\n", program->name);
    put_options(out, program->options);
    put_prose(out, program->environment);
    put_prose(out, program->exit_status);
}
