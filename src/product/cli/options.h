// One table per command: its name, its purpose, its arguments and options. Parsing, --help, the man page,
// bash completion and docs/reference/options.md are all derived from it.
#ifndef FFP_CLI_OPTIONS_H
#define FFP_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// The type of the value that an option writes to its destination in the command's arguments.
typedef enum FfpOptionType {
    FFP_OPTION_FLAG,   // bool: true; it takes no value
    FFP_OPTION_INT,    // int in low..high, or a word's value
    FFP_OPTION_INT64,  // int64_t, likewise
    FFP_OPTION_REAL,   // double in least..most, or a word's value
    FFP_OPTION_CHOICE, // int or enum: the value of one of the words
    FFP_OPTION_NAME,   // const char *: one of the words
    FFP_OPTION_TEXT,   // const char *
    FFP_OPTION_FILE,   // const char *, completed as a file; one of the words may take its place
    FFP_OPTION_FOLDER, // const char *, completed as a folder
    FFP_OPTION_PARSED, // the result of its function
} FfpOptionType;

typedef struct FfpWord {
    const char *name;
    double value;
} FfpWord;

// Values of an option or argument that may be repeated.
typedef struct FfpList {
    const char **values; // owned; the strings are argv's
    int count;
} FfpList;

typedef struct FfpOption {
    const char *name;     // long, without its dashes; NULL ends the table
    const char *argument; // the name of its value in help; NULL for a flag
    FfpOptionType type;
    char letter;          // short, or 0
    bool repeated;        // may be repeated: an FfpList of texts, or its function called again
    bool required;        // an error if it is missing
    bool optional_value;  // for text: "" if it is given without =VALUE
    bool writes;          // an output file, which must not be an input: see ffp_cli_check_outputs
    const char *needs;    // the option that it requires, or NULL
    const char *excludes; // the option with which it cannot be combined, or NULL
    size_t offset;        // of the destination
    int64_t low, high;    // INT64_MAX: no end
    double least, most;   // INFINITY: no end
    const FfpWord *words; // the last has no name. Of files, texts and parsed values: for completion alone
    bool (*parse)(const char *text, void *destination);
    const char *takes; // "WxH pixels": the expected value, for errors; NULL: derived from range and words
    const char *group; // heading in help; options of one group follow each other
    const char *help;  // one paragraph
} FfpOption;

// The arguments on the command line without dashes.
typedef struct FfpPositional {
    const char *name; // NULL: the command takes none
    int least, most;  // most is 1 (a const char *) or INT_MAX (an FfpList)
    size_t offset;
    const char *help;
    const char *excess; // the probable meaning of one too many, or NULL
} FfpPositional;

typedef struct FfpExample {
    const char *about;   // or NULL
    const char *command; // further lines are indented as they are to be shown; NULL ends the list
} FfpExample;

typedef struct FfpCommand {
    const char *name;
    const char *group;   // heading in the program's help
    const char *purpose; // one sentence, without capital and full stop
    // Lines, each a paragraph, an item ("- TEXT") or a definition ("TERM\tTEXT"); or NULL.
    const char *prose;
    FfpPositional positional;
    const FfpOption *options;
    const char *epilogue; // like the prose, after the options; or NULL
    const FfpExample *examples;
    size_t size;                           // of its arguments
    void (*set_defaults)(void *arguments); // NULL: all zero
    int (*run)(void *arguments);           // an exit code
} FfpCommand;

typedef struct FfpProgram {
    const char *name, *version, *purpose, *prose;
    const FfpCommand *const *commands;     // NULL ends them; those of one group follow each other
    const FfpOption *options;              // in place of a command; for help and completion alone
    const char *environment, *exit_status; // as the prose
    const FfpExample *examples;
} FfpProgram;

// Parses and runs; returns the exit code. argv[0] is the command's name.
int ffp_cli_run(const FfpCommand *command, int argc, char **argv);

// Checks the files that a command is to write: none may be a file that it reads, or that it writes twice, and
// where the option's argument has an extension ("FILE.ply"), a name with another one is refused. Prints what
// is wrong; -1 to go on, otherwise the exit code.
int ffp_cli_check_outputs(const FfpCommand *command, const void *arguments);

// The name that `word` was probably meant as, or NULL. Names end with NULL.
const char *ffp_cli_nearest(const char *word, const char *const *names);

// A whole decimal number in [low, high], or any finite one in between; false otherwise.
bool ffp_cli_number(const char *text, int64_t low, int64_t high, int64_t *out);
bool ffp_cli_real(const char *text, double low, double high, double *out);
// Two whole numbers of at least `low` with `between` between them: "1024x768".
bool ffp_cli_pair(const char *text, char between, int64_t low, int *a, int *b);
// The finite decimal number at the beginning of `text`, and where it ends; NAN where there is none. (strtod
// also takes 0x45, which is not meant here.)
double ffp_cli_decimal(const char *text, const char **end);

#define FFP_CLI_ANGLES_MAX 512
typedef struct FfpAngles {
    double degrees[FFP_CLI_ANGLES_MAX];
    int count;
} FfpAngles;
// Degrees with commas between, or NxSTEP: N stops, STEP apart ("0,20,40", "8x45", "8x-45"). NULL, or what is
// wrong with the text at *where, as a verb: "is not a number".
const char *ffp_cli_angles(const char *text, FfpAngles *angles, const char **where);
// "auto, all or a number from 0.5 to 100"
void ffp_cli_takes(const FfpOption *option, char *text, size_t size);

void ffp_cli_command_help(const FfpCommand *command, FILE *out);
void ffp_cli_program_help(const FfpProgram *program, FILE *out);
// Manual pages of section 1; `command` NULL: the program's own.
void ffp_cli_man(const FfpProgram *program, const FfpCommand *command, FILE *out);
void ffp_cli_completion(const FfpProgram *program, FILE *out); // a script for bash
void ffp_cli_reference(const FfpProgram *program, FILE *out);  // all options, as Markdown
// Writes all man pages, the completion and the reference into a folder; an exit code.
int ffp_cli_pages(const FfpProgram *program, const char *folder);

#endif
