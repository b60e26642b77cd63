// Colours of the classical initialisation, from the black and white images once the surface is known.
#ifndef FFP_MATCH_MATERIAL_H
#define FFP_MATCH_MATERIAL_H

#include "engine/match/match.h"

// Fills albedo and ambient from t, normal, lit. Light: white - black = albedo / pi I max(n.l, 0.15) / d^2.
void ffp_initialisation_materials(FfpInitialisation *start, const FfpCapture *capture);

#endif
