#include "net/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/signal_set.hpp>
#include <asio/use_awaitable.hpp>
#include <csignal>
#include <mutex>
#include <thread>

#include "core/environment_error.hpp"
#include "net/viewer.hpp"

namespace mien::net {

namespace {

constexpr std::size_t kMaxRefused = 32;                         // viewers above the cap that are still told so
constexpr auto kGoodbye = std::chrono::milliseconds(1500);      // for BYE to reach everyone
constexpr auto kAfterFailedAccept = std::chrono::milliseconds(100);  // out of descriptors: some will close

}  // namespace

struct Server::State {
    explicit State(ServerOptions o) : shared(std::move(o)), acceptor(io), signals(io) {}

    // Destroyed from the bottom up: what runs on `io` goes before it, and all of that before what viewers share.
    ServerShared shared;
    std::vector<std::weak_ptr<Viewer>> viewers;
    asio::io_context io{1};
    asio::ip::tcp::acceptor acceptor;
    asio::signal_set signals;
    std::thread thread;
    std::mutex stopping_mutex;
    bool stopping = false;                                      ///< on the io thread
    bool stopped = false;                                       ///< under stopping_mutex
    std::uint16_t port = 0;

    void listen();
    asio::awaitable<void> accept();
    asio::awaitable<void> shut_down();
    void begin_shutdown();
    std::size_t living();
};

void Server::State::listen() {
    const ServerOptions& options = shared.options;
    std::error_code error;
    const auto address = asio::ip::make_address(options.bind, error);
    if (error) throw EnvironmentError(fmt::format("'{}' is not an IP address to listen on", options.bind));
    const asio::ip::tcp::endpoint endpoint(address, options.port);
    const auto refuse = [&](const std::error_code& why) {
        const std::string place = fmt::format("{} port {}", options.bind, options.port);
        if (why == asio::error::address_in_use)
            throw EnvironmentError(fmt::format("{} is in use; stop the other server or choose another port", place));
        if (why == asio::error::access_denied)
            throw EnvironmentError(fmt::format("{} may not be used by this user; choose a port above 1023", place));
        throw EnvironmentError(fmt::format("cannot listen on {}: {}", place, why.message()));
    };
    acceptor.open(endpoint.protocol(), error);
    if (error) refuse(error);
    acceptor.set_option(asio::socket_base::reuse_address(true), error);
    acceptor.bind(endpoint, error);
    if (error) refuse(error);
    acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) refuse(error);
    port = acceptor.local_endpoint().port();
}

std::size_t Server::State::living() {
    std::erase_if(viewers, [](const std::weak_ptr<Viewer>& viewer) { return viewer.expired(); });
    return viewers.size();
}

asio::awaitable<void> Server::State::accept() {
    asio::steady_timer pause(io);
    while (!stopping) {
        std::error_code error;
        asio::ip::tcp::socket socket =
            co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, error));
        if (stopping) co_return;
        if (error) {
            shared.log(fmt::format("a viewer could not be let in: {}", error.message()));
            pause.expires_after(kAfterFailedAccept);
            co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
            continue;
        }
        const std::size_t present = living();
        const std::size_t most = shared.options.max_viewers;
        if (present >= most + kMaxRefused) {
            ++shared.refused;
            continue;  // closes the socket
        }
        const auto viewer = std::make_shared<Viewer>(std::move(socket), shared, ++shared.accepted);
        viewers.push_back(viewer);
        viewer->start();
        if (present >= most) {
            ++shared.refused;
            viewer->close_with(protocol::Failure{protocol::FailureCode::busy, fmt::format("{} viewers are already here", most)});
        }
    }
}

asio::awaitable<void> Server::State::shut_down() {
    std::error_code ignored;
    acceptor.close(ignored);
    signals.cancel(ignored);
    for (const auto& weak : viewers)
        if (const auto viewer = weak.lock()) viewer->close_with(protocol::Bye{});
    const auto deadline = Clock::now() + kGoodbye;
    asio::steady_timer pause(io);
    while (living() > 0 && Clock::now() < deadline) {
        pause.expires_after(std::chrono::milliseconds(5));
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    }
    for (const auto& weak : viewers)
        if (const auto viewer = weak.lock()) viewer->drop("the server stopped");
    io.stop();
}

void Server::State::begin_shutdown() {
    if (std::exchange(stopping, true)) return;
    asio::co_spawn(io, shut_down(), asio::detached);
}

Server::Server(ServerOptions options) {
    std::error_code error;
    const auto folder = options.folder;
    if (!std::filesystem::is_directory(folder, error))
        throw EnvironmentError(fmt::format("{} is not a folder to serve", folder.string()));
    state_ = std::make_unique<State>(std::move(options));
    state_->listen();
    asio::co_spawn(state_->io, state_->accept(), asio::detached);
}

Server::~Server() {
    if (!state_) return;
    stop();
    // What the disk still brings goes back through `io`, so it must be here before that goes.
    state_->shared.files.join();
}

std::uint16_t Server::port() const { return state_->port; }

std::vector<std::string> Server::streams() const {
    std::vector<std::string> names;
    for (const auto& entry : state_->shared.library.list().streams) names.push_back(entry.name);
    return names;
}

std::vector<std::string> Server::incomplete() const { return state_->shared.library.list().incomplete; }
std::vector<std::string> Server::unreadable() const { return state_->shared.library.list().unreadable; }

void Server::start() {
    state_->thread = std::thread([this] { state_->io.run(); });
}

void Server::run_until_signal() {
    State& state = *state_;
    state.signals.add(SIGINT);
    state.signals.add(SIGTERM);
    state.signals.async_wait([&state](const std::error_code& error, int) {
        if (!error) state.begin_shutdown();
    });
    state.io.run();
}

void Server::stop() {
    State& state = *state_;
    const std::lock_guard lock(state.stopping_mutex);
    if (std::exchange(state.stopped, true)) return;
    asio::post(state.io, [&state] { state.begin_shutdown(); });
    if (state.thread.joinable()) state.thread.join();
}

ServerStatistics Server::statistics() const {
    const ServerShared& s = state_->shared;
    return {s.viewers, s.accepted, s.refused, s.groups_sent, s.blobs_sent, s.bytes_sent, s.queued_bytes, s.peak_viewer_bytes};
}

}  // namespace mien::net
