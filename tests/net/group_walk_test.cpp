#include "net/group_walk.hpp"

#include "harness.hpp"

namespace mien::net {
namespace {

using namespace harness;

/// The sample stream with a second rung of texture, slot 3.
Stream two_rungs(int seconds) {
    Stream stream = protocol::sample::make_stream(seconds);
    protocol::Rung finer = stream.header.tracks[1].rungs[0];
    finer.slot = 3;
    stream.header.tracks[1].rungs.push_back(finer);
    for (std::size_t g = 0, count = stream.groups.size(); g < count; ++g)
        if (stream.groups[g].slot == 1) {
            protocol::Group more = stream.groups[g];
            more.slot = 3;
            stream.groups.push_back(std::move(more));
        }
    protocol::order_groups(stream.groups);
    return stream;
}

constexpr std::uint64_t kCoarse = 0b0111, kFine = 0b1101;

using Place = std::pair<std::uint32_t, int>;   // group, slot

class GroupWalkTest : public testing::Test {
protected:
    std::optional<Place> take() {
        const protocol::IndexEntry* next = walk_.peek();
        if (!next) return {};
        const Place place(next->group, next->slot);
        walk_.pop();
        return place;
    }
    std::vector<Place> rest() {
        std::vector<Place> places;
        while (const auto place = take()) places.push_back(*place);
        return places;
    }

