#include <fmt/format.h>

#include <atomic>
#include <random>

#include "harness.hpp"
#include "net/publisher.hpp"

/// Viewers that are slow, dead, rude or gone, and connections that break.
namespace mien::net {
namespace {

using namespace harness;
using protocol::sample::make_stream;

/// Says HELLO, OPEN and PLAY (unpaced) and takes the answers up to PLAYING.
void begin_play(RawSocket& socket) {
    ASSERT_TRUE(socket.send(protocol::Hello{protocol::kWireVersion, "test"}));
    ASSERT_TRUE(socket.send(protocol::Open{"take"}));
    ASSERT_TRUE(socket.send(protocol::Play{0, 0, 0}));
    for (;;) {
        const auto message = socket.receive();
        ASSERT_TRUE(message.has_value());
        if (std::holds_alternative<protocol::Playing>(*message)) return;
    }
}

TEST(Trouble, ASlowViewerCostsOneGroupOfMemoryAndNobodyElseWaits) {
    // 100 groups of about 1 MB: the sockets' buffers hold a few of them.
    const Served served(make_stream(33, 30000));
    std::size_t largest = 0;
    for (const auto& group : served.stream.groups) largest = std::max(largest, protocol::encode(group).size());
    RawSocket slow(served.server->port());
    slow.shrink_receive_buffer();
    begin_play(slow);
    ASSERT_TRUE(wait_until([&] { return served.server->statistics().queued_bytes > 0; }));

    Client quick(served.url(), unpaced());
    expect_groups(play_all(quick), served.stream);
    const ServerStatistics statistics = served.server->statistics();
    EXPECT_EQ(statistics.viewers, 2u);
    EXPECT_LE(statistics.peak_viewer_bytes, largest + 4096);
}

TEST(Trouble, APlayerThatDoesNotTakeGroupsHoldsABoundedQueue) {
    const Served served(make_stream(33, 30000));
    SourceOptions options = unpaced();
    options.queue_bytes = 3 << 20;
    Client client(served.url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    std::uint64_t before = 0;
    // Wait until nothing more comes in.
    ASSERT_TRUE(wait_until([&] {
        const std::uint64_t now = client.statistics().bytes;
        const bool still = now > options.queue_bytes && now == std::exchange(before, now);
        std::this_thread::sleep_for(50ms);
        return still;
    }));
    EXPECT_LE(client.statistics().bytes, options.queue_bytes + (3u << 20));
    expect_groups(play_all(client), served.stream);
}

TEST(Trouble, ACutConnectionGoesOnWhereItWas) {
    const Served served(make_stream(12, 2000));
    Proxy proxy(served.server->port());
    proxy.cut_after(300000);  // of about 900 kB
    SourceOptions options = unpaced();
    std::mutex mutex;
    std::vector<SourceStatus> states;
    options.on_status = [&](const SourceStatus& status) {
        const std::lock_guard lock(mutex);
        states.push_back(status);
    };
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    expect_groups(play_all(client), served.stream);
    EXPECT_GE(client.statistics().reconnects, 2u);
    EXPECT_GE(proxy.connections(), 3);
    EXPECT_EQ(client.statistics().blobs_fetched, served.stream.blobs.size()) << "blobs are fetched once, not once a connection";
    const std::lock_guard lock(mutex);
    const auto reconnecting = std::ranges::find(states, SourceState::reconnecting, &SourceStatus::state);
    ASSERT_NE(reconnecting, states.end());
    EXPECT_FALSE(reconnecting->reason.empty());
    EXPECT_EQ(states.back().state, SourceState::ended);
}

TEST(Trouble, ManyCutsAtRandomPlacesLoseNothing) {
    const Served served(make_stream(10, 300));
    Proxy proxy(served.server->port());
    Client client({"127.0.0.1", proxy.port(), "take"}, unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    std::mt19937 random(3);
    std::vector<Arrival> all;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end && (all.empty() || all.back().group)) {
        if (all.size() < 25 && random() % 3 == 0) {
            proxy.cut_after(2000 + random() % 20000);
            proxy.cut();
        } else if (all.size() >= 25) {
            proxy.cut_after(0);
        }
        if (auto arrival = client.next(20ms)) all.push_back(std::move(*arrival));
    }
    expect_groups(all, served.stream);
}

TEST(Trouble, OnlyReconnectionsThatSucceedAreCounted) {
    const Served served(make_stream(10, 300));
    Proxy proxy(served.server->port());
    SourceOptions options = unpaced();
    options.rate = 1;
    std::atomic<int> tries = 0;
    options.on_status = [&](const SourceStatus& status) { tries += status.state == SourceState::reconnecting; };
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    proxy.refuse(true);
    proxy.cut();
    ASSERT_TRUE(wait_until([&] { return tries >= 4; }));
    EXPECT_EQ(client.statistics().reconnects, 0u);
    proxy.refuse(false);
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::playing; }));
    EXPECT_EQ(client.statistics().reconnects, 1u);
}

