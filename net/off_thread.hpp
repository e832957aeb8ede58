#pragma once

#include <asio/awaitable.hpp>
#include <asio/co_spawn.hpp>
#include <asio/thread_pool.hpp>
#include <asio/use_awaitable.hpp>
#include <optional>
#include <type_traits>

namespace mien::net {

/// Runs a copy of `work` on the pool and comes back to the caller's own thread with what it returned. `work` is taken by
/// reference so that it has a name at the caller: GCC 12 copies a nameless closure inside a co_await expression byte by
/// byte, and its captures die twice.
template <class Work>
asio::awaitable<std::invoke_result_t<const Work&>> off_thread(asio::thread_pool& pool, const Work& work) {
    using Value = std::invoke_result_t<const Work&>;
    // An optional, because co_spawn needs a value to pass beside an exception.
    const auto job = [](Work copy) -> asio::awaitable<std::optional<Value>> { co_return std::optional<Value>(copy()); };
    asio::awaitable<std::optional<Value>> started = job(work);
    std::optional<Value> value = co_await asio::co_spawn(pool.get_executor(), std::move(started), asio::use_awaitable);
    co_return std::move(*value);
}

}  // namespace mien::net
