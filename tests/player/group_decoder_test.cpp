#include "player/group_decoder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "player/session.hpp"
#include "small_stream.hpp"

namespace mien::player {
namespace {

/// A stream in memory: its model ready, its groups at hand.
struct Opened {
    TemporaryFolder folder;
    encoder::EncodedStream encoded;
    std::unique_ptr<net::StreamSource> source;
    std::unique_ptr<StreamModel> stream;

    explicit Opened(encoder::EncodedStream made) : encoded(std::move(made)) {
        auto opened = net::open_source(store(encoded, folder));
        EXPECT_TRUE(opened.ok());
        source = std::move(*opened);
        EXPECT_TRUE(source->wait_ready(std::chrono::seconds(5)).ok());
        auto model = open_stream_model(*source, true);
        if (!model.ok()) throw std::runtime_error(model.error().message);
        stream = std::make_unique<StreamModel>(std::move(*model));
    }
    bool is_visual(const protocol::Group& group) const {
        return group.slot == stream->motion_slots.front() || stream->texture_rung_of(group.slot);
    }
};

TEST(StreamModel, TakesTheRungOfTextureThatIsAskedFor) {
    encoder::StreamOptions options;
    options.group_seconds = 0.5;
    options.texture->rungs = {{20, 0}, {60, 0}, {180, 0}};
    auto encoded = encoder::encode_stream(small_clip(true, true), options);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    // Rates that a numbered texture really takes are all alike; the choice goes by what the header says.
    std::vector<protocol::Rung>& rungs = encoded->header.tracks[1].rungs;
    ASSERT_EQ(rungs.size(), 3u);
    for (std::size_t r = 0; r < 3; ++r) rungs[r].bits_per_second = std::uint32_t(20000 * std::pow(3, r));
    const std::uint8_t first = rungs[0].slot;
    TemporaryFolder folder;
    auto source = net::open_source(store(*encoded, folder));
    ASSERT_TRUE(source.ok() && (*source)->wait_ready(std::chrono::seconds(5)).ok());
    const auto slot = [&](const TextureChoice& choice) { return int(open_stream_model(**source, false, 64, choice)->first_texture_rung); };
    EXPECT_EQ(slot({}), 2);
    EXPECT_EQ(slot({.rung = 0, .kbps = {}}), 0);
    EXPECT_EQ(slot({.rung = 1, .kbps = {}}), 1);
    EXPECT_EQ(slot({.rung = 9, .kbps = {}}), 2);
    EXPECT_EQ(slot({.rung = {}, .kbps = 100}), 1);
    EXPECT_EQ(slot({.rung = {}, .kbps = 60}), 1);
    EXPECT_EQ(slot({.rung = {}, .kbps = 5}), 0);

    // Only that rung is read, and it plays.
    SessionOptions wanted;
    wanted.texture.rung = 1;
    auto session = open_session(store(*encoded, folder), std::move(wanted));
    ASSERT_TRUE(session.ok()) << session.error().message;
    session->decode->start();
    for (std::int64_t f = 0; f < kFrames; ++f) {
        const auto frame = session->decode->wait_pop({});
        ASSERT_TRUE(frame && frame->texture);
        EXPECT_EQ(frame->frame, f);
    }
    EXPECT_GT(session->decode->bytes_of(std::uint8_t(first + 1)), 0u);
    EXPECT_EQ(session->decode->bytes_of(first), 0u);
    EXPECT_EQ(session->decode->bytes_of(std::uint8_t(first + 2)), 0u);
}

std::vector<PlayFrame> drain(GroupDecoder& decoder) {
    std::vector<PlayFrame> frames;
    while (decoder.has_work())
        for (PlayFrame& frame : decoder.step()) frames.push_back(std::move(frame));
    return frames;
}

std::vector<std::int64_t> numbers(const std::vector<PlayFrame>& frames) {
    std::vector<std::int64_t> numbers;
    for (const PlayFrame& frame : frames) numbers.push_back(frame.frame);
    return numbers;
}

std::vector<std::int64_t> range(std::int64_t first, std::int64_t end) {
    std::vector<std::int64_t> numbers;
    for (std::int64_t f = first; f < end; ++f) numbers.push_back(f);
    return numbers;
}

TEST(GroupDecoder, ShowsEveryFrameOnceWithItsOwnTexture) {
    Opened opened(small_stream());
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group)) decoder.add(group);
    decoder.finish();
    const std::vector<PlayFrame> frames = drain(decoder);
    ASSERT_EQ(numbers(frames), range(0, kFrames));
    for (const PlayFrame& frame : frames) {
        EXPECT_EQ(frame.motion.frame, frame.frame);
        ASSERT_TRUE(frame.texture);
        EXPECT_EQ(frame.texture->frame, frame.frame);
        EXPECT_NEAR(decoder::to_rgb(frame.texture->picture).at(32, 32)[1], 40 + 8 * int(frame.frame), 3);
        // The ball grows by half a millimetre a frame.
        const Points points = model::evaluate(opened.stream->model, opened.stream->composed, frame.motion);
        EXPECT_NEAR(points.rowwise().norm().maxCoeff(), 90 + 0.5 * double(frame.frame), 0.6);
    }
    EXPECT_TRUE(decoder.drained());
    EXPECT_EQ(decoder.damaged_groups(), 0u);
}

