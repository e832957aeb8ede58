#include "harness.hpp"
#include "net/publisher.hpp"

/// Live streams: publishers, and viewers that join, lag and come back.
namespace mien::net {
namespace {

using namespace harness;
using protocol::sample::noise;

constexpr int kObjects = 5;   // of a group

/// A header with one motion track, and its blobs.
Stream live_stream(std::uint32_t seed = 1) {
    Stream stream = protocol::sample::make_stream(0, 0, seed);
    stream.header.frames = 0;
    stream.header.tracks.resize(1);
    return stream;
}

Bytes object_bytes(int frame, std::size_t size = 20) { return noise(size, std::uint32_t(frame)); }

ServerOptions publishing() {
    ServerOptions options;
    options.publish = true;
    return options;
}

PublisherOptions quick() {
    PublisherOptions options;
    options.first_backoff = 10ms;
    options.last_backoff = 50ms;
    return options;
}

/// Sends frames with the numbers of its own count, in groups of kObjects.
struct Sender {
    Sender(const Served& served, const std::string& name = "face", std::uint32_t seed = 1) : Sender(served.url(name), seed) {}
    explicit Sender(Url url, std::uint32_t seed = 1) {
        const Stream stream = live_stream(seed);
        publisher.emplace(std::move(url), stream.header, stream.blobs, quick());
    }
    void send(int frames, std::size_t size = 20) {
        for (; frames > 0; --frames, ++frame) {
            if (frame % kObjects == 0) publisher->start_group({0, std::uint32_t(frame / kObjects), frame, 1});
            publisher->send({0, object_bytes(frame, size)});
        }
    }
    std::optional<Publisher> publisher;
    int frame = 0;
};

/// Takes `count` objects, or what comes until the end of the stream.
std::vector<protocol::LiveObject> take(StreamSource& source, std::size_t count) {
    std::vector<protocol::LiveObject> objects;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (objects.size() < count && std::chrono::steady_clock::now() < end) {
        auto arrival = source.next(50ms);
        if (!arrival) continue;
        if (arrival->is_end()) break;
        EXPECT_TRUE(arrival->object.has_value());
        if (arrival->object) objects.push_back(std::move(*arrival->object));
    }
    return objects;
}

bool ends(StreamSource& source) {
    return wait_until([&] {
        const auto arrival = source.next(20ms);
        return arrival && arrival->is_end();
    });
}

/// Frames `first`, first + 1, ... with the bytes of `first_own`, first_own + 1, ...
void expect_frames(const std::vector<protocol::LiveObject>& objects, std::int64_t first, int first_own) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const protocol::LiveObject& object = objects[i];
        const std::int64_t frame = first + std::int64_t(i);
        EXPECT_EQ(object.first_time, frame);
        EXPECT_EQ(object.index, std::uint32_t((first_own + int(i)) % kObjects)) << frame;
        EXPECT_EQ(object.object.frames, 1u);
        EXPECT_EQ(object.object.bytes, object_bytes(first_own + int(i), object.object.bytes.size())) << frame;
    }
}

/// HELLO and PUBLISH by hand; the answer to the latter.
std::optional<protocol::Message> offer(RawSocket& socket, const std::string& name) {
    EXPECT_TRUE(socket.send(protocol::Hello{protocol::kWireVersion, "test"}));
    EXPECT_TRUE(socket.send(protocol::Publish{name}));
    EXPECT_TRUE(std::holds_alternative<protocol::Hello>(*socket.receive()));
    const Stream stream = live_stream();
    protocol::Catalogue catalogue;
    for (const auto& blob : stream.blobs) catalogue.blobs.push_back({blob.hash, blob.kind, blob.bytes.size()});
    socket.send(stream.header);
    socket.send(catalogue);
    return socket.receive();
}

void expect_failure(const std::optional<protocol::Message>& message, protocol::FailureCode code) {
    ASSERT_TRUE(message.has_value());
    const auto* failure = std::get_if<protocol::Failure>(&*message);
    ASSERT_NE(failure, nullptr);
    EXPECT_EQ(failure->code, code) << failure->text;
}

