#include "harness.hpp"

/// Refinements of a model that come while its stream plays.
namespace mien::net {
namespace {

using namespace harness;

/// Plays in real time from what nothing plays without.
SourceOptions refining() {
    SourceOptions options = unpaced();
    options.rate = 1;
    options.start_bytes = 0;
    return options;
}

std::uint64_t bytes_of(const Stream& stream) {
    std::uint64_t sum = 0;
    for (const auto& blob : stream.blobs) sum += blob.bytes.size();
    return sum;
}

void expect_whole_model(const StreamSource& source, const Stream& stream) {
    for (const auto& blob : stream.blobs) {
        ASSERT_NE(source.blob(blob.hash), nullptr);
        EXPECT_EQ(*source.blob(blob.hash), blob.bytes);
    }
    EXPECT_EQ(source.statistics().model_bytes, bytes_of(stream));
    EXPECT_EQ(source.statistics().model_size, bytes_of(stream));
    EXPECT_EQ(source.statistics().unrefined, "");
}

TEST(Refinement, PlayingBeginsBeforeItAndItComesWhileItPlays) {
    const Served served(refined_stream(60, 4, 60000));
    Proxy proxy(served.server->port());
    proxy.throttle(200000);
    Client client({"127.0.0.1", proxy.port(), "take"}, refining());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    const auto refinements = refinements_of(served.stream);
    const std::uint64_t begun_with = bytes_of(served.stream) - 4 * 60000;
    EXPECT_NE(client.blob(served.stream.blobs.back().hash), nullptr) << "the motion basis, behind the refinements in the catalogue";
    EXPECT_EQ(client.blob(refinements.back().hash), nullptr);
    const auto first = client.next(kPatience);
    ASSERT_TRUE(first && first->group);
    EXPECT_EQ(client.blob(refinements.back().hash), nullptr) << "a group has come, and not yet the last refinement";

    std::uint64_t here = begun_with;
    std::vector<std::uint64_t> seen;
    while (here < bytes_of(served.stream)) {
        const std::uint64_t now = client.wait_model(here, kPatience);
        ASSERT_GT(now, here);
        here = now;
    }
    expect_whole_model(client, served.stream);
    EXPECT_EQ(client.statistics().blobs_fetched, served.stream.blobs.size());
    EXPECT_EQ(served.server->statistics().blobs_sent, served.stream.blobs.size()) << "none was sent twice";
    EXPECT_EQ(client.status().state, SourceState::playing);
    EXPECT_EQ(client.wait_model(here, 1ms), here) << "there is no more";
}

TEST(Refinement, WaitsForGroupsThatAreDue) {
    const Served served(refined_stream(60, 2, 5000));
    const auto refinements = refinements_of(served.stream);
    RawSocket socket(served.server->port());
    ASSERT_TRUE(socket.send(protocol::Hello{protocol::kWireVersion, "test"}));
    ASSERT_TRUE(socket.send(protocol::Open{"take"}));
    ASSERT_TRUE(socket.send(protocol::Play{0, 0, 1000}));
    ASSERT_TRUE(socket.send(protocol::WantPart{refinements[0].hash, 4000, 9000}));
    ASSERT_TRUE(socket.send(protocol::Want{{refinements[1].hash}}));
    std::uint32_t group = 0;
    bool parted = false;
    for (;;) {
        const auto message = socket.receive();
        ASSERT_TRUE(message.has_value());
        if (const auto* came = std::get_if<protocol::Group>(&*message)) group = came->group;
        if (const auto* part = std::get_if<protocol::BlobPart>(&*message)) {
            const Bytes whole = protocol::encode(refinements[0]);
            EXPECT_EQ(part->total, whole.size());
            EXPECT_EQ(part->bytes, Bytes(whole.begin() + 4000, whole.end())) << "as many as there are";
            EXPECT_GE(group, 4u);
            parted = true;
        }
        if (const auto* blob = std::get_if<protocol::StaticBlob>(&*message)) {
            EXPECT_EQ(blob->hash, refinements[1].hash);
            break;
        }
    }
    EXPECT_TRUE(parted) << "in the order in which they were asked for";
    EXPECT_GE(group, 4u) << "the five seconds that are sent ahead came before";
    // And groups come after it as before.
    for (;;) {
        const auto message = socket.receive();
        ASSERT_TRUE(message.has_value());
        if (const auto* came = std::get_if<protocol::Group>(&*message); came && came->group > group) break;
    }
}

TEST(Refinement, ABudgetDecidesWhatPlayingBeginsWith) {
    const Served served(refined_stream(3, 4, 10000));
    const auto refinements = refinements_of(served.stream);
    SourceOptions options = unpaced();
    options.refine = false;
    options.start_bytes = bytes_of(served.stream) - 4 * 10000 + 2 * 10000 + 5000;
    Client client(served.url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    expect_groups(play_all(client), served.stream);
    EXPECT_NE(client.blob(refinements[1].hash), nullptr);
    EXPECT_EQ(client.blob(refinements[2].hash), nullptr) << "half of it would have been left";
    EXPECT_EQ(client.statistics().model_bytes, bytes_of(served.stream) - 2 * 10000);
    EXPECT_EQ(served.server->statistics().blobs_sent, served.stream.blobs.size() - 2) << "nothing more was asked for";

    Client whole(served.url(), unpaced());
    ASSERT_TRUE(whole.wait_ready(kPatience).ok());
    expect_whole_model(whole, served.stream);
}

TEST(Refinement, ComesFromTheCacheAtOnceAndGoesIntoIt) {
    const Served served(refined_stream(60, 3, 20000));
    const Folder cache;
    SourceOptions options = refining();
    options.cache = std::make_shared<DiskBlobCache>(cache.path());
    {
        Client first(served.url(), options);
        ASSERT_TRUE(first.wait_ready(kPatience).ok());
        ASSERT_TRUE(wait_until([&] { return first.statistics().model_bytes == bytes_of(served.stream); }));
    }
    Client second(served.url(), options);
    ASSERT_TRUE(second.wait_ready(kPatience).ok());
    expect_whole_model(second, served.stream);
    EXPECT_EQ(second.statistics().blobs_fetched, 0u);
    EXPECT_EQ(served.server->statistics().blobs_sent, served.stream.blobs.size());
}

TEST(Refinement, GoesOnAfterACutAndFetchesNothingTwice) {
    const Served served(refined_stream(120, 6, 80000));
    Proxy proxy(served.server->port());
    proxy.throttle(400000);
    Client client({"127.0.0.1", proxy.port(), "take"}, refining());
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    // Two cuts amid a refinement: some of its parts have come, but not all.
    for (const int whole : {1, 3}) {
        const std::uint64_t until = bytes_of(served.stream) - std::uint64_t(6 - whole) * 80000;
        ASSERT_TRUE(wait_until([&] { return client.statistics().model_bytes >= until; }));
        std::this_thread::sleep_for(60ms);
        proxy.cut();
    }
    ASSERT_TRUE(wait_until([&] { return client.statistics().model_bytes == bytes_of(served.stream); }));
    expect_whole_model(client, served.stream);
    EXPECT_GE(client.statistics().reconnects, 2u);
    EXPECT_EQ(client.statistics().blobs_fetched, served.stream.blobs.size());
    std::uint64_t messages = 0;
    for (const auto& blob : served.stream.blobs) messages += protocol::encode(blob).size();
    EXPECT_LE(client.statistics().blob_bytes, messages + 2 * protocol::kMaxPartBytes + 1000) << "at most the part that was cut came again";
    std::uint32_t next = 0;
    while (const auto arrival = client.next(10ms)) {
        ASSERT_TRUE(arrival->group.has_value());
        EXPECT_EQ(arrival->group->group, next / 3) << "no group was lost or came twice";
        ++next;
    }
    EXPECT_GE(next, 12u);
}

TEST(Refinement, WhatAnotherPlayerHasCachedDuringAnOutageIsNotFetched) {
    const Served served(refined_stream(120, 3, 200000));
    const Folder cache;
    SourceOptions options = refining();
    options.cache = std::make_shared<DiskBlobCache>(cache.path());
    Proxy proxy(served.server->port());
    proxy.throttle(100000);
    Client client({"127.0.0.1", proxy.port(), "take"}, options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    // Some of the first refinement has come when the line breaks.
    ASSERT_TRUE(wait_until([&] { return client.statistics().blob_bytes > 40000; }));
    proxy.refuse(true);
    proxy.cut();
    for (const auto& blob : refinements_of(served.stream)) options.cache->store(blob.hash, blob.bytes);
    proxy.refuse(false);
    ASSERT_TRUE(wait_until([&] { return client.statistics().model_bytes >= bytes_of(served.stream); }));
    expect_whole_model(client, served.stream);
    EXPECT_EQ(client.statistics().blobs_from_cache, 3u);
}

TEST(Refinement, ADamagedOneIsToldAndLeavesTheLastGoodStagePlaying) {
    const Stream stream = refined_stream(6, 3, 50000);
    const auto refinements = refinements_of(stream);
    Bytes file = protocol::sample::file_of(stream);
    const auto at = std::search(file.begin(), file.end(), refinements[1].bytes.begin(), refinements[1].bytes.end());
    ASSERT_NE(at, file.end());
    at[20000] ^= std::byte{1};
    const Served served(stream);
    served.folder.write("take.mien", file);
    SourceOptions options = refining();
    Client client(served.url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    ASSERT_TRUE(wait_until([&] { return !client.statistics().unrefined.empty(); }));
    EXPECT_NE(client.statistics().unrefined.find("hash"), std::string::npos) << client.statistics().unrefined;
    EXPECT_NE(client.blob(refinements[0].hash), nullptr);
    EXPECT_EQ(client.blob(refinements[1].hash), nullptr);
    EXPECT_EQ(client.blob(refinements[2].hash), nullptr) << "what builds on it is not asked for";
    client.set_rate(1000);
    expect_groups(play_all(client), stream);
    EXPECT_EQ(client.statistics().reconnects, 0u);
    EXPECT_EQ(client.status().state, SourceState::ended);
    EXPECT_EQ(served.server->statistics().blobs_sent, stream.blobs.size() - 1);
}

/// A server of one stream that answers WANT PART as a test says.
void serve_badly(RawServer& server, const Stream& stream, const std::function<bool(RawSocket&)>& answer) {
    RawSocket viewer = server.accept();
    protocol::Catalogue catalogue;
    for (const auto& blob : stream.blobs) catalogue.blobs.push_back({blob.hash, blob.kind, blob.bytes.size()});
    while (const auto message = viewer.receive()) {
        if (std::holds_alternative<protocol::Open>(*message)) {
            for (const protocol::Message& first : {protocol::Message(protocol::Hello{}), protocol::Message(stream.header), protocol::Message(catalogue)}) viewer.send(first);
        } else if (const auto* want = std::get_if<protocol::Want>(&*message)) {
            for (const Hash& hash : want->hashes) viewer.send(*std::ranges::find(stream.blobs, hash, &protocol::StaticBlob::hash));
        } else if (std::holds_alternative<protocol::WantPart>(*message)) {
            if (!answer(viewer)) return;
        } else if (std::holds_alternative<protocol::Play>(*message)) {
            viewer.send(protocol::Playing{0, 0});
        } else if (std::holds_alternative<protocol::Bye>(*message)) {
            return;
        }
    }
}

TEST(Refinement, PartsThatDoNotFitTogetherAreTold) {
    const Stream stream = refined_stream(2, 2, 5000);
    const Bytes sound = protocol::encode(refinements_of(stream)[0]);
    int asked = 0;
    RawServer server;
    std::thread serving([&] {
        serve_badly(server, stream, [&](RawSocket& viewer) {
            // The second one would make more than the whole.
            viewer.send(protocol::BlobPart{sound.size(), Bytes(sound.begin(), sound.begin() + 4000)});
            return ++asked < 2 || viewer.send(stream.groups[0]);
        });
    });
    {
        Client client({"127.0.0.1", server.port(), "take"}, refining());
        ASSERT_TRUE(client.wait_ready(kPatience).ok());
        const auto arrival = client.next(kPatience);
        ASSERT_TRUE(arrival && arrival->group) << "groups go on";
        EXPECT_NE(client.statistics().unrefined.find("fit"), std::string::npos) << client.statistics().unrefined;
    }
    serving.join();
    EXPECT_EQ(asked, 2);
}

TEST(Refinement, AnotherBlobThanWasAskedForIsNotTaken) {
    const Stream stream = refined_stream(2, 2, 5000);
    RawServer server;
    std::thread serving([&] {
        serve_badly(server, stream, [&](RawSocket& viewer) {
            const Bytes other = protocol::encode(protocol::sample::make_blob(protocol::BlobKind::refinement, protocol::sample::noise(5000, 9)));
            viewer.send(protocol::BlobPart{other.size(), other});
            return viewer.send(stream.groups[0]);
        });
    });
    {
        Client client({"127.0.0.1", server.port(), "take"}, refining());
        ASSERT_TRUE(client.wait_ready(kPatience).ok());
        const auto arrival = client.next(kPatience);
        ASSERT_TRUE(arrival && arrival->group) << "groups go on";
        EXPECT_NE(client.statistics().unrefined.find("something else"), std::string::npos) << client.statistics().unrefined;
        EXPECT_EQ(client.blob(refinements_of(stream)[0].hash), nullptr);
        EXPECT_EQ(client.status().state, SourceState::playing);
    }
    serving.join();
}

TEST(Refinement, AServerThatCannotReadItIsAskedForTheGroupsAlone) {
    const Stream stream = refined_stream(2, 2, 5000);
    RawServer server;
    int wanted = 0;
    std::thread serving([&] {
        serve_badly(server, stream, [&](RawSocket& viewer) {
            ++wanted;
            viewer.send(protocol::Failure{protocol::FailureCode::damaged, "the disk is broken"});
            return false;
        });
        serve_badly(server, stream, [&](RawSocket&) { return ++wanted, true; });
    });
    {
        Client client({"127.0.0.1", server.port(), "take"}, refining());
        ASSERT_TRUE(client.wait_ready(kPatience).ok());
        EXPECT_TRUE(wait_until([&] { return client.statistics().reconnects == 1 && client.status().state == SourceState::playing; }));
        EXPECT_NE(client.statistics().unrefined.find("the disk is broken"), std::string::npos) << client.statistics().unrefined;
    }
    serving.join();
    EXPECT_EQ(wanted, 1) << "it is not asked for again";
}

TEST(Refinement, ASlowViewerThatWantsEverythingCostsOneMessageAndNobodyElseWaits) {
    const Served served(refined_stream(33, 8, 400000, 30000));
    std::size_t largest = 0;
    for (const auto& group : served.stream.groups) largest = std::max(largest, protocol::encode(group).size());
    for (const auto& blob : served.stream.blobs) largest = std::max(largest, protocol::encode(blob).size());
    RawSocket slow(served.server->port());
    slow.shrink_receive_buffer();
    ASSERT_TRUE(slow.send(protocol::Hello{protocol::kWireVersion, "test"}));
    ASSERT_TRUE(slow.send(protocol::Open{"take"}));
    ASSERT_TRUE(slow.send(protocol::Play{0, 0, 1000}));
    protocol::Want all;
    for (const auto& blob : refinements_of(served.stream)) all.hashes.push_back(blob.hash);
    ASSERT_TRUE(slow.send(all));
    ASSERT_TRUE(wait_until([&] { return served.server->statistics().queued_bytes > 0; }));

    Client quick(served.url(), unpaced());
    expect_groups(play_all(quick), served.stream);
    expect_whole_model(quick, served.stream);
    EXPECT_LE(served.server->statistics().peak_viewer_bytes, largest + 4096);
}

TEST(Refinement, WhoAsksForMoreThanThereIsIsShownOut) {
    const Served served(refined_stream(33, 8, 40000, 3000));
    RawSocket greedy(served.server->port());
    protocol::Want all;
    for (const auto& blob : refinements_of(served.stream)) all.hashes.push_back(blob.hash);
    for (const protocol::Message& message : {protocol::Message(protocol::Hello{protocol::kWireVersion, "test"}), protocol::Message(protocol::Open{"take"}),
                                             protocol::Message(protocol::Play{0, 0, 1000}), protocol::Message(all), protocol::Message(all), protocol::Message(all)})
        ASSERT_TRUE(greedy.send(message));
    bool refused = false;
    while (const auto message = greedy.receive())
        if (const auto* failure = std::get_if<protocol::Failure>(&*message)) refused = failure->code == protocol::FailureCode::protocol;
    EXPECT_TRUE(refused) << "the server remembers no more than there is";

    RawSocket beyond(served.server->port());
    for (const protocol::Message& message : {protocol::Message(protocol::Hello{protocol::kWireVersion, "test"}), protocol::Message(protocol::Open{"take"}),
                                             protocol::Message(protocol::WantPart{all.hashes[0], 50000, 1})})
        ASSERT_TRUE(beyond.send(message));
    refused = false;
    while (const auto message = beyond.receive())
        if (const auto* failure = std::get_if<protocol::Failure>(&*message)) refused = failure->code == protocol::FailureCode::protocol;
    EXPECT_TRUE(refused) << "there is no such byte";
}

TEST(Refinement, AFileHasItsWholeModelAtOnce) {
    const Stream stream = refined_stream(2, 3, 1000);
    const Folder folder;
    folder.write("take.mien", protocol::sample::file_of(stream));
    auto source = open_source((folder.path() / "take.mien").string(), refining());
    ASSERT_TRUE(source.ok()) << source.error().message;
    expect_whole_model(**source, stream);
    EXPECT_EQ((*source)->wait_model(0, 0ms), bytes_of(stream));
}

}  // namespace
}  // namespace mien::net