TEST(Trouble, SeeksDuringAnOutageCountAfterIt) {
    const Served served(make_stream(10, 300));
    Proxy proxy(served.server->port());
    SourceOptions options = unpaced();
    options.rate = 1;   // the end has not come when the line is cut: after it there would be nothing to reconnect for
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    proxy.refuse(true);
    proxy.cut();
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::reconnecting; }));
    client.seek(8);
    proxy.refuse(false);
    expect_groups(play_all(client), served.stream, 8 * 3);
}

TEST(Trouble, AHalfOpenConnectionIsNoticedByBothSides) {
    ServerOptions server;
    server.idle_timeout = 1500ms;
    const Served served(make_stream(40), server);
    Proxy proxy(served.server->port());
    SourceOptions options = unpaced();
    options.rate = 1;
    options.ping_interval = 100ms;
    options.silence_timeout = 1500ms;
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    // Pings alone keep a connection alive.
    std::this_thread::sleep_for(2s);
    EXPECT_EQ(client.status().state, SourceState::playing);
    EXPECT_GT(client.statistics().round_trip, 0);
    proxy.freeze(true);
    EXPECT_TRUE(wait_until([&] { return client.status().state == SourceState::reconnecting; }));
    EXPECT_TRUE(wait_until([&] { return served.server->statistics().viewers == 0; }));
    proxy.freeze(false);
    EXPECT_TRUE(wait_until([&] { return client.status().state == SourceState::playing; }));
}

TEST(Trouble, AViewerThatNeverSaysHelloIsShownOut) {
    ServerOptions server;
    server.handshake_timeout = 100ms;
    const Served served(make_stream(1), server);
    RawSocket silent(served.server->port());
    const auto message = silent.receive();
    ASSERT_TRUE(message.has_value());
    ASSERT_TRUE(std::holds_alternative<protocol::Failure>(*message));
    EXPECT_EQ(std::get<protocol::Failure>(*message).code, protocol::FailureCode::timeout);
    EXPECT_TRUE(silent.closed_by_peer());
}

TEST(Trouble, GarbageOnlyHurtsWhoSentIt) {
    const Served served(make_stream(6));
    Client watching(served.url(), unpaced());
    ASSERT_TRUE(watching.wait_ready(kPatience).ok());
    std::mt19937 random(11);
    for (int r = 0; r < 60; ++r) {
        RawSocket rude(served.server->port());
        if (r % 2) (void)rude.send(protocol::Hello{protocol::kWireVersion, "test"});
        (void)rude.send(protocol::sample::noise(1 + random() % 3000, random()));
    }
    // Every message of ours, whole, but not where it belongs; and heads that announce far too much.
    for (int type = 0; type < 256; ++type) {
        RawSocket rude(served.server->port());
        (void)rude.send(protocol::Hello{protocol::kWireVersion, "test"});
        (void)rude.send(protocol::sample::literal({type, 0xff, 0xff, 0xff, 0x7f, 1, 2, 3}));
    }
    expect_groups(play_all(watching), served.stream);
    EXPECT_TRUE(wait_until([&] { return served.server->statistics().viewers <= 1; }));
    Client after(served.url(), unpaced());
    expect_groups(play_all(after), served.stream);
}

