/* Readings (f32, as this machine stores them) from stdin; the state (a byte), the statistic and the noise of the second band (f32) after each to
 * stdout. A reading of -infinity stands for a restart.
 *   detector RATE_HZ MIN_RMS     ends with 2 where sd_init refuses them */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "slip_detector.h"

int main(int argc, char **argv) {
    static sd_detector d;
    if (argc != 3 || !sd_init(&d, strtof(argv[1], NULL), strtof(argv[2], NULL))) return 2;
    float reading;
    while (fread(&reading, sizeof reading, 1, stdin) == 1) {
        if (reading == -INFINITY) sd_restart(&d);
        const unsigned char state = (unsigned char)sd_step(&d, reading);
        const float figures[] = {sd_statistic(&d), sd_noise(&d, 1)};
        if (fwrite(&state, 1, 1, stdout) != 1 || fwrite(figures, sizeof figures, 1, stdout) != 1) return 1;
    }
    return 0;
}
