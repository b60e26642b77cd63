// Completion for bash, made of the tables. It needs no package beside bash 4.
#include <stdio.h>
#include "options.h"

static const char head[] = "# bash completion of ffprocams; written by the program itself\n"
                           "_ffprocams_files() {\n"
                           "    compopt -o filenames 2>/dev/null\n"
                           "    mapfile -t COMPREPLY < <(compgen \"$1\" -- \"$word\")\n"
                           "}\n"
                           "\n"
                           "_ffprocams() {\n"
                           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} "
                           "options='' files='' words=''\n"
                           "    if [[ $word == = ]]; then word=''; elif [[ $before == = ]]; then "
                           "before=${COMP_WORDS[COMP_CWORD-2]}; "
                           "fi\n"
                           "    COMPREPLY=()\n"
                           "    if ((COMP_CWORD == 1)); then before=''; fi\n"
                           "    case ${COMP_WORDS[1]}:$before in\n";

static const char tail[] = "    esac\n"
                           "    if [[ -z $options ]]; then\n"
                           "        [[ -n $files ]] && _ffprocams_files \"$files\"\n"
                           "        [[ -n $words ]] && mapfile -t -O \"${#COMPREPLY[@]}\" COMPREPLY < "
                           "<(compgen -W \"$words\" -- \"$word\")\n"
                           "    elif [[ $word == -* ]]; then\n"
                           "        mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$word\")\n"
                           "    else\n"
                           "        _ffprocams_files -f\n"
                           "    fi\n"
                           "}\n"
                           "complete -F _ffprocams ffprocams\n";

static void put_words(const FfpWord *words, FILE *out) {
    fputs("words='", out);
    for (; words && words->name; words++) fprintf(out, "%s%s", words->name, words[1].name ? " " : "");
    fputs("'", out);
}

// What may stand behind an option.
static void put_value(const char *command, const FfpOption *option, FILE *out) {
    const bool folder = option->type == FFP_OPTION_FOLDER, file = option->type == FFP_OPTION_FILE;
    if (option->type == FFP_OPTION_FLAG) return;
    fprintf(out, "    %s:--%s", command, option->name);
    if (option->letter) fprintf(out, "|%s:-%c", command, option->letter);
    fprintf(out, ") files='%s' ", folder ? "-d" : file ? "-f" : "");
    put_words(option->words, out);
    fputs(" ;;\n", out);
}

static void put_names(const FfpOption *options, FILE *out) {
    for (; options->name; options++) fprintf(out, "--%s ", options->name);
    fputs("--help", out);
}

void ffp_cli_completion(const FfpProgram *program, FILE *out) {
    fputs(head, out);
    for (const FfpCommand *const *at = program->commands; *at; at++)
        for (const FfpOption *option = (*at)->options; option->name; option++)
            put_value((*at)->name, option, out);
    for (const FfpOption *option = program->options; option->name; option++) {
        if (option->type == FFP_OPTION_FLAG) continue;
        fprintf(out, "    --%s:*) files=%s ;;\n", option->name,
                option->type == FFP_OPTION_FOLDER ? "-d" : "-f");
    }
    for (const FfpCommand *const *at = program->commands; *at; at++) {
        fprintf(out, "    %s:?*) options='", (*at)->name);
        put_names((*at)->options, out);
        fputs("' ;;\n", out);
    }
    fputs("    *:) words='", out);
    for (const FfpCommand *const *at = program->commands; *at; at++) fprintf(out, "%s ", (*at)->name);
    put_names(program->options, out);
    fputs("' ;;\n", out);
    fputs(tail, out);
}
