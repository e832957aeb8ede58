#pragma once

/// Loops that the compiler turns into vector instructions by itself, built twice: for every processor, and for those with
/// AVX2, chosen at run time. Without fused multiplication both give the same numbers to the last bit.
///
///     MIEN_LOOP add_loop(const float* a, float* sum, int n) { for (int i = 0; i < n; ++i) sum[i] += a[i]; }
///     MIEN_WIDE(add, (const float* a, float* sum, int n), (a, sum, n))     // makes add(a, sum, n)
#define MIEN_LOOP [[gnu::always_inline]] inline void
#if defined(__x86_64__)
#define MIEN_WIDE(name, parameters, arguments)                                     \
    [[gnu::target("avx2")]] void name##_avx2 parameters { name##_loop arguments; } \
    void name parameters {                                                         \
        static const bool wide = __builtin_cpu_supports("avx2");                   \
        if (wide) name##_avx2 arguments;                                           \
        else name##_loop arguments;                                                \
    }
#else
#define MIEN_WIDE(name, parameters, arguments) \
    void name parameters { name##_loop arguments; }
#endif
