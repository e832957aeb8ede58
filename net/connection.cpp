#include "net/connection.hpp"

#include <fmt/format.h>

#include <asio/connect.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

namespace mien::net {

using asio::ip::tcp;

asio::awaitable<std::optional<Lost>> connect(ConnectionPtr c, const Url& url) {
    std::error_code error;
    tcp::resolver resolver(c->wire.socket().get_executor());
    const std::string port = std::to_string(url.port);
    const auto endpoints =
        co_await resolver.async_resolve(url.host, port, asio::redirect_error(asio::use_awaitable, error));
    if (c->closed) co_return Lost{c->reason, false};
    if (error) co_return Lost{fmt::format("the host {} is not known: {}", url.host, error.message()), false};
    co_await asio::async_connect(c->wire.socket(), endpoints, asio::redirect_error(asio::use_awaitable, error));
    if (c->closed) co_return Lost{c->reason, false};
    if (error) co_return Lost{fmt::format("cannot connect to {} port {}: {}", url.host, url.port, error.message()), false};
    c->wire.socket().set_option(tcp::no_delay(true), error);
    c->wire.hear();
    co_return std::nullopt;
}

namespace {

Lost refused(const protocol::Failure& failure) {
    using protocol::FailureCode;
    const bool may_pass =
        failure.code == FailureCode::busy || failure.code == FailureCode::shutting_down || failure.code == FailureCode::timeout ||
        failure.code == FailureCode::name_taken;   // a connection that broke may hold it for a while
    return {"the server says: " + failure.text, !may_pass, failure.code == FailureCode::no_such_stream};
}

}  // namespace

std::optional<Lost> not_a_server(const Connection& c, const Url& url, const Result<protocol::Message>& hello) {
    const auto foreign = [&](const std::string& why, bool for_good) {
        return Lost{fmt::format("{}:{} does not answer as a mien server ({})", url.host, url.port, why), for_good};
    };
    if (hello.ok()) {
        if (std::holds_alternative<protocol::Hello>(*hello)) return std::nullopt;
        if (std::holds_alternative<protocol::Failure>(*hello) || std::holds_alternative<protocol::Bye>(*hello)) return unexpected(*hello, "HELLO");
        return foreign("it does not begin with HELLO", true);
    }
    if (c.closed) return Lost{c.reason, false};
    if (hello.error().code == ErrorCode::unsupported_version) return Lost{hello.error().message, true};
    // A server of another kind stays what it is however often we ask; one that hung up may have been about to stop.
    return foreign(hello.error().message, hello.error().code != ErrorCode::unavailable);
}

Lost unexpected(const protocol::Message& message, std::string_view expected) {
    if (const auto* failure = std::get_if<protocol::Failure>(&message)) return refused(*failure);
    if (std::holds_alternative<protocol::Bye>(message)) return {"the server stopped", false};
    return {fmt::format("the server did not send {}", expected), true};
}

}  // namespace mien::net
