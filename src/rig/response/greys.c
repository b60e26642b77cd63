// The projector's response from photographs of even greys: no depth is needed, since all places show the
// same.
#include <math.h>
#include "core/base/real.h"
#include "rig/response/response.h"

#define GAMMA_LOW 0.4 // searched
#define GAMMA_HIGH 5.0
#define STEPS 40 // of the golden section

// Sum of squared differences of the light of every `step`-th grey from `first` on, one channel.
static double error_of(const FfpGrey *greys, int n, int first, int step, int channel, double gamma) {
    double sum = 0;
    for (int i = first; i < n; i += step) {
        const double off = greys[i].light[channel] - pow(greys[i].value, gamma);
        sum += off * off;
    }
    return sum;
}

// Golden section in the logarithm of gamma.
static double least(const FfpGrey *greys, int n, int step, int channel) {
    const double golden = (sqrt(5.0) - 1) / 2;
    double low = log(GAMMA_LOW), high = log(GAMMA_HIGH);
    for (int k = 0; k < STEPS; k++) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        if (error_of(greys, n, 0, step, channel, exp(a)) < error_of(greys, n, 0, step, channel, exp(b)))
            high = b;
        else
            low = a;
    }
    return exp((low + high) / 2);
}

// From the differences left over and the light's change with gamma.
static double deviation_of(const FfpGrey *greys, int n, int channel, double gamma) {
    double slopes = 0;
    for (int i = 0; i < n; i++) {
        const double slope = pow(greys[i].value, gamma) * log(greys[i].value);
        slopes += slope * slope;
    }
    return sqrt(error_of(greys, n, 0, 1, channel, gamma) / (n - 1) / slopes);
}

void ffp_fit_greys(FfpResponse *response, const FfpGrey *greys, int n, bool linear, double errors[2]) {
    double plain = 0, fitted = 0;
    int left_out = 0;
    for (int c = 0; c < 3; c++) {
        const double half = least(greys, n, 2, c);
        for (int i = 1; i < n; i += 2, left_out++) {
            const double value = greys[i].value,
                         as_file = linear ? value : (double)ffp_srgb_decode((real)value);
            plain += pow(greys[i].light[c] - as_file, 2);
        }
        fitted += error_of(greys, n, 1, 2, c, half);
        response->gamma[c] = least(greys, n, 1, c);
        response->gamma_deviation[c] = deviation_of(greys, n, c, response->gamma[c]);
    }
    errors[0] = sqrt(plain / left_out), errors[1] = sqrt(fitted / left_out);
}
