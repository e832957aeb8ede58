#include "net/stream_list.hpp"

#include <fmt/format.h>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>

#include "net/connection.hpp"

namespace mien::net {
namespace {

asio::awaitable<void> ask_for_list(Url url, ConnectionPtr c, Result<std::vector<protocol::StreamEntry>>& answer) {
    const auto give_up = [&](const std::string& why) { answer = Error{ErrorCode::unavailable, why}; };
    if (const auto failed = co_await connect(c, url)) co_return give_up(failed->reason);
    Bytes questions = protocol::encode(protocol::Hello{protocol::kWireVersion, "mien"});
    const Bytes list_please = protocol::encode(protocol::ListStreams{});
    questions.insert(questions.end(), list_please.begin(), list_please.end());
    const auto sent = co_await c->wire.write(questions);
    if (!sent) co_return give_up(sent.error().message);
    const auto read = [&]() -> asio::awaitable<Result<protocol::Message>> {
        const auto raw = co_await c->wire.read(protocol::kMaxMessageBytes);
        if (!raw) co_return raw.error();
        co_return protocol::parse_body(raw->type, raw->body);
    };
    const auto hello = co_await read();
    if (const auto foreign = not_a_server(*c, url, hello)) co_return give_up(foreign->reason);
    auto message = co_await read();
    if (!message) co_return give_up(message.error().message);
    auto* list = std::get_if<protocol::StreamList>(&*message);
    if (!list) co_return give_up(unexpected(*message, "its list of streams").reason);
    answer = std::move(list->streams);
    co_await c->wire.write(protocol::encode(protocol::Bye{}));
}

}  // namespace

Result<std::vector<protocol::StreamEntry>> list_streams(const Url& url, std::chrono::milliseconds timeout) {
    Result<std::vector<protocol::StreamEntry>> answer =
        Error{ErrorCode::unavailable, fmt::format("{} did not answer in time", to_string(url))};
    asio::io_context io(1);
    const auto c = std::make_shared<Connection>(asio::ip::tcp::socket(io));
    asio::co_spawn(io, ask_for_list(url, c, answer), asio::detached);
    io.run_for(timeout);
    return answer;
}

}  // namespace mien::net
