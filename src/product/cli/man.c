// Manual pages (roff with the man macros), made of the tables.
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "cli.h"
#include "help.h"

// Text in which nothing steers roff: dashes are to be copied as they are, spaces of a code stay.
static void put_text(FILE *out, const char *text, int length) {
    for (int i = 0; i < length; i++) {
        const bool begins = i == 0 || text[i - 1] == '\n';
        if (begins && (text[i] == '.' || text[i] == '\'')) fputs("\\&", out);
        if (text[i] == '\\')
            fputs("\\e", out);
        else if (text[i] == '-')
            fputs("\\-", out);
        else if (text[i] == '`')
            fputs("\\(ga", out);
        else if (text[i] == '\'')
            fputs("\\(aq", out);
        else if (text[i] == '^')
            fputs("\\(ha", out);
        else if (text[i] == '~')
            fputs("\\(ti", out);
        else
            fputc(text[i], out);
    }
}

static void put_string(FILE *out, const char *text) {
    put_text(out, text, (int)strlen(text));
}

static void put_definition(FILE *out, const char *term, int term_length, const char *text, int length) {
    fputs(".TP\n\\fB", out);
    put_text(out, term, term_length);
    fputs("\\fR\n", out);
    put_text(out, text, length);
    fputc('\n', out);
}

static void put_prose(FILE *out, const char *text) {
    while (*text) {
        const FfpProse prose = ffp_cli_prose(&text);
        if (prose.kind == FFP_PROSE_DEFINITION) {
            put_definition(out, prose.term, prose.term_length, prose.text, prose.length);
            continue;
        }
        fputs(prose.kind == FFP_PROSE_ITEM ? ".IP \\(bu 2\n" : ".PP\n", out);
        put_text(out, prose.text, prose.length);
        fputc('\n', out);
    }
}

static void put_options(FILE *out, const FfpOption *options) {
    static const char help[] = "-h, --help";
    const char *group = NULL;
    char label[128];
    put_definition(out, help, (int)strlen(help), "show a short form of this page", 29);
    for (const FfpOption *option = options; option->name; option++) {
        if (option->group && (!group || strcmp(group, option->group) != 0)) {
            fputs(".SS ", out);
            put_string(out, option->group);
            fputc('\n', out);
        }
        group = option->group;
        ffp_cli_option_label(option, label, sizeof label);
        const char *from = label + strspn(label, " ");
        put_definition(out, from, (int)strlen(from), option->help, (int)strlen(option->help));
    }
}

static void put_examples(FILE *out, const FfpExample *examples) {
    fputs(".SH EXAMPLES\n", out);
    for (; examples->command; examples++) {
        if (examples->about) {
            fputs(".PP\n", out);
            put_string(out, examples->about);
            fputc('\n', out);
        }
        fputs(".PP\n.nf\n", out);
        put_string(out, examples->command);
        fputs("\n.fi\n", out);
    }
}

static void put_see_also(FILE *out, const FfpProgram *program, const FfpCommand *page) {
    fputs(".SH SEE ALSO\n", out);
    if (page) fprintf(out, ".BR %s (1),\n", program->name);
    for (const FfpCommand *const *at = program->commands; *at; at++) {
        const bool last = !at[1] || (at[1] == page && !at[2]);
        if (*at != page) fprintf(out, ".BR %s\\-%s (1)%s\n", program->name, (*at)->name, last ? "" : ",");
    }
}

static void put_command(FILE *out, const FfpCommand *command) {
    char word[256];
    fprintf(out, ".SH SYNOPSIS\n.B ffprocams %s\n", command->name);
    for (int i = 0; ffp_cli_usage_word(command, i, word, sizeof word); i++) {
        const char *space = strchr(word, ' '); // option and value stay on one line
        put_text(out, word, space ? (int)(space - word) : (int)strlen(word));
        fputs(space ? "\\~" : "", out);
        put_string(out, space ? space + 1 : "");
        fputc('\n', out);
    }
    fputs(".SH DESCRIPTION\n", out);
    put_prose(out, command->prose ? command->prose : command->purpose);
    fputs(".SH OPTIONS\n", out);
    if (command->positional.name)
        put_definition(out, command->positional.name, (int)strlen(command->positional.name),
                       command->positional.help, (int)strlen(command->positional.help));
    put_options(out, command->options);
    if (!command->epilogue) return;
    fputs(".SH NOTES\n", out);
    put_prose(out, command->epilogue);
}

