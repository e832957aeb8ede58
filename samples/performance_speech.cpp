#include <algorithm>
#include <cmath>

#include "samples/performance.hpp"
#include "samples/performance_liveliness.hpp"
#include "samples/viseme.hpp"

namespace mien::samples {
namespace {

constexpr double kLeadIn = 0.45, kTail = 0.75, kBetween = 0.7;  // s of listening before, after and between

/// Phrases are what lies between pauses; the last one of each sentence ends it.
std::vector<Phrase> phrases_of(const Utterance& utterance) {
    std::vector<Phrase> phrases;
    for (std::size_t i = 0; i < utterance.words.size(); ++i) {
        const Word& word = utterance.words[i];
        const bool joins = i > 0 && word.sentence == utterance.words[i - 1].sentence && word.start - utterance.words[i - 1].end < 0.12;
        if (!joins) phrases.push_back({word.start, word.end, false});
        phrases.back().end = word.end;
        if (i + 1 == utterance.words.size() || utterance.words[i + 1].sentence != word.sentence)
            phrases.back().ends_sentence = true;
    }
    return phrases;
}

/// The most prominent vowel of each word: loud, long, and not reduced. Words that stand out get an accent.
std::vector<Accent> accents_of(const Utterance& utterance, const MouthTrack& mouth) {
    struct Candidate {
        double time, prominence;
    };
    std::vector<Candidate> found;
    for (const Word& word : utterance.words) {
        Candidate best{0, 0};
        for (const Phoneme& phoneme : utterance.phonemes) {
            if (phoneme.start < word.start - 1e-6 || phoneme.start >= word.end || phoneme.ipa.empty()) continue;
            static const std::u32string_view kFull = U"aæɑʌɐɛeiɪɜɒɔoʊu";
            const std::size_t size = phoneme.ipa.size();
            char32_t letter = static_cast<unsigned char>(phoneme.ipa[0]);
            if (letter >= 0xc0 && size >= 2) letter = (letter & 0x1f) << 6 | (static_cast<unsigned char>(phoneme.ipa[1]) & 0x3f);
            if (kFull.find(letter) == kFull.npos) continue;
            const double duration = std::min(phoneme.end - phoneme.start, 0.25);
            const double middle = 0.5 * (phoneme.start + phoneme.end);
            const double prominence = duration * mouth.loudness(middle) * std::min(1.0, (word.end - word.start) / 0.3);
            if (prominence > best.prominence) best = {middle, prominence};
        }
        if (best.prominence > 0) found.push_back(best);
    }
    if (found.empty()) return {};
    std::vector<double> sorted;
    for (const Candidate& c : found) sorted.push_back(c.prominence);
    std::sort(sorted.begin(), sorted.end());
    const double middle = sorted[sorted.size() / 2], top = sorted[sorted.size() * 9 / 10];
    std::vector<Accent> accents;
    for (const Candidate& c : found) {
        if (c.prominence < middle || (!accents.empty() && c.time - accents.back().time < 0.38)) continue;
        const double strength = top > middle ? (c.prominence - middle) / (top - middle) : 1;
        accents.push_back({c.time, float(std::clamp(0.35 + 0.65 * strength, 0.0, 1.0)), strength > 0.45});
    }
    return accents;
}

}  // namespace

Performance perform_speech(const Utterance& utterance, Rational frame_rate, double seconds, std::uint64_t seed) {
    const double said = utterance.sound.seconds();
    if (seconds <= 0) seconds = kLeadIn + said + kTail;
    const std::int64_t frames = frames_in(seconds, frame_rate);
    seconds = double(frames) / frame_rate.value();

    std::vector<double> starts = {std::min(kLeadIn, std::max(0.0, seconds - said))};
    while (starts.back() + 2 * said + kBetween + 0.3 <= seconds) starts.push_back(starts.back() + said + kBetween);

    const MouthTrack mouth(utterance);
    std::vector<Phrase> phrases;
    std::vector<Accent> accents;
    for (double start : starts) {
        for (Phrase p : phrases_of(utterance))
            if (start + p.start < seconds) phrases.push_back({p.start + start, p.end + start, p.ends_sentence});
        for (Accent a : accents_of(utterance, mouth)) accents.push_back({a.time + start, a.strength, a.brows});
    }
    const Liveliness life(seconds, std::move(accents), std::move(phrases), seed);

    Performance performance{frame_rate, std::vector<Instant>(std::size_t(frames)), Sound{}};
    for (std::int64_t f = 0; f < frames; ++f) {
        const double time = double(f) / frame_rate.value();
        Instant& instant = performance.instants[std::size_t(f)];
        const auto again = std::find_if(starts.rbegin(), starts.rend() - 1, [&](double s) { return time >= s - 0.3; });
        add_mouth(mouth.at(time - *again), instant.weights);
        life.add(time, instant);
    }
    Sound& sound = *performance.sound;
    sound.sample_rate = utterance.sound.sample_rate;
    sound.samples.assign(std::size_t(std::llround(seconds * sound.sample_rate)), 0);
    for (double start : starts) {
        const auto at = std::size_t(std::llround(start * sound.sample_rate));
        const std::size_t count = std::min(utterance.sound.samples.size(), sound.samples.size() - std::min(at, sound.samples.size()));
        std::copy_n(utterance.sound.samples.begin(), count, sound.samples.begin() + std::ptrdiff_t(at));
        // Cut speech fades instead of clicking.
        const std::size_t fade = count < utterance.sound.samples.size() ? std::min<std::size_t>(count, std::size_t(sound.sample_rate) / 50) : 0;
        for (std::size_t i = 0; i < fade; ++i) sound.samples[at + count - 1 - i] *= float(i) / float(fade);
    }
    return performance;
}

}  // namespace mien::samples
