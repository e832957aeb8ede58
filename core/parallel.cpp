#include "core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace mien {
namespace {
std::atomic<int> wanted_threads{0};
}

int thread_count() {
    const int wanted = wanted_threads.load();
    return wanted > 0 ? wanted : std::max(1, int(std::thread::hardware_concurrency()));
}

void set_thread_count(int threads) { wanted_threads = std::max(0, threads); }

void parallel_for(std::int64_t count, const std::function<void(std::int64_t)>& body) {
    const int workers = int(std::min<std::int64_t>(thread_count(), count));
    if (workers <= 1) {
        for (std::int64_t i = 0; i < count; ++i) body(i);
        return;
    }
    std::atomic<std::int64_t> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&] {
        try {
            for (std::int64_t i; (i = next.fetch_add(1)) < count;) body(i);
        } catch (...) {
            next = count;
            const std::lock_guard lock(failure_mutex);
            if (!failure) failure = std::current_exception();
        }
    };
    std::vector<std::jthread> threads;
    for (int t = 1; t < workers; ++t) threads.emplace_back(work);
    work();
    threads.clear();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace mien