TEST(Trouble, SaysWhatWasWrongBeforeItCloses) {
    const Served served(make_stream(1));
    const auto answer = [&](const std::vector<Bytes>& questions) {
        RawSocket socket(served.server->port());
        for (const Bytes& question : questions) EXPECT_TRUE(socket.send(question));
        for (;;) {
            const auto message = socket.receive();
            if (!message) return protocol::Failure{protocol::FailureCode::busy, "closed without a word"};
            if (const auto* failure = std::get_if<protocol::Failure>(&*message)) return *failure;
        }
    };
    using protocol::FailureCode;
    const Bytes hello = protocol::encode(protocol::Hello{protocol::kWireVersion, "test"});
    const Bytes open = protocol::encode(protocol::Open{"take"});
    const auto version = answer({protocol::encode(protocol::Hello{99, "test"})});
    EXPECT_EQ(version.code, FailureCode::version);
    EXPECT_NE(version.text.find("99"), std::string::npos) << version.text;
    EXPECT_EQ(answer({open}).code, FailureCode::protocol);
    EXPECT_EQ(answer({hello, protocol::encode(protocol::Play{})}).code, FailureCode::protocol);
    EXPECT_EQ(answer({hello, protocol::encode(protocol::Open{"x"})}).code, FailureCode::no_such_stream);
    EXPECT_EQ(answer({hello, open, protocol::encode(protocol::Want{{Hash{}}})}).code, FailureCode::no_such_blob);
    EXPECT_EQ(answer({hello, open, protocol::encode(protocol::Seek{})}).code, FailureCode::protocol);
    EXPECT_EQ(answer({hello, protocol::encode(served.stream.groups[0])}).code, FailureCode::protocol);
    EXPECT_EQ(answer({hello, protocol::sample::literal({0x23, 0x80})  , protocol::sample::literal({0x80, 0x80, 0x80, 0x80})}).code, FailureCode::protocol);
}

TEST(Trouble, ViewersAboveTheCapAreTold) {
    ServerOptions options;
    options.max_viewers = 2;
    const Served served(make_stream(1), options);
    RawSocket first(served.server->port()), second(served.server->port());
    begin_play(first);
    begin_play(second);
    RawSocket third(served.server->port());
    const auto message = third.receive();
    ASSERT_TRUE(message && std::holds_alternative<protocol::Failure>(*message));
    EXPECT_EQ(std::get<protocol::Failure>(*message).code, protocol::FailureCode::busy);
    EXPECT_EQ(served.server->statistics().refused, 1u);
}

TEST(Trouble, StoppingWhileItStreamsSaysByeAndTakesNoTime) {
    Served served(make_stream(33, 30000));
    RawSocket slow(served.server->port());
    begin_play(slow);
    SourceOptions options = unpaced();
    options.rate = 1;
    Client client(served.url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    served.server->stop();
    EXPECT_TRUE(slow.closed_by_peer());
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::reconnecting; }));
    served.server->stop();  // again, harmless
}

TEST(Trouble, ARestartedServerIsFoundAgain) {
    auto served = std::make_unique<Served>(make_stream(10, 3000));
    SourceOptions options = unpaced();
    options.rate = 1;
    Client client(served->url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    std::vector<Arrival> all;
    while (all.size() < 6)
        if (auto arrival = client.next(100ms)) all.push_back(std::move(*arrival));
    ServerOptions again;
    again.port = served->server->port();
    again.folder = served->folder.path();
    served->server->stop();
    served->server.reset();
    served->server = std::make_unique<Server>(again);
    served->server->start();
    client.set_rate(0);
    for (Arrival& arrival : play_all(client)) all.push_back(std::move(arrival));
    expect_groups(all, served->stream);
}

TEST(Trouble, AnotherStreamUnderTheNameIsNotMixedIn) {
    const Served served(make_stream(10, 3000));
    Proxy proxy(served.server->port());
    SourceOptions options = unpaced();
    options.rate = 1;
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    served.folder.write("take.mien", protocol::sample::file_of(make_stream(3, 100, 77)));
    proxy.cut();
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::failed; }));
    EXPECT_NE(client.status().reason.find("another one"), std::string::npos) << client.status().reason;
}

