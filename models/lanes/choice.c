/* Which kind of processor this is: 2 with AVX-512, 1 with AVX2, 0 any. */
#include "run.h"

#ifdef __x86_64__
#include <cpuid.h>

static int level_of_processor(void) {
    const unsigned avx512 = 1u << 16 | 1u << 17 | 1u << 30 | 1u << 31; /* F, DQ, BW, VL */
    unsigned a, b, c, d, state, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & 1u << 27))
        return 0;
    __asm__("xgetbv" : "=a"(state), "=d"(high) : "c"(0)); /* what the system saves */
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (state & 0x06) != 0x06 || !(b & 1u << 5))
        return 0;
    return (b & avx512) == avx512 && (state & 0xE6) == 0xE6 ? 2 : 1;
}
#else
static int level_of_processor(void) { return 0; }
#endif

EXPORT int lanes_level(void);
int lanes_level(void) { return level_of_processor(); }

void run_lanes0(const LaneRun *run);
void run_lanes1(const LaneRun *run);
void run_lanes2(const LaneRun *run);

EXPORT void run_lanes(const LaneRun *run, int level);
void run_lanes(const LaneRun *run, int level) {
    (level == 2 ? run_lanes2 : level == 1 ? run_lanes1 : run_lanes0)(run);
}
