#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "player/session.hpp"
#include "tests/player/small_stream.hpp"

namespace mien::player {
namespace {

/// As a movie is made: the sound by itself, and as soon as there is enough of it pictures without sound, while the first pass still runs.
TEST(DecodeThread, WhatAChangeOfSlotsFindsOnItsWayIsNotLookedThroughForTheNewOnes) {
    const TemporaryFolder folder;
    const std::string path = store(small_stream(), folder);
    std::promise<void> heard, go_on;
    bool first = true;
    SessionOptions options;
    options.sound = options.sound_first = true;
    options.sound_sink = [&](const StreamModel&) {
        return [&](const decoder::SoundDecoder::Block&) {
            if (!std::exchange(first, false)) return;
            heard.set_value();
            go_on.get_future().wait();
        };
    };
    auto session = open_session(path, std::move(options));
    ASSERT_TRUE(session.ok()) << session.error().message;
    DecodeThread& decode = *session->decode;
    decode.start(0);
    heard.get_future().wait();
    std::thread seeker([&] { decode.seek(0, {}, session->stream->slots() & ~(std::uint64_t(1) << session->stream->sound_slot)); });
    go_on.set_value();   // the seek waits for the sink, and then races with the rest of the sound
    seeker.join();
    std::int64_t pictures = 0;
    while (decode.wait_pop([] { return false; })) ++pictures;
    EXPECT_EQ(pictures, kFrames);
    for (const Damage& damage : decode.damage().stretches()) ADD_FAILURE() << describe(damage);
}

}  // namespace
}  // namespace mien::player
