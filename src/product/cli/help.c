// Help for a terminal, made of the tables.
#include "help.h"
#include <ctype.h>
#include <string.h>
#include "options.h"

enum { WIDTH = 100, LABEL_MAX = 28 };

int ffp_cli_option_label(const FfpOption *option, char *text, size_t size) {
    const char *argument = option->argument ? option->argument : "";
    const char *between = option->optional_value ? "[=" : *argument ? " " : "";
    if (option->letter)
        return snprintf(text, size, "-%c, --%s%s%s%s", option->letter, option->name, between, argument,
                        option->optional_value ? "]" : "");
    return snprintf(text, size, "    --%s%s%s%s", option->name, between, argument,
                    option->optional_value ? "]" : "");
}

bool ffp_cli_usage_word(const FfpCommand *command, int i, char *text, size_t size) {
    const FfpPositional *positional = &command->positional;
    int n = 0, wanted = i - (positional->name != NULL);
    if (wanted < 0) {
        const char *left = positional->least ? "" : "[", *right = positional->least ? "" : "]";
        snprintf(text, size, "%s%s%s%s", left, positional->name, right, positional->most > 1 ? ".." : "");
        return true;
    }
    for (int optional = 0; optional < 2; optional++) // what must be there first
        for (const FfpOption *option = command->options; option->name; option++) {
            if (option->required == (optional == 1) || n++ != wanted) continue;
            const char *between = option->optional_value ? "[=" : option->argument ? " " : "";
            snprintf(text, size, "%s--%s%s%s%s%s%s", optional ? "[" : "", option->name, between,
                     option->argument ? option->argument : "", option->optional_value ? "]" : "",
                     optional ? "]" : "", option->repeated ? ".." : "");
            return true;
        }
    return false;
}

FfpProse ffp_cli_prose(const char **at) {
    FfpProse prose = {.kind = FFP_PROSE_PARAGRAPH, .text = *at, .length = (int)strcspn(*at, "\n")};
    *at += prose.length + ((*at)[prose.length] == '\n');
    const char *tab = memchr(prose.text, '\t', (size_t)prose.length);
    if (tab) {
        prose.kind = FFP_PROSE_DEFINITION;
        prose.term = prose.text;
        prose.term_length = (int)(tab - prose.text);
        prose.length -= prose.term_length + 1;
        prose.text = tab + 1;
    } else if (strncmp(prose.text, "- ", 2) == 0) {
        prose.kind = FFP_PROSE_ITEM;
        prose.text += 2;
        prose.length -= 2;
    }
    return prose;
}

// Words from column `at` on, further lines from `indent` on; ends the last line.
static void put_words(FILE *out, const char *text, int length, int at, int indent) {
    for (int i = 0; i < length;) {
        const int word = (int)strcspn(text + i, " ");
        const int size = word < length - i ? word : length - i;
        if (i > 0 && at + 1 + size > WIDTH) {
            fprintf(out, "\n%*s", indent, "");
            at = indent;
        } else if (i > 0) {
            fputc(' ', out);
            at++;
        }
        fwrite(text + i, 1, (size_t)size, out);
        at += size;
        for (i += size; i < length && text[i] == ' ';) i++;
    }
    fputc('\n', out);
}

static void put_labelled(FILE *out, const char *label, int label_length, int column, const char *text,
                         int length) {
    fprintf(out, "  %.*s", label_length, label);
    if (label_length + 4 > column)
        fprintf(out, "\n%*s", column, "");
    else
        fprintf(out, "%*s", column - label_length - 2, "");
    put_words(out, text, length, column, column);
}

static void put_prose(FILE *out, const char *text) {
    int column = 0;
    for (const char *at = text; *at;) {
        const FfpProse prose = ffp_cli_prose(&at);
        if (prose.term_length + 4 > column) column = prose.term_length + 4;
    }
    for (const char *at = text; *at;) {
        const bool first = at == text;
        const FfpProse prose = ffp_cli_prose(&at);
        if (prose.kind == FFP_PROSE_DEFINITION) {
            put_labelled(out, prose.term, prose.term_length, column, prose.text, prose.length);
        } else if (prose.kind == FFP_PROSE_ITEM) {
            fputs("- ", out);
            put_words(out, prose.text, prose.length, 2, 2);
        } else {
            if (!first) fputc('\n', out);
            put_words(out, prose.text, prose.length, 0, 0);
        }
    }
}