TEST(Live, ViewersGetEveryObjectInOrderAsItComes) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Sender sender(served);
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    const auto list = list_streams(served.url(""));
    EXPECT_EQ(list->at(0).name, "face");
    EXPECT_TRUE(list->at(0).live);
    EXPECT_EQ(list->at(0).frames, 0u);
    EXPECT_FALSE(list->at(1).live);

    Client client(served.url("face"), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    EXPECT_TRUE(client.live());
    for (const auto& blob : live_stream().blobs) EXPECT_EQ(*client.blob(blob.hash), blob.bytes);
    for (int f = 0; f < 12; ++f) {
        sender.send(1);
        const auto one = take(client, 1);   // none waits for the next
        ASSERT_EQ(one.size(), 1u);
        expect_frames(one, f, f);
    }
    EXPECT_EQ(sender.publisher->statistics().objects, 12u);
    EXPECT_EQ(client.statistics().objects, 12u);
    sender.publisher.reset();
    EXPECT_TRUE(ends(client));
    EXPECT_EQ(client.status().state, SourceState::ended);
    EXPECT_EQ(list_streams(served.url(""))->size(), 1u);
}

TEST(Live, ALateViewerStartsAtTheNewestGroup) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Sender sender(served);
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Client first(served.url("face"), unpaced());
    sender.send(kObjects * 7 + 2);
    ASSERT_TRUE(first.wait_ready(kPatience).ok());
    ASSERT_TRUE(wait_until([&] { return sender.publisher->statistics().objects == kObjects * 7 + 2; }));
    take(first, 1);
    std::this_thread::sleep_for(50ms);
    Client late(served.url("face"), unpaced());
    const auto objects = take(late, 2);
    ASSERT_EQ(objects.size(), 2u);
    expect_frames(objects, kObjects * 7, kObjects * 7);
    sender.send(3);
    expect_frames(take(late, 3), kObjects * 7 + 2, kObjects * 7 + 2);
    // A seek leads there too, wherever it is meant to lead.
    const std::uint32_t generation = late.seek(0);
    const auto again = late.next(kPatience);
    ASSERT_TRUE(again && again->object);
    EXPECT_EQ(again->generation, generation);
    EXPECT_EQ(again->object->first_time, kObjects * 7);
}

TEST(Live, ALostPublisherEndsTheStreamAndAnotherGoesOnWithIt) {
    const Served served(protocol::sample::make_stream(1), publishing());
    std::optional<Sender> sender(std::in_place, served);
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    Client client(served.url("face"), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender->send(1);
    expect_frames(take(client, 1), 0, 0);   // a viewer that plays gets all; one that comes begins at the newest group
    sender->send(6);
    expect_frames(take(client, 6), 1, 1);
    sender.reset();
    EXPECT_TRUE(ends(client));
    EXPECT_EQ(client.status().state, SourceState::ended);

    sender.emplace(served);
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    sender->send(7);
    const auto objects = take(client, 7);
    ASSERT_EQ(objects.size(), 7u);
    expect_frames(objects, 7, 0);                       // its own frame 0 is the stream's frame 7
    EXPECT_EQ(objects.front().group, 2u);               // behind the two groups there were
    EXPECT_EQ(client.status().state, SourceState::playing);
    EXPECT_EQ(client.statistics().reconnects, 0u);
}

TEST(Live, APublisherThatIsCutOffComesBackByItself) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Proxy proxy(served.server->port());
    Sender sender(Url{"127.0.0.1", proxy.port(), "face"});
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Client client(served.url("face"), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender.send(1);
    expect_frames(take(client, 1), 0, 0);
    sender.send(7);
    expect_frames(take(client, 7), 1, 1);
    proxy.cut();
    EXPECT_TRUE(ends(client));
    ASSERT_TRUE(wait_until([&] { return sender.publisher->statistics().reconnects > 0 && sender.publisher->status().state == SourceState::playing; }));
    sender.send(7);   // the rest of the group that was cut is of no use
    const auto objects = take(client, 5);
    ASSERT_EQ(objects.size(), 5u);
    expect_frames(objects, 10, 10);
    EXPECT_EQ(sender.publisher->statistics().dropped, 2u);
}

TEST(Live, AnotherStreamUnderTheNameEndsTheOldOneForGood) {
    const Served served(protocol::sample::make_stream(1), publishing());
    std::optional<Sender> sender(std::in_place, served);
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    Client client(served.url("face"), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender.reset();
    EXPECT_TRUE(ends(client));
    sender.emplace(served, "face", 99);
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    Client fresh(served.url("face"), unpaced());
    ASSERT_TRUE(fresh.wait_ready(kPatience).ok());
    sender->send(1);
    expect_frames(take(fresh, 1), 0, 0);
}

TEST(Live, ANameHasOnePublisher) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Sender first(served);
    ASSERT_TRUE(first.publisher->wait_ready(kPatience).ok());
    Sender second(served);
    const auto refused = second.publisher->wait_ready(kPatience);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("somebody else publishes 'face'"), std::string::npos) << refused.error().message;
    Sender recorded(served, "take");
    const auto taken = recorded.publisher->wait_ready(kPatience);
    ASSERT_FALSE(taken.ok());
    EXPECT_NE(taken.error().message.find("the name of a recording"), std::string::npos) << taken.error().message;
}

