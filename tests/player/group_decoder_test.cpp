#include "player/group_decoder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

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
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
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
        DamageLog damage;
        GroupDecoder decoder(*opened.stream, damage);
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

/// All of it is of this track, in these seconds.
void expect_damage(const DamageLog& log, protocol::TrackKind track, std::vector<std::pair<double, double>> seconds) {
    const std::vector<Damage> stretches = log.stretches();
    ASSERT_EQ(stretches.size(), seconds.size());
    for (std::size_t i = 0; i < stretches.size(); ++i) {
        EXPECT_EQ(stretches[i].track, track);
        EXPECT_DOUBLE_EQ(stretches[i].first, seconds[i].first);
        EXPECT_DOUBLE_EQ(stretches[i].end, seconds[i].second);
    }
}

/// The small stream as it comes when these groups of its texture do not.
std::vector<PlayFrame> without_textures(Opened& opened, const std::set<std::uint32_t>& lost, DamageLog& damage) {
    GroupDecoder decoder(*opened.stream, damage);
    decoder.restart(0);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group) && !(lost.contains(group.group) && group.slot == opened.stream->texture_rungs[0].slot)) decoder.add(group);
    decoder.finish();
    return drain(decoder);
}

TEST(GroupDecoder, WhereItsTextureIsLostTheMotionGoesOnWithoutAnotherFramesPicture) {
    const encoder::EncodedStream encoded = small_stream();
    for (const std::set<std::uint32_t>& lost : {std::set<std::uint32_t>{1}, {0}, {3}, {0, 1, 2, 3}, {1, 2}}) {
        Opened opened(encoded);
        DamageLog damage;
        const std::vector<PlayFrame> frames = without_textures(opened, lost, damage);
        ASSERT_EQ(numbers(frames), range(0, kFrames));
        for (const PlayFrame& frame : frames) {
            EXPECT_EQ(frame.texture.has_value(), !lost.contains(std::uint32_t(frame.frame / 5))) << frame.frame;
            EXPECT_EQ(frame.texture ? frame.texture->frame : frame.frame, frame.frame);
            EXPECT_EQ(frame.motion.frame, frame.frame);
        }
        expect_damage(damage, protocol::TrackKind::texture, {{0.5 * *lost.begin(), 0.5 * (*lost.rbegin() + 1)}});
    }
}

TEST(GroupDecoder, APictureThatCannotBeDecodedCostsNoMotion) {
    Opened opened(small_stream());
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
    decoder.restart(0);
    for (protocol::Group group : opened.encoded.groups) {
        if (!opened.is_visual(group)) continue;
        if (group.group == 2 && opened.stream->texture_rung_of(group.slot)) group.objects[2].frames = 7;   // what no encoder writes
        decoder.add(std::move(group));
    }
    decoder.finish();
    EXPECT_EQ(numbers(drain(decoder)), range(0, kFrames));
    EXPECT_EQ(decoder.damaged_groups(), 1u);
    const auto stretches = damage.stretches();
    ASSERT_EQ(stretches.size(), 1u);
    EXPECT_GE(stretches[0].first, 1.0);
    EXPECT_DOUBLE_EQ(stretches[0].end, 1.5);
}

TEST(GroupDecoder, ADamagedMotionGroupCostsItselfOnly) {
    Opened opened(small_stream(false));
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
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
    expect_damage(damage, protocol::TrackKind::motion, {{1.0, 1.5}});
}

TEST(GroupDecoder, ASeekIntoAGroupStartsAtItsFrame) {
    Opened opened(small_stream());
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
    decoder.restart(7);
    for (const auto& group : opened.encoded.groups)
        if (opened.is_visual(group) && group.group >= 1) decoder.add(group);
    decoder.finish();
    EXPECT_EQ(numbers(drain(decoder)), range(7, kFrames));
}

TEST(GroupDecoder, AWholeClipInOneGroupComesAPictureAtATime) {
    Opened opened(small_stream(true, false, std::nullopt));
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
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
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
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
    DamageLog damage;
    GroupDecoder decoder(*opened.stream, damage);
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

TEST(DamageLog, StretchesThatTouchAreOneAndWhatIsMetAgainIsNotNew) {
    using protocol::TrackKind;
    DamageLog log;
    log.note({TrackKind::texture, 1, 2});
    log.note({TrackKind::texture, 2, 3});
    log.note({TrackKind::motion, 2, 3});
    log.note({TrackKind::texture, 5, 6});
    log.note({TrackKind::texture, 1.5, 2.5});
    const auto stretches = log.stretches();
    ASSERT_EQ(stretches.size(), 3u);
    EXPECT_EQ(describe(stretches[0]), "texture damaged or missing from 0:01.00 to 0:03.00");
    EXPECT_EQ(describe(stretches[1]), "motion damaged or missing from 0:02.00 to 0:03.00");
    EXPECT_EQ(describe({TrackKind::sound, 59.999, 3661.25}), "sound damaged or missing from 1:00.00 to 61:01.25");
}

}  // namespace
}  // namespace mien::player
