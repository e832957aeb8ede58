#include "samples/speech.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <numbers>

#ifdef MIEN_HAVE_ESPEAK
#include <espeak-ng/speak_lib.h>
#endif

namespace mien::samples {

const char* const kDefaultText =
    "Hello! What you see is a face made of numbers. Every word, every blink, and even my smile, "
    "travels in a very small stream. Isn't that beautiful?";

#ifndef MIEN_HAVE_ESPEAK

bool can_speak() { return false; }

Result<Utterance> speak(const std::string&, const std::string&, int) {
    return Error{ErrorCode::unavailable,
                 "this build cannot speak: install libespeak-ng-dev and configure again, or give --weights a "
                 "Live Link Face CSV"};
}

#else

namespace {

constexpr int kRate = 48000;

struct Event {
    espeak_EVENT_TYPE type;
    std::int64_t sample;
    std::string name;
};

struct Recording {
    std::vector<float> samples;
    std::vector<Event> events;
};

// The library is one per process and calls back without telling for whom, so one utterance is made at a time.
std::mutex speaking;
Recording* recording = nullptr;

int on_sound(short* wave, int count, espeak_EVENT* event) {
    for (; event->type != espeakEVENT_LIST_TERMINATED; ++event) {
        if (event->type == espeakEVENT_PHONEME)
            recording->events.push_back({event->type, event->sample, {event->id.string, strnlen(event->id.string, 8)}});
        else if (event->type == espeakEVENT_WORD || event->type == espeakEVENT_SENTENCE)
            recording->events.push_back({event->type, event->sample, {}});
    }
    for (int i = 0; wave && i < count; ++i) recording->samples.push_back(wave[i] / 32768.f);
    return 0;
}

/// By name ("English (America)", "en+f3") or by language ("en-gb").
bool set_voice(const std::string& name) {
    if (espeak_SetVoiceByName(name.c_str()) == EE_OK) return true;
    // Asked by language the library always finds something, so what it found is looked at: byte 0 is a priority.
    espeak_VOICE wanted{};
    wanted.languages = name.c_str();
    if (espeak_SetVoiceByProperties(&wanted) != EE_OK) return false;
    const espeak_VOICE* found = espeak_GetCurrentVoice();
    for (const char* language = found ? found->languages : nullptr; language && *language; language += std::strlen(language) + 1)
        if (name == language + 1) return true;
    return false;
}

/// Band-limited change of sample rate: a Kaiser-windowed sinc of 48 taps, one set of taps per phase.
std::vector<float> change_rate(const std::vector<float>& in, int from, int to) {
    const Rational ratio = make_rational(from, to);  // input samples per output sample
    constexpr int kHalf = 24;
    const double cutoff = 0.94 * std::min(1.0, double(to) / from);
    std::vector<float> taps(std::size_t(ratio.den) * 2 * kHalf);
    for (std::int64_t phase = 0; phase < ratio.den; ++phase) {
        double sum = 0;
        float* row = &taps[std::size_t(phase) * 2 * kHalf];
        for (int i = 0; i < 2 * kHalf; ++i) {
            const double x = i - (kHalf - 1) - double(phase) / double(ratio.den);
            const double edge = std::max(0.0, 1 - x * x / (kHalf * kHalf));
            const double a = std::numbers::pi * cutoff * x;
            const double tap = (x == 0 ? 1 : std::sin(a) / a) * std::cyl_bessel_i(0, 8 * std::sqrt(edge));
            row[i] = float(tap);
            sum += tap;
        }
        for (int i = 0; i < 2 * kHalf; ++i) row[i] = float(row[i] / sum);
    }
    std::vector<float> out(in.size() * std::size_t(ratio.den) / std::size_t(ratio.num));
    for (std::size_t n = 0; n < out.size(); ++n) {
        const std::int64_t at = std::int64_t(n) * ratio.num;
        const std::int64_t first = at / ratio.den - (kHalf - 1);
        const float* row = &taps[std::size_t(at % ratio.den) * 2 * kHalf];
        float sum = 0;
        for (std::int64_t i = 0; i < 2 * kHalf; ++i)
            if (first + i >= 0 && first + i < std::int64_t(in.size())) sum += row[i] * in[std::size_t(first + i)];
        out[n] = std::clamp(sum, -1.f, 1.f);
    }
    return out;
}

Utterance make_utterance(const Recording& heard, int rate) {
    Utterance said;
    said.sound = {kRate, 1, change_rate(heard.samples, rate, kRate)};
    const double end = double(heard.samples.size()) / rate;
    int sentence = -1;
    for (const Event& event : heard.events) {
        const double time = std::min(end, double(event.sample) / rate);
        if (event.type == espeakEVENT_SENTENCE) ++sentence;
        if (event.type == espeakEVENT_WORD) said.words.push_back({time, end, std::max(0, sentence)});
        if (event.type == espeakEVENT_PHONEME) said.phonemes.push_back({event.name, time, end});
    }
    if (!said.phonemes.empty() && said.phonemes.front().start > 0)
        said.phonemes.insert(said.phonemes.begin(), {"", 0, said.phonemes.front().start});
    for (std::size_t i = 0; i + 1 < said.phonemes.size(); ++i) said.phonemes[i].end = said.phonemes[i + 1].start;
    // The library tells of a word twice when a pause comes before it.
    const auto again = [](const Word& a, const Word& b) { return b.start - a.start < 1e-6; };
    said.words.erase(std::unique(said.words.begin(), said.words.end(), again), said.words.end());
    for (std::size_t i = 0; i < said.words.size(); ++i) {
        Word& word = said.words[i];
        if (i + 1 < said.words.size()) word.end = said.words[i + 1].start;
        for (const Phoneme& phoneme : said.phonemes)  // the pause after a word is no part of it
            if (phoneme.ipa.empty() && phoneme.start > word.start) word.end = std::min(word.end, phoneme.start);
    }
    return said;
}

}  // namespace

bool can_speak() { return true; }

Result<Utterance> speak(const std::string& text, const std::string& voice, int words_per_minute) {
    if (text.size() > 10'000) return Error{ErrorCode::limit_exceeded, "the text to say is longer than 10 000 bytes"};
    const std::lock_guard lock(speaking);
    // Once per process: the library does not survive being ended and begun again.
    static const int rate = espeak_Initialize(AUDIO_OUTPUT_SYNCHRONOUS, 0, nullptr,
                                              espeakINITIALIZE_PHONEME_EVENTS | espeakINITIALIZE_PHONEME_IPA |
                                                  espeakINITIALIZE_DONT_EXIT);
    if (rate <= 0)
        return Error{ErrorCode::unavailable, "libespeak-ng cannot find its voices: install espeak-ng-data"};
    Recording heard;
    recording = &heard;
    const bool known = set_voice(voice);
    bool spoken = false;
    if (known) {
        espeak_SetParameter(espeakRATE, std::clamp(words_per_minute, espeakRATE_MINIMUM, espeakRATE_MAXIMUM), 0);
        espeak_SetParameter(espeakRANGE, 62, 0);
        espeak_SetParameter(espeakVOLUME, 90, 0);
        espeak_SetSynthCallback(on_sound);
        spoken = espeak_Synth(text.c_str(), text.size() + 1, 0, POS_CHARACTER, 0, espeakCHARS_UTF8 | espeakENDPAUSE,
                              nullptr, nullptr) == EE_OK &&
                 espeak_Synchronize() == EE_OK;
    }
    recording = nullptr;
    if (!known) return Error{ErrorCode::invalid, "libespeak-ng knows no voice named '" + voice + "'"};
    Utterance said = make_utterance(heard, rate);
    const bool silent =
        std::all_of(said.phonemes.begin(), said.phonemes.end(), [](const Phoneme& p) { return p.ipa.empty(); });
    if (!spoken || silent) return Error{ErrorCode::invalid, "there is nothing to pronounce in the text to say"};
    return said;
}

#endif

}  // namespace mien::samples