static void put_program(FILE *out, const FfpProgram *program) {
    const char *group = "";
    fprintf(out, ".SH SYNOPSIS\n.B %s\nCOMMAND [ARGUMENTS]\n.SH DESCRIPTION\n", program->name);
    put_prose(out, program->prose);
    fputs(".SH COMMANDS\n", out);
    for (const FfpCommand *const *at = program->commands; *at; at++) {
        if (strcmp(group, (*at)->group) != 0) {
            fputs(".SS ", out);
            put_string(out, group = (*at)->group);
            fputc('\n', out);
        }
        put_definition(out, (*at)->name, (int)strlen((*at)->name), (*at)->purpose,
                       (int)strlen((*at)->purpose));
    }
    fputs(".SH OPTIONS\n", out);
    put_options(out, program->options);
}

void ffp_cli_man(const FfpProgram *program, const FfpCommand *command, FILE *out) {
    const char *dash = command ? "-" : "", *name = command ? command->name : "";
    char title[96];
    snprintf(title, sizeof title, "%s%s%s", program->name, dash, name);
    fputs(".TH ", out);
    put_string(out, title);
    fprintf(out, " 1 \"\" \"%s %s\" \"FF\\-ProCams\"\n.nh\n.ad l\n.SH NAME\n", program->name,
            program->version);
    put_string(out, title);
    fputs(" \\- ", out);
    put_string(out, command ? command->purpose : program->purpose);
    fputc('\n', out);
    if (command)
        put_command(out, command);
    else
        put_program(out, program);
    fputs(".SH ENVIRONMENT\n", out);
    put_prose(out, program->environment);
    fputs(".SH EXIT STATUS\n", out);
    put_prose(out, program->exit_status);
    put_examples(out, command ? command->examples : program->examples);
    put_see_also(out, program, command);
}

// --- Files for packages. ---

static int cannot_write(const char *path) {
    FfpError err = {.code = FFP_ERROR_IO};
    snprintf(err.text, sizeof err.text, "cannot write: %.128s (%.512s)", strerror(errno), path);
    return ffp_cli_fail(&err);
}

typedef enum Kind { MAN, COMPLETION, REFERENCE } Kind;

// Whole or not at all: under another name first. `command`: of a man page.
static bool write_page(const FfpProgram *program, Kind kind, const FfpCommand *command, const char *path) {
    char temporary[1100];
    snprintf(temporary, sizeof temporary, "%s.%ld.tmp", path, (long)getpid());
    FILE *out = fopen(temporary, "w");
    if (!out) return false;
    if (kind == COMPLETION)
        ffp_cli_completion(program, out);
    else if (kind == REFERENCE)
        ffp_cli_reference(program, out);
    else
        ffp_cli_man(program, command, out);
    bool ok = fflush(out) == 0 && !ferror(out);
    int problem = errno;
    if (fclose(out) != 0 && ok) {
        ok = false;
        problem = errno;
    }
    if (ok && rename(temporary, path) != 0) {
        ok = false;
        problem = errno;
    }
    if (!ok) remove(temporary);
    errno = problem;
    return ok;
}

static bool make_folder(const char *folder) {
    struct stat there;
    if (mkdir(folder, 0777) == 0) return true;
    if (errno != EEXIST || stat(folder, &there) != 0) return false;
    errno = ENOTDIR;
    return S_ISDIR(there.st_mode);
}

int ffp_cli_pages(const FfpProgram *program, const char *folder) {
    char path[1024];
    if (!make_folder(folder)) return cannot_write(folder);
    snprintf(path, sizeof path, "%s/%s-completion.bash", folder, program->name);
    if (!write_page(program, COMPLETION, NULL, path)) return cannot_write(path);
    snprintf(path, sizeof path, "%s/%s-options.md", folder, program->name);
    if (!write_page(program, REFERENCE, NULL, path)) return cannot_write(path);
    snprintf(path, sizeof path, "%s/%s.1", folder, program->name);
    if (!write_page(program, MAN, NULL, path)) return cannot_write(path);
    for (const FfpCommand *const *at = program->commands; *at; at++) {
        snprintf(path, sizeof path, "%s/%s-%s.1", folder, program->name, (*at)->name);
        if (!write_page(program, MAN, *at, path)) return cannot_write(path);
    }
    return FFP_EXIT_OK;
}