TEST(GroupDecoder, RefinementsSharpenAndWithoutThemNothingIsLeftOut) {
    Opened opened(small_stream(false, false, 0.5, 3));
    ASSERT_EQ(opened.stream->motion_slots.size(), 3u);
    const auto worst = [&](auto&& comes) {
        GroupDecoder decoder(*opened.stream);
        decoder.restart(0);
        for (const auto& group : opened.encoded.groups)
            if (comes(group)) decoder.add(group);
        decoder.finish();
        const std::vector<PlayFrame> frames = drain(decoder);
        EXPECT_EQ(numbers(frames), range(0, kFrames));
        const Clip truth = small_clip(false, false);
        double sum = 0;
        for (const PlayFrame& frame : frames)
            sum += double((model::evaluate(opened.stream->model, opened.stream->composed, frame.motion) - truth.vertices->frame(frame.frame)).squaredNorm());
        return std::sqrt(sum / double(kFrames * truth.vertices->points));
    };
    const auto& slots = opened.stream->motion_slots;
    const double all = worst([](const auto&) { return true; });
    const double two = worst([&](const auto& group) { return group.slot != slots[2]; });
    const double one = worst([&](const auto& group) { return group.slot == slots[0]; });
    const double gap = worst([&](const auto& group) { return group.slot != slots[1]; });   // what refines a rung that is not there is left out
    EXPECT_LE(all, 0.101);
    EXPECT_LE(two, 0.201);
    EXPECT_LE(one, 0.401);
    EXPECT_LT(all, two);
    EXPECT_LT(two, one);
    EXPECT_EQ(gap, one);
}

TEST(GroupDecoder, AGroupWithoutItsTextureIsLeftOut) {
    Opened opened(small_stream());
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group) && !(group.group == 1 && group.slot == opened.stream->texture_rungs[0].slot)) decoder.add(group);
    decoder.finish();
    std::vector<std::int64_t> expected = range(0, 5);
    for (const std::int64_t f : range(10, kFrames)) expected.push_back(f);
    EXPECT_EQ(numbers(drain(decoder)), expected) << "geometry never comes with another frame's texture, or none";
    EXPECT_EQ(decoder.damaged_groups(), 1u);
}

TEST(GroupDecoder, ADamagedMotionGroupCostsItselfOnly) {
    Opened opened(small_stream(false));
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    for (protocol::Group group : opened.encoded.groups) {
        if (!opened.is_visual(group)) continue;
        if (group.group == 2) group.objects.front().frames = 0;   // what no encoder writes
        decoder.add(std::move(group));
    }
    decoder.finish();
    std::vector<std::int64_t> expected = range(0, 10);
    for (const std::int64_t f : range(15, kFrames)) expected.push_back(f);
    EXPECT_EQ(numbers(drain(decoder)), expected);
    EXPECT_EQ(decoder.damaged_groups(), 1u);
    EXPECT_FALSE(decoder.last_damage().empty());
}

TEST(GroupDecoder, ASeekIntoAGroupStartsAtItsFrame) {
    Opened opened(small_stream());
    GroupDecoder decoder(*opened.stream);
    decoder.restart(7);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group) && group.group >= 1) decoder.add(group);
    decoder.finish();
    EXPECT_EQ(numbers(drain(decoder)), range(7, kFrames));
}

TEST(GroupDecoder, AWholeClipInOneGroupComesAPictureAtATime) {
    Opened opened(small_stream(true, false, std::nullopt));
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    for (const auto& group : opened.encoded.groups) decoder.add(group);
    decoder.finish();
    std::vector<PlayFrame> frames;
    while (decoder.has_work()) {
        std::vector<PlayFrame> some = decoder.step();
        for (PlayFrame& frame : some) frames.push_back(std::move(frame));
    }
    EXPECT_EQ(numbers(frames), range(0, kFrames));
}

TEST(GroupDecoder, AsksForMoreOnlyWhenLittleWaits) {
    Opened opened(small_stream());
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    EXPECT_TRUE(decoder.wants_group());
    std::size_t taken = 0;
    for (const auto& group : opened.encoded.groups) {
        if (!opened.is_visual(group)) continue;
        if (!decoder.wants_group()) break;
        decoder.add(group);
        ++taken;
    }
    EXPECT_LT(taken, 8u) << "all eight groups of two tracks would mean no bound";
    drain(decoder);
    EXPECT_TRUE(decoder.wants_group());
}

TEST(GroupDecoder, ASlowMachineSkipsToTheGroupThatIsDue) {
    Opened opened(small_stream());
    GroupDecoder decoder(*opened.stream);
    decoder.restart(0);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group) && group.group <= 2) decoder.add(group);
    decoder.step();
    EXPECT_EQ(decoder.skip_to(3), 0) << "nothing later is due";
    EXPECT_GT(decoder.skip_to(6), 0) << "group 1 is due, group 0 is late";
    const std::vector<PlayFrame> frames = drain(decoder);
    ASSERT_FALSE(frames.empty());
    EXPECT_EQ(frames.front().frame, 5);
}

}  // namespace
}  // namespace mien::player