static void put_purpose(FILE *out, const char *purpose) {
    char sentence[256];
    snprintf(sentence, sizeof sentence, "%c%s.", toupper((unsigned char)*purpose), purpose + 1);
    put_words(out, sentence, (int)strlen(sentence), 0, 0);
}

static void put_usage(FILE *out, const FfpCommand *command) {
    char word[256];
    const int indent = fprintf(out, "usage: ffprocams %s", command->name);
    int at = indent;
    for (int i = 0; ffp_cli_usage_word(command, i, word, sizeof word); i++) {
        const int length = (int)strlen(word);
        if (at + 1 + length > WIDTH) at = fprintf(out, "\n%*s", indent, "") - 1;
        fprintf(out, " %s", word);
        at += 1 + length;
    }
    fputc('\n', out);
}

static void put_option(FILE *out, const FfpOption *option, int column) {
    char label[128];
    const int length = ffp_cli_option_label(option, label, sizeof label);
    put_labelled(out, label, length, column, option->help, (int)strlen(option->help));
}

static void put_options(FILE *out, const FfpOption *options, const FfpPositional *positional) {
    static const FfpOption help = {.name = "help", .letter = 'h', .help = "show this help"};
    const char *group = NULL;
    char label[128];
    int column = 0;
    for (const FfpOption *option = options; option->name; option++) {
        const int length = ffp_cli_option_label(option, label, sizeof label) + 4;
        if (length > column && length <= LABEL_MAX) column = length;
    }
    if (column == 0) column = 14;
    fputc('\n', out);
    if (positional->name)
        put_labelled(out, positional->name, (int)strlen(positional->name), column, positional->help,
                     (int)strlen(positional->help));
    for (const FfpOption *option = options; option->name; option++)
        if (!option->group) put_option(out, option, column);
    put_option(out, &help, column);
    for (const FfpOption *option = options; option->name; option++) {
        if (!option->group) continue;
        if (!group || strcmp(group, option->group) != 0) fprintf(out, "\n%s:\n", option->group);
        group = option->group;
        put_option(out, option, column);
    }
}

static void put_examples(FILE *out, const FfpExample *examples) {
    fprintf(out, "\nexample%s:\n", examples[1].command ? "s" : "");
    for (; examples->command; examples++) {
        if (examples->about) put_words(out, examples->about, (int)strlen(examples->about), 0, 0);
        for (const char *line = examples->command; *line;) {
            const int length = (int)strcspn(line, "\n");
            fprintf(out, "  %.*s\n", length, line);
            line += length + (line[length] == '\n');
        }
    }
}

void ffp_cli_command_help(const FfpCommand *command, FILE *out) {
    put_purpose(out, command->purpose);
    fputc('\n', out);
    put_usage(out, command);
    if (command->prose) {
        fputc('\n', out);
        put_prose(out, command->prose);
    }
    put_options(out, command->options, &command->positional);
    if (command->epilogue) {
        fputc('\n', out);
        put_prose(out, command->epilogue);
    }
    put_examples(out, command->examples);
}

static void put_commands(FILE *out, const FfpCommand *const *commands) {
    const char *group = "";
    for (; *commands; commands++) {
        const FfpCommand *command = *commands;
        if (strcmp(group, command->group) != 0) fprintf(out, "\n%s:\n", group = command->group);
        put_labelled(out, command->name, (int)strlen(command->name), 15, command->purpose,
                     (int)strlen(command->purpose));
    }
}

void ffp_cli_program_help(const FfpProgram *program, FILE *out) {
    static const FfpPositional none = {0};
    put_purpose(out, program->purpose);
    fprintf(out, "\nusage: %s COMMAND [ARGUMENTS]\n       %s COMMAND --help\n\n", program->name,
            program->name);
    put_prose(out, program->prose);
    put_commands(out, program->commands);
    put_options(out, program->options, &none);
    fputc('\n', out);
    put_prose(out, program->environment);
    fputc('\n', out);
    put_prose(out, program->exit_status);
    put_examples(out, program->examples);
}
