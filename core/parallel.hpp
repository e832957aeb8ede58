#pragma once

#include <cstdint>
#include <functional>

namespace mien {

/// Threads that parallel_for uses: the machine's cores unless set_thread_count() said otherwise.
int thread_count();
void set_thread_count(int threads);  ///< 0: back to the machine's cores

/// Calls body(i) once for every 0 <= i < count, on several threads; returns when all are done. Which thread runs which
/// i is not fixed, so results must go to places of their own. The first exception is thrown again here.
void parallel_for(std::int64_t count, const std::function<void(std::int64_t)>& body);

}  // namespace mien