TEST(Live, PublishingIsOffUnlessAskedFor) {
    const Served served(protocol::sample::make_stream(1));
    Sender sender(served);
    const auto refused = sender.publisher->wait_ready(kPatience);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("takes no live streams"), std::string::npos) << refused.error().message;
    RawSocket socket(served.server->port());
    expect_failure(offer(socket, "face"), protocol::FailureCode::no_publishing);
    EXPECT_TRUE(socket.closed_by_peer());
}

TEST(Live, AGarbagePublisherIsToldAndHarmsNobody) {
    const Served served(protocol::sample::make_stream(1), publishing());
    const Stream stream = live_stream();
    const auto refused = [&](const std::string& name, const std::function<void(RawSocket&)>& rest) {
        SCOPED_TRACE(name);
        RawSocket socket(served.server->port());
        const auto answer = offer(socket, name);
        ASSERT_TRUE(answer && std::holds_alternative<protocol::Want>(*answer));
        rest(socket);
        auto last = socket.receive();
        if (last && std::holds_alternative<protocol::Publishing>(*last)) last = socket.receive();
        expect_failure(last, protocol::FailureCode::protocol);
        EXPECT_TRUE(socket.closed_by_peer());
    };
    const auto blobs = [&](RawSocket& socket) {
        for (const auto& blob : stream.blobs) socket.send(blob);
    };
    refused("not a blob", [&](RawSocket& s) { s.send(protocol::GroupStart{0, 0, 0, 1}); });
    refused("another blob", [&](RawSocket& s) { s.send(stream.blobs[2]); });
    refused("a damaged blob", [&](RawSocket& s) {
        Bytes bytes = protocol::encode(stream.blobs[0]);
        bytes.back() ^= std::byte(1);
        s.send(bytes);
    });
    refused("an object without a group", [&](RawSocket& s) { blobs(s), s.send(protocol::LiveBytes{0, object_bytes(0)}); });
    refused("a slot that is none", [&](RawSocket& s) { blobs(s), s.send(protocol::GroupStart{9, 0, 0, 1}); });
    refused("a group twice", [&](RawSocket& s) {
        blobs(s);
        for (int i = 0; i < 2; ++i) s.send(protocol::GroupStart{0, 3, 0, 1});
    });
    refused("a time that goes back", [&](RawSocket& s) {
        blobs(s);
        s.send(protocol::GroupStart{0, 0, 100, 1});
        s.send(protocol::GroupStart{0, 1, 99, 1});
    });
    refused("bytes that are no message", [&](RawSocket& s) { blobs(s), s.send(Bytes(64, std::byte(0xff))); });
    refused("a viewer's wish", [&](RawSocket& s) { blobs(s), s.send(protocol::Play{}); });
    refused("an object above what is kept", [&](RawSocket& s) {
        blobs(s);
        s.send(protocol::GroupStart{0, 0, 0, 1});
        s.send(protocol::LiveBytes{0, Bytes(5u << 20)});
    });
    // A header of a recording, and one whose basis is nowhere.
    for (const bool recording : {true, false}) {
        RawSocket socket(served.server->port());
        socket.send(protocol::Hello{protocol::kWireVersion, "test"});
        socket.send(protocol::Publish{"front"});
        socket.receive();
        Stream wrong = stream;
        if (recording) wrong.header.frames = 30;
        socket.send(wrong.header);
        if (!recording) socket.send(protocol::Catalogue{});
        expect_failure(socket.receive(), protocol::FailureCode::protocol);
    }
    for (const std::string name : {"", ".hidden", "a/b", "new\nline"}) {
        RawSocket socket(served.server->port());
        expect_failure(offer(socket, name), protocol::FailureCode::protocol);
    }
    // The name is free again, and the server serves.
    Sender sender(served, "not a blob");
    EXPECT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Client client(served.url(), unpaced());
    expect_groups(play_all(client), served.stream);
}

