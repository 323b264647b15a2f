/* A mathematics of another platform: each elementary function gives the neighbour of what the C library gives. Arithmetic, roots,
   remainders and rounding are exact by IEEE 754 on every platform, and stay. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <string.h>

/* The next number of the same sign; zero, infinity and what is no number stay. */
static double next(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint64_t exponent = bits >> 52 & 0x7ff;
    if (exponent != 0 && exponent != 0x7ff) bits += 1;
    memcpy(&value, &bits, sizeof bits);
    return value;
}

static float nextf(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t exponent = bits >> 23 & 0xff;
    if (exponent != 0 && exponent != 0xff) bits += 1;
    memcpy(&value, &bits, sizeof bits);
    return value;
}

#define REAL(type, name, parameters) \
    static type(*real) parameters; \
    if (!real) real = (type(*) parameters)dlsym(RTLD_NEXT, #name)

#define ONE(name, type, next) \
    type name(type x) { REAL(type, name, (type)); return next(real(x)); }
#define TWO(name, type, next) \
    type name(type x, type y) { REAL(type, name, (type, type)); return next(real(x, y)); }
#define BOTH(name, type, next) \
    void name(type x, type *s, type *c) { REAL(void, name, (type, type *, type *)); real(x, s, c); *s = next(*s); *c = next(*c); }

ONE(sin, double, next)
ONE(sinf, float, nextf)
ONE(cos, double, next)
ONE(cosf, float, nextf)
ONE(tan, double, next)
ONE(tanf, float, nextf)
ONE(asin, double, next)
ONE(asinf, float, nextf)
ONE(acos, double, next)
ONE(acosf, float, nextf)
ONE(atan, double, next)
ONE(atanf, float, nextf)
ONE(sinh, double, next)
ONE(sinhf, float, nextf)
ONE(cosh, double, next)
ONE(coshf, float, nextf)
ONE(tanh, double, next)
ONE(tanhf, float, nextf)
ONE(asinh, double, next)
ONE(asinhf, float, nextf)
ONE(acosh, double, next)
ONE(acoshf, float, nextf)
ONE(atanh, double, next)
ONE(atanhf, float, nextf)
ONE(exp, double, next)
ONE(expf, float, nextf)
ONE(exp2, double, next)
ONE(exp2f, float, nextf)
ONE(exp10, double, next)
ONE(exp10f, float, nextf)
ONE(expm1, double, next)
ONE(expm1f, float, nextf)
ONE(log, double, next)
ONE(logf, float, nextf)
ONE(log2, double, next)
ONE(log2f, float, nextf)
ONE(log10, double, next)
ONE(log10f, float, nextf)
ONE(log1p, double, next)
ONE(log1pf, float, nextf)
ONE(cbrt, double, next)
ONE(cbrtf, float, nextf)
ONE(tgamma, double, next)
ONE(tgammaf, float, nextf)
ONE(lgamma, double, next)
ONE(lgammaf, float, nextf)
ONE(erf, double, next)
ONE(erff, float, nextf)
ONE(erfc, double, next)
ONE(erfcf, float, nextf)
TWO(pow, double, next)
TWO(powf, float, nextf)
TWO(atan2, double, next)
TWO(atan2f, float, nextf)
TWO(hypot, double, next)
TWO(hypotf, float, nextf)
BOTH(sincos, double, next)
BOTH(sincosf, float, nextf)
