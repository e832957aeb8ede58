#include "player/sound_output.hpp"

#include <AL/al.h>
#include <AL/alc.h>
#include <AL/alext.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

namespace mien::player {
namespace {

constexpr int kBuffers = 5;
constexpr double kBufferSeconds = 0.04;   // five of them ride over a scheduler's hiccup, one bounds the delay of a pause

struct CloseDevice {
    void operator()(ALCdevice* device) const { alcCloseDevice(device); }
};
struct DestroyContext {
    void operator()(ALCcontext* context) const {
        alcMakeContextCurrent(nullptr);
        alcDestroyContext(context);
    }
};

}  // namespace

struct SoundOutput::State {
    std::unique_ptr<ALCdevice, CloseDevice> device;
    std::unique_ptr<ALCcontext, DestroyContext> context;
    ALuint source = 0;
    std::array<ALuint, kBuffers> buffers{};
    LPALGETSOURCEDVSOFT latency = nullptr;   // sample offset and what the device still holds back
    int sample_rate = 48000;

    mutable std::mutex mutex;
    std::condition_variable wake;
    std::deque<Sound> blocks;                // pushed, mono or stereo, the first one starts at next_sample
    std::size_t block_offset = 0;            // samples of the first block that are used up
    std::int64_t next_sample = 0;            // the next one for the device
    std::int64_t pushed_end = 0;             // one after the last pushed sample
    std::vector<ALuint> idle;                // buffers not queued
    std::deque<std::int64_t> queued_start;   // first sample of each buffer queued in the source
    std::int64_t prebuffer = 0;              // samples
    bool playing = false, stopping = false;
    double rate = 1, volume = 1;
    bool muted = false;
    std::thread thread;