TEST(Live, ASlowViewerSkipsToANewGroupAndMemoryIsBounded) {
    ServerOptions options = publishing();
    options.live_bytes = 400'000;
    const Served served(protocol::sample::make_stream(1), options);
    Sender sender(served);
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    RawSocket slow(served.server->port());
    slow.send(protocol::Hello{protocol::kWireVersion, "slow"});
    slow.send(protocol::Open{"face"});
    slow.send(protocol::Play{7, 0, 1000});
    Client quick(served.url("face"), unpaced());
    ASSERT_TRUE(quick.wait_ready(kPatience).ok());
    sender.send(kObjects, 20000);
    expect_frames(take(quick, kObjects), 0, 0);
    constexpr int kGroups = 30;
    for (int g = 1; g < kGroups; ++g) {   // 3 MB, far more than all buffers
        sender.send(kObjects, 20000);
        expect_frames(take(quick, kObjects), g * kObjects, g * kObjects);
    }
    EXPECT_LE(served.server->statistics().peak_viewer_bytes, 30000u);
    // What the slow one gets, once it reads: whole objects, no gap inside a group, the newest group at the end.
    std::uint32_t group = 0, index = 0, skipped = 0, last = 0;
    while (last + 1 < kGroups || index < kObjects) {
        const auto message = slow.receive();
        ASSERT_TRUE(message.has_value());
        if (const auto* start = std::get_if<protocol::GroupStart>(&*message)) {
            skipped += start->group > group + 1;
            group = last = start->group;
            index = 0;
        } else if (const auto* object = std::get_if<protocol::LiveBytes>(&*message)) {
            EXPECT_EQ(object->bytes, object_bytes(int(group * kObjects + index), 20000));
            ++index;
        }
    }
    EXPECT_GE(skipped, 1u);
}

TEST(Live, APausedViewerGoesOnWithWhatIsNew) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Sender sender(served);
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Client client(served.url("face"), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender.send(3);
    expect_frames(take(client, 3), 0, 0);
    client.pause(true);
    std::this_thread::sleep_for(100ms);
    sender.send(kObjects * 4);
    std::this_thread::sleep_for(100ms);
    client.pause(false);
    const auto objects = take(client, 3);
    ASSERT_EQ(objects.size(), 3u);
    expect_frames(objects, kObjects * 4, kObjects * 4);
}