/// Whoever connects hears these bytes, and then nothing.
class ForeignServer {
public:
    explicit ForeignServer(std::string words) : words_(std::move(words)), thread_([this] {
        RawSocket viewer = server_.accept();
        viewer.send(protocol::sample::bytes_of(words_));
    }) {}
    ~ForeignServer() { thread_.join(); }
    Url url() const { return {"127.0.0.1", server_.port(), "take"}; }
    std::string complaint() const { return fmt::format("127.0.0.1:{} does not answer as a mien server", server_.port()); }

private:
    RawServer server_;
    std::string words_;
    std::thread thread_;
};

TEST(Trouble, AServerOfAnotherKindIsNamedAsSuch) {
    for (const char* words : {"\x1c\x02xx", "HTTP/1.1 400 Bad Request\r\nContent-Length: 400\r\n\r\nThis is a page about requests that are bad, as long as it has to be.", ""}) {
        SourceOptions options = unpaced();
        options.max_attempts = 1;
        const ForeignServer played(words), listed(words), published(words);
        Client client(played.url(), options);
        const auto ready = client.wait_ready(kPatience);
        ASSERT_FALSE(ready.ok());
        EXPECT_TRUE(ready.error().message.starts_with(played.complaint())) << ready.error().message;
        const auto list = list_streams(listed.url(), kPatience);
        ASSERT_FALSE(list.ok());
        EXPECT_TRUE(list.error().message.starts_with(listed.complaint())) << list.error().message;
        protocol::StreamHeader header = make_stream(1).header;
        header.frames = 0;
        Publisher publisher(published.url(), header, {}, {});
        const auto taken = publisher.wait_ready(kPatience);
        ASSERT_FALSE(taken.ok());
        EXPECT_TRUE(taken.error().message.starts_with(published.complaint())) << taken.error().message;
    }
}

TEST(Trouble, WhoGivesUpSaysOnWhomAndAfterHowManyTries) {
    const Served served(make_stream(1));
    Proxy proxy(served.server->port());
    proxy.refuse(true);
    SourceOptions options = unpaced();
    options.max_attempts = 3;
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::failed; }));
    EXPECT_TRUE(client.status().reason.starts_with(fmt::format("gave up on mien://127.0.0.1:{}/take after 3 tries: ", proxy.port()))) << client.status().reason;
}

TEST(Trouble, WhoLeavesSaysBye) {
    RawServer server;
    std::vector<protocol::Message> heard;
    std::thread listener([&] {
        RawSocket viewer = server.accept();
        viewer.send(protocol::Hello{protocol::kWireVersion, "test"});
        viewer.send(protocol::StreamList{});
        while (auto message = viewer.receive()) heard.push_back(std::move(*message));
    });
    EXPECT_TRUE(list_streams({"127.0.0.1", server.port(), ""}, kPatience).ok());
    listener.join();
    ASSERT_FALSE(heard.empty());
    EXPECT_TRUE(std::holds_alternative<protocol::Bye>(heard.back()));
}

TEST(Trouble, AClientThatIsDestroyedWhileConnectingReturns) {
    const Served served(make_stream(1));
    Proxy proxy(served.server->port());
    proxy.freeze(true);
    const auto begun = std::chrono::steady_clock::now();
    for (int i = 0; i < 5; ++i) Client client({"127.0.0.1", proxy.port(), "take"}, unpaced());
    EXPECT_LT(std::chrono::steady_clock::now() - begun, kPatience);
}

TEST(Trouble, APortInUseAndAMissingFolderAreNamed) {
    const Served served(make_stream(1));
    ServerOptions options;
    options.folder = served.folder.path();
    options.port = served.server->port();
    const auto complaint = [](const ServerOptions& o) -> std::string {
        try {
            const Server server(o);
            return "";
        } catch (const EnvironmentError& e) {
            return e.what();
        }
    };
    EXPECT_NE(complaint(options).find("in use"), std::string::npos) << complaint(options);
    options.folder = "/nowhere/at/all";
    EXPECT_NE(complaint(options).find("/nowhere/at/all"), std::string::npos) << complaint(options);
    options.folder = served.folder.path();
    options.bind = "not an address";
    EXPECT_NE(complaint(options).find("not an address"), std::string::npos) << complaint(options);
}

}  // namespace
}  // namespace mien::net