    void run();
    void feed();
    void take_back(ALint count);
    void stop_source();
    void set_gain();
    bool fill(ALuint buffer);
};

std::unique_ptr<SoundOutput> SoundOutput::open(int sample_rate, std::string* why) {
    auto state = std::make_unique<State>();
    const auto fail = [&](const char* reason) {
        if (why) *why = reason;
        return nullptr;
    };
    state->device.reset(alcOpenDevice(nullptr));
    if (!state->device) return fail("no sound device");
    state->context.reset(alcCreateContext(state->device.get(), nullptr));
    if (!state->context || !alcMakeContextCurrent(state->context.get())) return fail("the sound device refuses to play");
    alGenSources(1, &state->source);
    alGenBuffers(kBuffers, state->buffers.data());
    if (alGetError() != AL_NO_ERROR) return fail("the sound device has no free voice");
    if (alIsExtensionPresent("AL_SOFT_source_latency"))
        state->latency = reinterpret_cast<LPALGETSOURCEDVSOFT>(alGetProcAddress("alGetSourcedvSOFT"));
    state->idle.assign(state->buffers.begin(), state->buffers.end());
    state->sample_rate = sample_rate;
    state->thread = std::thread([s = state.get()] { s->run(); });
    return std::unique_ptr<SoundOutput>(new SoundOutput(std::move(state)));
}

SoundOutput::SoundOutput(std::unique_ptr<State> state) : state_(std::move(state)) {}

SoundOutput::~SoundOutput() {
    {
        const std::lock_guard lock(state_->mutex);
        state_->stopping = true;
    }
    state_->wake.notify_all();
    state_->thread.join();
    alSourceStop(state_->source);
    alDeleteSources(1, &state_->source);
    alDeleteBuffers(kBuffers, state_->buffers.data());
}

void SoundOutput::State::run() {
    std::unique_lock lock(mutex);
    while (!stopping) {
        feed();
        wake.wait_for(lock, std::chrono::milliseconds(10));
    }
}

bool SoundOutput::State::fill(ALuint buffer) {
    if (blocks.empty()) return false;
    const int channels = blocks.front().channels;
    const std::size_t wanted = std::size_t(sample_rate * kBufferSeconds);
    std::vector<std::int16_t> samples;
    samples.reserve(wanted * channels);
    while (samples.size() < wanted * channels && !blocks.empty() && blocks.front().channels == channels) {
        const Sound& block = blocks.front();
        const std::size_t left = std::size_t(block.length()) - block_offset;
        const std::size_t take = std::min(left, wanted - samples.size() / channels);
        for (std::size_t i = 0; i < take * channels; ++i) {
            const float v = std::clamp(block.samples[block_offset * channels + i], -1.0f, 1.0f);
            samples.push_back(static_cast<std::int16_t>(std::lrint(v * 32767)));
        }
        block_offset += take;
        if (block_offset == std::size_t(block.length())) {
            blocks.pop_front();
            block_offset = 0;
        }
    }
    if (samples.empty()) return false;
    alBufferData(buffer, channels == 1 ? AL_FORMAT_MONO16 : AL_FORMAT_STEREO16, samples.data(),
                 ALsizei(samples.size() * sizeof samples[0]), sample_rate);
    queued_start.push_back(next_sample);
    next_sample += std::int64_t(samples.size() / channels);
    return true;
}

void SoundOutput::State::take_back(ALint count) {
    for (; count > 0 && !queued_start.empty(); --count) {
        ALuint buffer = 0;
        alSourceUnqueueBuffers(source, 1, &buffer);
        idle.push_back(buffer);
        queued_start.pop_front();
    }
}

/// A stopped source calls everything in its queue processed, also what was queued after it stopped and nobody has heard. So what it
/// says is taken only while it plays or pauses, and a source that has run dry is rewound before it is given anything.
void SoundOutput::State::feed() {
    ALint processed = 0, what = 0;
    alGetSourcei(source, AL_BUFFERS_PROCESSED, &processed);
    alGetSourcei(source, AL_SOURCE_STATE, &what);
    if (what == AL_STOPPED) stop_source();
    else take_back(processed);
    const std::size_t before = queued_start.size();
    while (!idle.empty() && fill(idle.back())) {
        alSourceQueueBuffers(source, 1, &idle.back());
        idle.pop_back();
    }
    alGetSourcei(source, AL_SOURCE_STATE, &what);
    if (what == AL_STOPPED) {   // it ran dry meanwhile: only what was there before has been heard
        take_back(ALint(before));
        alSourceRewind(source);
    }
    if (playing && what != AL_PLAYING && !queued_start.empty() && pushed_end - queued_start.front() >= prebuffer) alSourcePlay(source);
}

/// Empties the queue. The source is then as if it had never played (AL_INITIAL), and what is queued next waits to be played.
void SoundOutput::State::stop_source() {
    alSourceRewind(source);
    alSourcei(source, AL_BUFFER, 0);
    idle.assign(buffers.begin(), buffers.end());
    queued_start.clear();
}

void SoundOutput::push(std::int64_t first_sample, Sound sound) {
    if (sound.channels > 2) {   // the device gets the first two; loudspeaker layouts are not known here
        Sound stereo{sound.sample_rate, 2, {}};
        for (std::int64_t i = 0; i < sound.length(); ++i)
            for (int c = 0; c < 2; ++c) stereo.samples.push_back(sound.samples[std::size_t(i) * sound.channels + c]);
        sound = std::move(stereo);
    }
    const std::lock_guard lock(state_->mutex);
    State& s = *state_;
    const std::int64_t end = first_sample + sound.length();
    if (end <= s.pushed_end) return;   // from before a seek into the middle of a group
    const std::int64_t overlap = std::max<std::int64_t>(0, s.pushed_end - first_sample);
    sound.samples.erase(sound.samples.begin(), sound.samples.begin() + overlap * sound.channels);
    const std::int64_t gap = std::max<std::int64_t>(0, first_sample - s.pushed_end);
    if (gap > 0)
        s.blocks.push_back({sound.sample_rate, sound.channels, std::vector<float>(std::size_t(gap) * sound.channels)});
    s.pushed_end = end;
    if (!sound.samples.empty()) s.blocks.push_back(std::move(sound));
}

void SoundOutput::flush(double media) {
    const std::lock_guard lock(state_->mutex);
    State& s = *state_;
    s.stop_source();
    s.blocks.clear();
    s.block_offset = 0;
    s.next_sample = s.pushed_end = std::llround(media * s.sample_rate);
}

void SoundOutput::set_prebuffer(double seconds) {
    const std::lock_guard lock(state_->mutex);
    state_->prebuffer = std::llround(seconds * state_->sample_rate);
}

void SoundOutput::play() {
    const std::lock_guard lock(state_->mutex);
    state_->playing = true;
    state_->wake.notify_all();
}

void SoundOutput::pause() {
    const std::lock_guard lock(state_->mutex);
    state_->playing = false;
    alSourcePause(state_->source);
}

void SoundOutput::set_rate(double rate) {
    const std::lock_guard lock(state_->mutex);
    state_->rate = rate;
    alSourcef(state_->source, AL_PITCH, float(rate));
}

void SoundOutput::State::set_gain() { alSourcef(source, AL_GAIN, muted ? 0.0f : float(volume * volume * volume)); }   // as loudness is heard

void SoundOutput::set_muted(bool muted) {
    const std::lock_guard lock(state_->mutex);
    state_->muted = muted;
    state_->set_gain();
}

void SoundOutput::set_volume(double volume) {
    const std::lock_guard lock(state_->mutex);
    state_->volume = std::clamp(volume, 0.0, 1.0);
    state_->set_gain();
}

std::optional<double> SoundOutput::heard() const {
    const std::lock_guard lock(state_->mutex);
    State& s = *state_;
    ALint what = 0;
    alGetSourcei(s.source, AL_SOURCE_STATE, &what);
    if (!s.playing || what != AL_PLAYING || s.queued_start.empty()) return std::nullopt;
    double offset = 0;
    if (s.latency) {
        ALdouble values[2] = {0, 0};   // offset in the queue, and seconds until it is heard
        s.latency(s.source, AL_SEC_OFFSET_LATENCY_SOFT, values);
        offset = values[0] - values[1] * s.rate;
    } else {
        ALfloat seconds = 0;
        alGetSourcef(s.source, AL_SEC_OFFSET, &seconds);
        offset = seconds;
    }
    return double(s.queued_start.front()) / s.sample_rate + offset;
}

double SoundOutput::buffered() const {
    const std::lock_guard lock(state_->mutex);
    return double(state_->pushed_end - state_->next_sample) / state_->sample_rate;
}

}  // namespace mien::player