    const Bytes file_ = protocol::sample::file_of(two_rungs(3));
    const protocol::StreamFileReader reader_ = std::move(*protocol::sample::open_bytes(file_));
    GroupWalk walk_{reader_};
};

TEST_F(GroupWalkTest, TextureComesLastOfEachGroup) {
    walk_.start(1);
    EXPECT_EQ(rest(), (std::vector<Place>{{1, 0}, {1, 2}, {1, 1}, {1, 3}, {2, 0}, {2, 2}, {2, 1}, {2, 3}}));
    EXPECT_EQ(walk_.peek(), nullptr);
    walk_.pop();   // of nothing
    walk_.start(2);
    EXPECT_EQ(take(), Place(2, 0));
}

TEST_F(GroupWalkTest, AChoiceHoldsFromTheNextGroupOnWhereverItComes) {
    for (int before = 1; before <= 3; ++before) {
        walk_.start(0);
        walk_.select(kCoarse);
        std::vector<Place> places;
        for (int i = 0; i < before; ++i) places.push_back(*take());
        walk_.select(kFine);
        for (const Place& place : rest()) places.push_back(place);
        EXPECT_EQ(places, (std::vector<Place>{{0, 0}, {0, 2}, {0, 1}, {1, 0}, {1, 2}, {1, 3}, {2, 0}, {2, 2}, {2, 3}})) << before;
    }
}

TEST_F(GroupWalkTest, AChoiceHoldsForAGroupThatWasOnlyLookedAt) {
    walk_.start(0);
    walk_.select(0b0010);
    EXPECT_EQ(walk_.peek()->slot, 1);
    walk_.select(0b1000);
    EXPECT_EQ(rest(), (std::vector<Place>{{0, 3}, {1, 3}, {2, 3}}));
    walk_.start(0);
    walk_.select(0);
    EXPECT_EQ(walk_.peek(), nullptr);
}

// ---- over the wire ----

/// Slots of the groups that come, by group number, until END or `count` groups of any slot.
std::map<std::uint32_t, std::vector<int>> slots_that_come(RawSocket& socket, std::size_t count) {
    std::map<std::uint32_t, std::vector<int>> slots;
    while (count > 0) {
        const auto message = socket.receive();
        if (!message || std::holds_alternative<protocol::End>(*message)) break;
        if (const auto* group = std::get_if<protocol::Group>(&*message)) slots[group->group].push_back(group->slot), --count;
    }
    return slots;
}

TEST(Select, BeforePlayAndWhilePlayingItHoldsFromTheNextGroupOn) {
    ServerOptions options;
    options.ahead = 0.5;
    const Served served(two_rungs(4), options);
    RawSocket socket(served.server->port());
    Bytes all;
    const auto say = [&](const protocol::Message& message) {
        const Bytes bytes = protocol::encode(message);
        all.insert(all.end(), bytes.begin(), bytes.end());
    };
    say(protocol::Hello{protocol::kWireVersion, "test"});
    say(protocol::Open{"take"});
    say(protocol::Select{kCoarse});
    say(protocol::Play{1, 0, 1000});
    say(protocol::Pause{true});   // half a second ahead of the start: group 0 and no more
    ASSERT_TRUE(socket.send(all));
    EXPECT_EQ(slots_that_come(socket, 3), (std::map<std::uint32_t, std::vector<int>>{{0, {0, 2, 1}}}));
    all.clear();
    say(protocol::Select{kFine});
    say(protocol::SetRate{1000000});
    say(protocol::Pause{false});
    ASSERT_TRUE(socket.send(all));
    EXPECT_EQ(slots_that_come(socket, 100), (std::map<std::uint32_t, std::vector<int>>{{1, {0, 2, 3}}, {2, {0, 2, 3}}, {3, {0, 2, 3}}}));
}

TEST(Select, NeedsAnOpenStreamAndANewOneBeginsWithAll) {
    const Served served(two_rungs(1));
    RawSocket early(served.server->port());
    early.send(protocol::Hello{protocol::kWireVersion, "test"});
    early.send(protocol::Select{kFine});
    EXPECT_TRUE(std::holds_alternative<protocol::Hello>(*early.receive()));
    const auto answer = early.receive();
    ASSERT_TRUE(answer && std::holds_alternative<protocol::Failure>(*answer));
    EXPECT_EQ(std::get<protocol::Failure>(*answer).code, protocol::FailureCode::protocol);

    RawSocket socket(served.server->port());
    socket.send(protocol::Hello{protocol::kWireVersion, "test"});
    socket.send(protocol::Open{"take"});
    socket.send(protocol::Select{0});
    socket.send(protocol::Open{"take"});
    socket.send(protocol::Play{0, 0, 0});
    EXPECT_EQ(slots_that_come(socket, 100), (std::map<std::uint32_t, std::vector<int>>{{0, {0, 2, 1, 3}}}));
}

TEST(Select, AFloodOfItCostsNothingAndNobodyElseWaits) {
    const Served served(two_rungs(8));
    RawSocket rude(served.server->port());
    rude.send(protocol::Hello{protocol::kWireVersion, "test"});
    rude.send(protocol::Open{"take"});
    rude.send(protocol::Select{0});
    rude.send(protocol::Play{0, 0, 1000});
    Bytes flood;
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        const Bytes one = protocol::encode(protocol::Select{i % 2 ? kCoarse : 0});
        flood.insert(flood.end(), one.begin(), one.end());
    }
    std::thread flooding([&] {
        rude.send(flood);
        rude.send(protocol::Ping{77});
    });
    Client quick(served.url(), unpaced());
    expect_groups(play_all(quick), served.stream);
    flooding.join();
    bool answered = false;
    while (!answered) {
        const auto message = rude.receive();
        ASSERT_TRUE(message.has_value());
        if (const auto* pong = std::get_if<protocol::Pong>(&*message)) answered = pong->token == 77;
    }
    std::size_t largest = 0;
    for (const auto& group : served.stream.groups) largest = std::max(largest, protocol::encode(group).size());
    EXPECT_LE(served.server->statistics().peak_viewer_bytes, largest + 4096);
}

TEST(Select, AClientChoosesBeforeAnythingIsSent) {
    const Served served(two_rungs(3));
    SourceOptions options = unpaced();
    std::atomic<int> asked = 0;
    options.slots = [&](const protocol::StreamHeader& header, std::optional<double>) {
        EXPECT_EQ(header.tracks.size(), 3u);
        ++asked;
        return kFine;
    };
    Client client(served.url(), options);
    ASSERT_TRUE(client.wait_ready(kPatience).ok());
    const auto arrivals = play_all(client);
    ASSERT_EQ(arrivals.size(), 10u);
    for (const Arrival& arrival : arrivals)
        if (arrival.group) { EXPECT_NE(arrival.group->slot, 1); }
    EXPECT_EQ(asked, 1);
    EXPECT_DOUBLE_EQ(client.statistics().until, 3);
    client.seek(1);
    EXPECT_LE(client.statistics().until, 3);
    EXPECT_EQ(play_all(client).size(), 7u);
}

}  // namespace
}  // namespace mien::net