TEST(Live, AViewerWhoseConnectionBreaksGetsNothingTwice) {
    const Served served(protocol::sample::make_stream(1), publishing());
    Sender sender(served);
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Proxy proxy(served.server->port());
    Client client({"127.0.0.1", proxy.port(), "face"}, unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender.send(3);
    expect_frames(take(client, 3), 0, 0);
    proxy.cut();
    ASSERT_TRUE(wait_until([&] { return client.statistics().reconnects > 0 && client.status().state == SourceState::playing; }));
    sender.send(1);
    expect_frames(take(client, 1), 3, 3);   // frames 0 to 2 came again and were dropped
    EXPECT_EQ(client.statistics().objects, 4u);
}

/// A server whose port outlives it.
class Restarted {
public:
    Restarted() { start(); }
    void start() {
        ServerOptions options = publishing();
        options.folder = folder_.path();
        options.port = port_;
        server_.emplace(options);
        server_->start();
        port_ = server_->port();
    }
    void stop() { server_.reset(); }
    Url url() const { return {"127.0.0.1", port_, "face"}; }

private:
    Folder folder_;
    std::uint16_t port_ = 0;
    std::optional<Server> server_;
};

TEST(Live, AViewerOutlivesItsServerAndItsPublisher) {
    Restarted server;
    std::optional<Sender> sender(std::in_place, server.url());
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    Client client(server.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender->send(1);
    expect_frames(take(client, 1), 0, 0);
    sender->send(7);
    expect_frames(take(client, 7), 1, 1);

    server.stop();
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::reconnecting; }));
    sender.reset();
    server.start();
    // Nobody publishes yet: the viewer is told so, and waits.
    ASSERT_TRUE(wait_until([&] { return client.status().reason.find("no stream") != std::string::npos; })) << client.status().reason;
    EXPECT_EQ(client.status().state, SourceState::reconnecting);
    sender.emplace(server.url());
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    sender->send(3);
    const auto objects = take(client, 3);
    ASSERT_EQ(objects.size(), 3u) << client.status().reason;
    expect_frames(objects, 0, 0);   // another server counts anew
    EXPECT_EQ(client.status().state, SourceState::playing);
    EXPECT_EQ(client.statistics().blobs_fetched, live_stream().blobs.size());
}

TEST(Live, AViewerOutlivesAServerThatItsPublisherOutlivesToo) {
    Restarted server;
    Sender sender(server.url());
    ASSERT_TRUE(sender.publisher->wait_ready(kPatience).ok());
    Client client(server.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender.send(1);
    expect_frames(take(client, 1), 0, 0);
    sender.send(4);
    expect_frames(take(client, 4), 1, 1);
    server.stop();
    ASSERT_TRUE(wait_until([&] { return client.status().state == SourceState::reconnecting; }));
    server.start();
    ASSERT_TRUE(wait_until([&] { return sender.publisher->statistics().reconnects > 0 && sender.publisher->status().state == SourceState::playing; }));
    sender.send(5);
    const auto objects = take(client, 1);
    ASSERT_EQ(objects.size(), 1u) << client.status().reason;
    EXPECT_GE(objects[0].first_time, 5);
    EXPECT_EQ(client.status().state, SourceState::playing);
}

TEST(Live, AnotherTakeUnderTheSameNumbersIsNotMistakenForWhatWasHad) {
    Restarted server;
    std::optional<Sender> sender(std::in_place, server.url());
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    Client client(server.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    sender->send(1);
    expect_frames(take(client, 1), 0, 0);
    sender->send(3);
    expect_frames(take(client, 3), 1, 1);
    server.stop();
    sender.reset();
    server.start();
    sender.emplace(server.url());
    ASSERT_TRUE(sender->publisher->wait_ready(kPatience).ok());
    sender->send(4, 31);
    const auto objects = take(client, 4);
    ASSERT_EQ(objects.size(), 4u) << client.status().reason;
    expect_frames(objects, 0, 0);
    EXPECT_EQ(objects[0].object.bytes.size(), 31u);
}

}  // namespace
}  // namespace mien::net
