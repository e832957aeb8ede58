#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <mutex>
#include <thread>

#include "player/playback.hpp"
#include "small_stream.hpp"

extern char** environ;

namespace mien::player {
namespace {

using namespace std::chrono_literals;

/// A mien-serve of its own, which can be killed without a last word.
class ServerProcess {
public:
    explicit ServerProcess(const std::filesystem::path& folder, int port = 0) {
        int ends[2];
        if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
        posix_spawn_file_actions_addclose(&actions, ends[0]);
        std::vector<std::string> words{MIEN_BINARY_DIR "/mien-serve", folder.string(), "--port", std::to_string(port), "--ahead", "0.5"};
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        const int failed = ::posix_spawn(&process_, arguments.front(), &actions, nullptr, arguments.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        output_ = ends[0];
        if (failed) throw std::runtime_error("mien-serve does not start");
        const std::string before = "listening on mien://127.0.0.1:";
        char letter = 0;
        while (said_.find(before) == std::string::npos || letter != '\n') {
            if (::read(output_, &letter, 1) != 1) throw std::runtime_error("mien-serve says: " + said_);
            said_ += letter;
        }
        port_ = std::stoi(said_.substr(said_.find(before) + before.size()));
    }
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;
    ~ServerProcess() {
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
        ::close(output_);
    }
    int port() const { return port_; }

private:
    pid_t process_ = 0;
    int output_ = -1, port_ = 0;
    std::string said_;
};

bool wait_until(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + 30s;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(1ms);
    }
    return true;
}

TEST(Reconnect, APlaybackGoesOnWhereItWasWhenItsServerIsKilledAndComesBack) {
    const TemporaryFolder folder;
    store(small_stream(true, false), folder);
    auto server = std::make_unique<ServerProcess>(folder.path());
    const int port = server->port();

    std::mutex mutex;
    std::vector<net::SourceStatus> states;
    SessionOptions options;
    options.sound = false;
    options.wait = 30;
    options.source.first_backoff = 10ms;
    options.source.last_backoff = 100ms;
    options.source.on_status = [&](const net::SourceStatus& status) {
        const std::lock_guard lock(mutex);
        states.push_back(status);
    };
    auto session = open_session("mien://127.0.0.1:" + std::to_string(port) + "/ball", options);
    ASSERT_TRUE(session.ok()) << session.error().message;
    Playback playback(std::move(*session), nullptr, false);
    const DecodeThread& decode = *playback.session().decode;
    const net::StreamSource& source = *playback.session().source;

    // Time is ours and goes on in steps of a 60 Hz screen.
    double now = 1000;
    std::vector<std::int64_t> shown;
    const auto tick = [&] {
        if (const auto frame = playback.tick(now)) shown.push_back(frame->frame);
        now += 1 / 60.0;
    };
    while (shown.size() < 4) {
        ASSERT_TRUE(wait_until([&] { return decode.ready() || !decode.empty(); }));
        tick();
    }
    server.reset();
    ASSERT_TRUE(wait_until([&] { return source.status().state == net::SourceState::reconnecting; }));
    EXPECT_FALSE(source.status().reason.empty()) << "the player says why";

    // What has come is shown, then the picture stands: the clock does not run away from the stream.
    for (int i = 0; i < 120; ++i) {
        ASSERT_TRUE(wait_until([&] { return decode.ready() || decode.starved(); }));
        tick();
    }
    EXPECT_TRUE(playback.waiting());
    EXPECT_FALSE(playback.ended());
    EXPECT_EQ(playback.stalls(), 1u);
    ASSERT_LT(shown.size(), std::size_t(kFrames)) << "the server had sent everything before it was killed";

    server = std::make_unique<ServerProcess>(folder.path(), port);
    ASSERT_TRUE(wait_until([&] { return source.status().state == net::SourceState::playing; }));
    const auto end = std::chrono::steady_clock::now() + 60s;
    while (!playback.ended()) {
        ASSERT_LT(std::chrono::steady_clock::now(), end) << "shown " << shown.size() << " frames";
        ASSERT_TRUE(wait_until([&] { return decode.ready() || decode.drained() || !decode.empty(); }));
        tick();
    }
    std::vector<std::int64_t> every;
    for (std::int64_t f = 0; f < kFrames; ++f) every.push_back(f);
    EXPECT_EQ(shown, every) << "each frame once and in order, as without the outage";
    EXPECT_EQ(decode.dropped(), 0u);
    EXPECT_EQ(decode.damaged_groups(), 0u);
    const net::SourceStatistics statistics = source.statistics();
    EXPECT_GE(statistics.reconnects, 1u);
    EXPECT_EQ(statistics.blobs_fetched, source.catalogue().blobs.size()) << "no blob is fetched again";
    const std::lock_guard lock(mutex);
    EXPECT_EQ(states.back().state, net::SourceState::ended);
}

}  // namespace
}  // namespace mien::player
