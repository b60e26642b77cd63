// The studio: a server on this machine's loopback address, and the page that it serves, from a bare projector
// and a camera to the relit object. Whatever it makes is made by the program's other commands, which it runs
// as anybody would; its state is the files of one folder (docs/reference/formats/studio.md).
#ifndef FFP_STUDIO_STUDIO_H
#define FFP_STUDIO_STUDIO_H

#include <stdbool.h>
#include <stddef.h>

typedef struct FfpStudioOptions {
    const char *folder; // made if there is none
    bool virtual_rig;   // for a new folder: the simulator's camera and projector
    bool stays_closed;  // the page is not opened in the user's browser
    int port;           // 0: any
    const char *osc;    // [ADDRESS:]PORT for OSC messages over UDP; NULL: none are heard
} FfpStudioOptions;

// Serves until SIGINT or SIGTERM comes. Prints the page's address, which holds the key to it. False: what is
// wrong, in error[size].
bool ffp_studio_run(const FfpStudioOptions *options, char *error, size_t size);

#endif
