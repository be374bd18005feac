/* How the processor rounds, and what it does with numbers near zero. An FMU may change that, and
 * would change the arithmetic of all others: it is plain again after each call. */
#ifndef COSIM_ARITHMETIC_H
#define COSIM_ARITHMETIC_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t control; /* MXCSR of x86-64 without its flags, FPCR of arm64 */
    uint16_t x87;     /* for long double on x86-64 */
} Arithmetic;

/* To nearest, with subnormal numbers, without traps; x87 with 64 bits of mantissa. */
#ifdef __x86_64__
#define PLAIN ((Arithmetic){0x1f80, 0x037f})
static inline Arithmetic arithmetic(void) {
    uint32_t control;
    Arithmetic a;
    __asm__ volatile("stmxcsr %0" : "=m"(control));
    __asm__ volatile("fnstcw %0" : "=m"(a.x87));
    a.control = control & 0xffc0U;
    return a;
}

static inline void set_arithmetic(Arithmetic a) {
    const uint32_t control = (uint32_t)a.control;
    __asm__ volatile("ldmxcsr %0" : : "m"(control));
    __asm__ volatile("fldcw %0" : : "m"(a.x87));
}
#elif defined __aarch64__
#define PLAIN ((Arithmetic){0, 0})
static inline Arithmetic arithmetic(void) {
    Arithmetic a = {0, 0};
    __asm__ volatile("mrs %0, fpcr" : "=r"(a.control));
    return a;
}

static inline void set_arithmetic(Arithmetic a) {
    __asm__ volatile("msr fpcr, %0" : : "r"(a.control));
}
#else
#define PLAIN ((Arithmetic){0, 0})
static inline Arithmetic arithmetic(void) { return PLAIN; }
static inline void set_arithmetic(Arithmetic a) { (void)a; }
#endif

static inline bool same_arithmetic(Arithmetic a, Arithmetic b) {
    return a.control == b.control && a.x87 == b.x87;
}

__attribute__((cold, noinline, unused)) static void make_plain(void) { set_arithmetic(PLAIN); }

static inline void restore_plain(void) {
    if (__builtin_expect(!same_arithmetic(arithmetic(), PLAIN), 0))
        make_plain();
}

/* Reading the register would take as long as two calls of a small FMU, so in a step four sums are
 * formed that come out otherwise when numbers are rounded up, down or to zero, or when subnormal
 * ones are flushed. Traps and the precision of x87 do not show. */
typedef float Four __attribute__((vector_size(16)));
typedef int32_t Bits __attribute__((vector_size(16)));
static inline unsigned wrong_sums(void) {
    static const Four a = {1.0F, 1.0F, 0x1p-140F, 0.0F}, b = {0x1p-40F, -0x1p-40F, 0x1p-140F, 0.0F};
    static const Four sum = {1.0F, 1.0F, 0x1p-139F, 0.0F};
#ifdef __x86_64__
    Four x = a;
    __asm__ volatile("" : "+x"(x));
    return (unsigned)__builtin_ia32_movmskps((Four)((Bits)(x + b) == (Bits)sum)) ^ 15U;
#else
    Four x = a;
    __asm__ volatile("" : "+w"(x));
    typedef uint64_t Halves __attribute__((vector_size(16)));
    const Halves d = (Halves)(x + b) ^ (Halves)sum;
    return (d[0] | d[1]) != 0;
#endif
}

static inline void restore_sums(void) {
    if (__builtin_expect(wrong_sums() != 0, 0))
        make_plain();
}

static inline Arithmetic begin_plain(void) {
    const Arithmetic before = arithmetic();
    restore_plain();
    return before;
}

static inline void end_plain(const Arithmetic *before) {
    if (!same_arithmetic(arithmetic(), *before))
        set_arithmetic(*before);
}

/* Plain until the block is left, then as the caller had it. */
#define PLAIN_HERE                                                                                 \
    __attribute__((cleanup(end_plain), unused)) const Arithmetic before_ = begin_plain()

#endif
