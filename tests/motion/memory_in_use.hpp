#pragma once

#include <malloc.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>

// GCC's way and clang's; other headers may define __has_feature for compilers that lack it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MIEN_SANITIZER_HEAP 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MIEN_SANITIZER_HEAP 1
#endif
#endif
#ifdef MIEN_SANITIZER_HEAP
// Of <sanitizer/allocator_interface.h>, which GCC does not bring along everywhere.
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace mien::motion_test {

/// Sanitizers keep what was freed for a while, so there only the heap tells whether a program grows.
#ifdef MIEN_SANITIZER_HEAP
inline constexpr bool kResidentTells = false;
#else
inline constexpr bool kResidentTells = true;
#endif

/// Bytes that were allocated and not freed.
inline std::int64_t heap_in_use() {
#ifdef MIEN_SANITIZER_HEAP
    return std::int64_t(__sanitizer_get_current_allocated_bytes());
#else
    const struct mallinfo2 heap = mallinfo2();
    return std::int64_t(heap.uordblks + heap.hblkhd);
#endif
}

/// Bytes of the process that lie in memory.
inline std::int64_t resident() {
    long long pages = 0, in_memory = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(file, "%lld %lld", &pages, &in_memory) != 2) in_memory = 0;
        std::fclose(file);
    }
    return in_memory * sysconf(_SC_PAGESIZE);
}

}  // namespace mien::motion_test
