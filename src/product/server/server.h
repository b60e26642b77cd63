// The studio (product/studio) on this machine: a server on its loopback address, and the page that it serves.
// The commands run as anybody would run them.
#ifndef FFP_SERVER_SERVER_H
#define FFP_SERVER_SERVER_H

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
bool ffp_server_main(const FfpStudioOptions *options, char *error, size_t size);

#endif
