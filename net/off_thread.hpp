#pragma once

#include <asio/awaitable.hpp>
#include <asio/co_spawn.hpp>
#include <asio/thread_pool.hpp>
#include <asio/use_awaitable.hpp>
#include <optional>
#include <type_traits>

namespace mien::net {

/// Runs `work` on the pool and comes back to the caller's own thread with what it returned.
template <class Work>
asio::awaitable<std::invoke_result_t<Work>> off_thread(asio::thread_pool& pool, Work work) {
    using Value = std::invoke_result_t<Work>;
    // An optional, because co_spawn needs a value to pass beside an exception.
    auto job = [](Work inner) -> asio::awaitable<std::optional<Value>> { co_return std::optional<Value>(inner()); };
    std::optional<Value> value = co_await asio::co_spawn(pool.get_executor(), job(std::move(work)), asio::use_awaitable);
    co_return std::move(*value);
}

}  // namespace mien::net
