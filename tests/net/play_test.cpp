#include <future>
#include <random>

#include "harness.hpp"

/// A client and a server that behave.
namespace mien::net {
namespace {

using namespace harness;
using protocol::sample::make_stream;

TEST(Play, BringsEveryGroupOnceAndInOrder) {
    const Served served(make_stream(5));
    Client client(served.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    EXPECT_EQ(client.header().name, "sample");
    for (const auto& blob : served.stream.blobs) {
        ASSERT_NE(client.blob(blob.hash), nullptr);
        EXPECT_EQ(*client.blob(blob.hash), blob.bytes);
    }
    EXPECT_EQ(client.blob(Hash{}), nullptr);
    expect_groups(play_all(client), served.stream);
    EXPECT_EQ(client.status().state, SourceState::ended);
}

TEST(Play, LetsALateJoinerStartAtTheCurrentGroup) {
    const Served served(make_stream(6));
    SourceOptions options = unpaced();
    options.start = 3.5;
    Client client(served.url(), options);
    expect_groups(play_all(client), served.stream, 3 * 3);
}

TEST(Play, FetchesEachBlobOnce) {
    const Served served(make_stream(1));
    const Folder cache;
    SourceOptions options = unpaced();
    options.cache = std::make_shared<DiskBlobCache>(cache.path());
    {
        Client first(served.url(), options);
        ASSERT_TRUE(first.wait_ready(kPatience).ok());
        EXPECT_EQ(first.statistics().blobs_fetched, served.stream.blobs.size());
    }
    Client second(served.url(), options);
    ASSERT_TRUE(second.wait_ready(kPatience).ok());
    EXPECT_EQ(second.statistics().blobs_fetched, 0u);
    EXPECT_EQ(second.statistics().blob_bytes, 0u);
    EXPECT_EQ(second.statistics().blobs_from_cache, served.stream.blobs.size());
    EXPECT_EQ(served.server->statistics().blobs_sent, served.stream.blobs.size());
    expect_groups(play_all(second), served.stream);
}

TEST(Play, SeeksBackAfterTheEnd) {
    const Served served(make_stream(4));
    Client client(served.url(), unpaced());
    expect_groups(play_all(client), served.stream);
    const std::uint32_t generation = client.seek(2);
    EXPECT_EQ(client.status().state, SourceState::playing);
    const auto again = play_all(client);
    expect_groups(again, served.stream, 2 * 3);
    for (const Arrival& arrival : again) EXPECT_EQ(arrival.generation, generation);
}

TEST(Play, ASeekStormEndsWhereTheLastSeekPoints) {
    const Served served(make_stream(20));
    Client client(served.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    std::mt19937 random(5);
    for (int s = 0; s < 300; ++s) {
        client.seek(random() % 20);
        if (s % 7 == 0) (void)client.next(1ms);
    }
    const std::uint32_t generation = client.seek(17);
    const auto rest = play_all(client);
    expect_groups(rest, served.stream, 17 * 3);
    for (const Arrival& arrival : rest) EXPECT_EQ(arrival.generation, generation);
}

TEST(Play, SendsOnlySelectedSlots) {
    const Served served(make_stream(30));
    Client client(served.url(), unpaced());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    client.select(0b101);
    client.seek(0);
    std::size_t groups = 0;
    for (const Arrival& arrival : play_all(client)) {
        if (!arrival.group) continue;
        EXPECT_NE(arrival.group->slot, 1);
        ++groups;
    }
    EXPECT_EQ(groups, 60u);
}

TEST(Play, PacesGroupsByTheViewersClock) {
    ServerOptions server;
    server.ahead = 0.5;
    const Served served(make_stream(3), server);
    SourceOptions options = unpaced();
    options.rate = 1000;  // real time, a thousand times
    Client fast(served.url(), options);
    expect_groups(play_all(fast), served.stream);

    // At normal rate only what is due within half a second comes: the first second's groups.
    options.rate = 1;
    Client paced(served.url(), options);
    ASSERT_TRUE(paced.wait_ready(kPatience).ok());
    paced.pause(true);
    for (int g = 0; g < 3; ++g) {
        const auto arrival = paced.next(kPatience);
        ASSERT_TRUE(arrival && arrival->group);
        EXPECT_EQ(arrival->group->group, 0u);
    }
    // Paused before half a second had passed (or the second group came, on a machine that slept): the clock stands.
    while (paced.next(50ms)) {
    }
    EXPECT_FALSE(paced.next(700ms).has_value());
    paced.set_rate(1000);
    paced.pause(false);
    bool ended = false;
    for (const Arrival& arrival : play_all(paced)) ended = !arrival.group;
    EXPECT_TRUE(ended);
}

TEST(Play, ListsWhatTheServerOffers) {
    const Served served(make_stream(2));
    served.folder.write("another one.mien", protocol::sample::file_of(make_stream(1)));
    served.folder.write("notes.txt", {});
    served.folder.write("broken.mien", protocol::sample::bytes_of("nothing of ours"));
    const auto list = list_streams(served.url(""), kPatience);
    ASSERT_TRUE(list.ok()) << list.error().message;
    ASSERT_EQ(list->size(), 2u);
    EXPECT_EQ((*list)[0].name, "another one");
    EXPECT_EQ((*list)[1].name, "take");
    EXPECT_DOUBLE_EQ((*list)[1].seconds(), 2.0);
    EXPECT_FALSE((*list)[1].live);
    ASSERT_EQ(served.server->unreadable().size(), 1u);
    EXPECT_NE(served.server->unreadable()[0].find("broken.mien"), std::string::npos);
    // One whose end is cut off is served as far as it goes, with a remark.
    EXPECT_TRUE(served.server->incomplete().empty());
    Bytes cut = protocol::sample::file_of(make_stream(1));
    cut.resize(cut.size() - 10);
    served.folder.write("cut.mien", cut);
    ASSERT_EQ(served.server->incomplete().size(), 1u);
    EXPECT_NE(served.server->incomplete()[0].find("cut.mien"), std::string::npos);
    EXPECT_EQ(served.server->streams().size(), 3u);

    Client client(served.url("another one"), unpaced());
    EXPECT_TRUE(client.wait_ready(kPatience).ok());
}

TEST(Play, SaysThatAStreamIsNotThere) {
    const Served served(make_stream(1));
    for (const char* name : {"nobody", "../take", "/etc/passwd", "take.mien", ""}) {
        Client client(served.url(name), unpaced());
        const auto ready = client.wait_ready(kPatience);
        ASSERT_FALSE(ready.ok()) << name;
        EXPECT_NE(ready.error().message.find("there is no stream"), std::string::npos) << ready.error().message;
        EXPECT_EQ(client.status().state, SourceState::failed);
    }
}

TEST(Play, SaysThatNobodyAnswers) {
    std::uint16_t port = 0;
    {
        const Served served(make_stream(1));
        port = served.server->port();
    }
    Client client({"127.0.0.1", port, "take"}, unpaced());
    const auto ready = client.wait_ready(kPatience);
    ASSERT_FALSE(ready.ok());
    EXPECT_NE(ready.error().message.find("cannot connect"), std::string::npos) << ready.error().message;
    EXPECT_FALSE(list_streams({"127.0.0.1", port, ""}, kPatience).ok());
}

TEST(Play, ServesManyViewersAtOnce) {
    const Served served(make_stream(8));
    std::vector<std::future<std::vector<Arrival>>> viewers;
    for (int v = 0; v < 8; ++v)
        viewers.push_back(std::async(std::launch::async, [&served, v] {
            SourceOptions options = unpaced();
            options.start = v;
            Client client(served.url(), options);
            return play_all(client);
        }));
    for (std::size_t v = 0; v < viewers.size(); ++v) expect_groups(viewers[v].get(), served.stream, v * 3);
}

TEST(Play, AFilePlaysThroughTheSameDoor) {
    const Stream stream = make_stream(4);
    const Folder folder;
    folder.write("take.mien", protocol::sample::file_of(stream));
    auto source = open_source((folder.path() / "take.mien").string(), unpaced());
    ASSERT_TRUE(source.ok()) << source.error().message;
    ASSERT_TRUE((*source)->wait_ready(0ms).ok());
    for (const auto& blob : stream.blobs) {
        ASSERT_NE((*source)->blob(blob.hash), nullptr);
        EXPECT_EQ(*(*source)->blob(blob.hash), blob.bytes);
    }
    expect_groups(play_all(**source), stream);
    EXPECT_EQ((*source)->status().state, SourceState::ended);
    const std::uint32_t generation = (*source)->seek(1.2);
    const auto again = play_all(**source);
    expect_groups(again, stream, 3);
    EXPECT_EQ(again.front().generation, generation);

    EXPECT_FALSE(open_source((folder.path() / "nothing.mien").string()).ok());
    EXPECT_FALSE(open_source(folder.path().string()).ok());
    EXPECT_FALSE(open_source("http://127.0.0.1/take").ok());
    EXPECT_FALSE(open_source("mien://127.0.0.1").ok());
}

TEST(Play, SkipsDamagedGroupsAndSaysSo) {
    const Stream stream = make_stream(3);
    Bytes file = protocol::sample::file_of(stream);
    const auto reader = protocol::sample::open_bytes(file);
    ASSERT_TRUE(reader.ok());
    const protocol::IndexEntry hit = reader->index()[4];
    file[hit.offset + hit.size / 2] ^= std::byte{1};
    const Served served(stream);
    served.folder.write("take.mien", file);
    const auto path = (served.folder.path() / "take.mien").string();
    for (const std::string& where : {path, to_string(served.url())}) {
        auto source = open_source(where, unpaced());
        ASSERT_TRUE(source.ok());
        const auto arrivals = play_all(**source);
        EXPECT_EQ(arrivals.size(), stream.groups.size()) << where;
        EXPECT_FALSE(arrivals.back().group.has_value());
        EXPECT_EQ((*source)->statistics().damaged_groups, 1u) << where;
    }
}

}  // namespace
}  // namespace mien::net
