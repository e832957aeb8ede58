#include "samples/viseme.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace mien::samples {
namespace {

constexpr double kTrackRate = 240;  // samples per second

struct Shape {
    std::u32string_view letters;
    Articulation target;     // jaw close tuck round funnel spread upper lower
    Articulation dominance;
};

// Targets are for clear but relaxed speech. Vowels insist on jaw and lip shape; consonants on what makes them; what the
// tongue does alone leaves the lips to the neighbours.
constexpr Articulation kVowel = {1.0f, 0.9f, 0.9f, 0.9f, 0.8f, 0.8f, 0.6f, 0.7f};
constexpr Articulation kReduced = {0.5f, 0.7f, 0.7f, 0.35f, 0.35f, 0.3f, 0.4f, 0.4f};
constexpr Articulation kRounded = {1.0f, 0.9f, 0.9f, 1.6f, 1.2f, 1.2f, 0.6f, 0.8f};
constexpr Articulation kLips = {1.3f, 3.0f, 1.0f, 0.25f, 0.3f, 0.25f, 1.0f, 1.0f};
constexpr Articulation kLabiodental = {1.3f, 1.0f, 3.0f, 0.3f, 0.4f, 0.3f, 1.4f, 1.4f};
constexpr Articulation kTongue = {0.55f, 0.8f, 0.8f, 0.2f, 0.2f, 0.2f, 0.35f, 0.45f};
constexpr Articulation kSibilant = {1.5f, 1.0f, 1.0f, 0.3f, 0.4f, 0.6f, 0.8f, 0.9f};
constexpr Articulation kHush = {1.4f, 1.0f, 1.0f, 0.9f, 1.6f, 0.9f, 0.8f, 0.8f};
constexpr Articulation kGlide = {0.8f, 0.9f, 0.9f, 2.2f, 1.4f, 1.2f, 0.6f, 0.6f};
constexpr Articulation kBack = {0.4f, 0.8f, 0.8f, 0.12f, 0.12f, 0.12f, 0.2f, 0.25f};
constexpr Articulation kUnseen = {0.06f, 0.3f, 0.3f, 0.04f, 0.04f, 0.04f, 0.05f, 0.05f};
constexpr Articulation kPause = {0.5f, 0.5f, 0.5f, 0.3f, 0.4f, 0.3f, 0.5f, 0.5f};

constexpr Shape kShapes[] = {
    // letters        jaw   close tuck  round funnel spread upper lower
    {U"a",           {.44f, 0, 0, .00f, .00f, .16f, .06f, .16f}, kVowel},
    {U"æ",           {.40f, 0, 0, .00f, .00f, .34f, .10f, .22f}, kVowel},
    {U"ɑ",           {.46f, 0, 0, .00f, .06f, .00f, .03f, .12f}, kVowel},
    {U"ʌɐ",          {.34f, 0, 0, .00f, .03f, .08f, .05f, .14f}, kVowel},
    {U"ɛe",          {.29f, 0, 0, .00f, .00f, .36f, .07f, .18f}, kVowel},
    {U"ɪɨ",          {.17f, 0, 0, .00f, .00f, .34f, .06f, .16f}, kVowel},
    {U"i",           {.12f, 0, 0, .00f, .00f, .62f, .08f, .22f}, kVowel},
    {U"ɜɝ",          {.20f, 0, 0, .12f, .22f, .00f, .08f, .14f}, kVowel},
    {U"əɚɵ",         {.17f, 0, 0, .05f, .06f, .05f, .04f, .10f}, kReduced},
    {U"ɒɔ",          {.33f, 0, 0, .25f, .38f, .00f, .04f, .10f}, kRounded},
    {U"oɤ",          {.25f, 0, 0, .42f, .34f, .00f, .02f, .06f}, kRounded},
    {U"ʊɯ",          {.14f, 0, 0, .52f, .22f, .00f, .02f, .06f}, kRounded},
    {U"uʉ",          {.10f, 0, 0, .78f, .18f, .00f, .00f, .03f}, kRounded},
    {U"yøœ",         {.14f, 0, 0, .66f, .24f, .00f, .02f, .05f}, kRounded},
    {U"pbm",         {.05f, 1, 0, .00f, .00f, .04f, .00f, .00f}, kLips},
    {U"fvɱ",         {.08f, 0, 1, .00f, .00f, .10f, .22f, .00f}, kLabiodental},
    {U"wʍ",          {.09f, 0, 0, .82f, .14f, .00f, .00f, .00f}, kGlide},
    {U"θð",          {.12f, 0, 0, .00f, .04f, .10f, .10f, .22f}, kSibilant},
    {U"szɕʑ",        {.05f, 0, 0, .00f, .06f, .32f, .12f, .26f}, kSibilant},
    {U"ʃʒ",          {.07f, 0, 0, .18f, .58f, .00f, .14f, .20f}, kHush},
    {U"tdnlɾɬʈɖɳɭ",  {.11f, 0, 0, .00f, .00f, .16f, .06f, .16f}, kTongue},
    {U"ɹrɻɽ",        {.13f, 0, 0, .30f, .24f, .00f, .04f, .10f}, {.6f, .9f, .9f, .9f, .8f, .5f, .4f, .4f}},
    {U"jçʎɲ",        {.10f, 0, 0, .00f, .00f, .40f, .06f, .16f}, {.6f, .9f, .9f, .4f, .4f, .6f, .4f, .4f}},
    {U"kɡgŋxɣqχʁc",  {.18f, 0, 0, .00f, .00f, .08f, .04f, .12f}, kBack},
};

// Standard deviations of the blending kernels in seconds: before a sound (anticipation), and after it (carry-over).
constexpr double kBefore[kArticulatorCount] = {.042, .020, .026, .070, .060, .050, .034, .034};
constexpr double kAfter[kArticulatorCount] = {.036, .016, .022, .046, .042, .042, .030, .030};
constexpr double kLead = 0.020;    // lips are seen ahead of what is heard
constexpr double kMargin = 0.4;    // the track begins before the sound and ends after it: lips anticipate

std::vector<char32_t> letters_of(const std::string& ipa) {
    std::vector<char32_t> letters;
    for (std::size_t i = 0; i < ipa.size();) {
        const auto lead = static_cast<unsigned char>(ipa[i]);
        const int size = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
        char32_t letter = size == 1 ? lead : lead & (0xff >> (size + 1));
        for (int k = 1; k < size && i + std::size_t(k) < ipa.size(); ++k)
            letter = letter << 6 | (static_cast<unsigned char>(ipa[i + std::size_t(k)]) & 0x3f);
        letters.push_back(letter);
        i += std::size_t(size);
    }
    return letters;
}

bool is_bilabial(char32_t letter) { return letter == U'p' || letter == U'b' || letter == U'm'; }
bool is_labiodental(char32_t letter) { return letter == U'f' || letter == U'v' || letter == U'ɱ'; }

/// Convolves with the kernel of articulator `a`: each input spreads to earlier samples with kBefore, to later with kAfter.
std::vector<float> spread_in_time(const std::vector<float>& in, int a) {
    const int before = int(3 * kBefore[a] * kTrackRate), after = int(3 * kAfter[a] * kTrackRate);
    std::vector<float> kernel;
    for (int i = -before; i <= after; ++i) {
        const double x = i / kTrackRate / (i < 0 ? kBefore[a] : kAfter[a]);
        kernel.push_back(float(std::exp(-0.5 * x * x)));
    }
    std::vector<float> out(in.size(), 0);
    for (int n = 0; n < int(in.size()); ++n)
        for (int i = -before; i <= after; ++i)
            if (n + i >= 0 && n + i < int(in.size())) out[std::size_t(n + i)] += kernel[std::size_t(i + before)] * in[std::size_t(n)];
    return out;
}

template <class T>
T interpolate(const std::vector<T>& samples, double time) {
    const double x = std::clamp((time + kMargin) * kTrackRate, 0.0, double(samples.size() - 1));
    const auto i = std::min(std::size_t(x), samples.size() - 2);
    const float part = float(x - double(i));
    if constexpr (std::is_same_v<T, float>) {
        return samples[i] + part * (samples[i + 1] - samples[i]);
    } else {
        T mixed = samples[i];
        for (std::size_t k = 0; k < mixed.size(); ++k) mixed[k] += part * (samples[i + 1][k] - samples[i][k]);
        return mixed;
    }
}

}  // namespace

Viseme viseme_of(char32_t letter) {
    for (const Shape& shape : kShapes)
        if (shape.letters.find(letter) != shape.letters.npos) return {shape.target, shape.dominance};
    return {{}, kUnseen};
}

MouthTrack::MouthTrack(const Utterance& utterance) {
    const double length = utterance.sound.seconds();
    const auto count = std::size_t((length + 2 * kMargin) * kTrackRate) + 2;
    std::vector<Viseme> asked(count, Viseme{{}, kPause});
    auto fill = [&](double start, double end, const Viseme& viseme) {
        const int first = std::max(0, int(std::ceil((start + kMargin - kLead) * kTrackRate)));
        const int last = std::min(int(count), int(std::ceil((end + kMargin - kLead) * kTrackRate)));
        for (int i = first; i < last; ++i) asked[std::size_t(i)] = viseme;
    };
    struct Hold {
        double start, end;
        Viseme viseme;
    };
    std::vector<Hold> holds;
    for (const Phoneme& phoneme : utterance.phonemes) {
        std::vector<char32_t> letters = letters_of(phoneme.ipa);
        std::erase_if(letters, [](char32_t c) { return c == U'ː' || c == U'ˈ' || c == U'ˌ' || c == U'\u0329' || c == U'\u0361'; });
        const double duration = phoneme.end - phoneme.start;
        if (letters.empty()) {
            Viseme rest{{}, kPause};
            // A short pause keeps the lips where they are; a long one lets the mouth close.
            for (float& d : rest.dominance) d *= float(std::clamp(duration / 0.25, 0.3, 2.0));
            fill(phoneme.start, phoneme.end, rest);
        }
        for (std::size_t i = 0; i < letters.size(); ++i) {
            const double start = phoneme.start + duration * double(i) / double(letters.size());
            const double end = phoneme.start + duration * double(i + 1) / double(letters.size());
            const Viseme viseme = viseme_of(letters[i]);
            fill(start, end, viseme);
            // Lips need a moment to be seen closed: a stop's closure is the silence before its burst.
            if (is_bilabial(letters[i])) {
                const bool stop = letters[i] != U'm';
                const double from = start - (stop ? 0.045 : 0.008);
                holds.push_back({from, std::max(from + 0.075, stop ? start + 0.5 * (end - start) : end - 0.012), viseme});
            } else if (is_labiodental(letters[i])) {
                holds.push_back({start - 0.012, std::max(start + 0.06, end - 0.015), viseme});
            }
        }
    }
    for (const Hold& hold : holds) fill(hold.start, hold.end, hold.viseme);

    samples_.resize(count);
    std::vector<float> weighted(count), dominance(count);
    for (int a = 0; a < kArticulatorCount; ++a) {
        for (std::size_t i = 0; i < count; ++i) {
            dominance[i] = asked[i].dominance[std::size_t(a)];
            weighted[i] = dominance[i] * asked[i].target[std::size_t(a)];
        }
        const auto top = spread_in_time(weighted, a), bottom = spread_in_time(dominance, a);
        for (std::size_t i = 0; i < count; ++i) samples_[i][std::size_t(a)] = top[i] / bottom[i];
    }

    // Loudness: RMS over 25 ms each side, relative to the loud parts of the utterance.
    const Sound& sound = utterance.sound;
    std::vector<double> energy(std::size_t(sound.length()) + 1, 0);
    for (std::int64_t n = 0; n < sound.length(); ++n) {
        const double s = sound.samples[std::size_t(n * sound.channels)];
        energy[std::size_t(n) + 1] = energy[std::size_t(n)] + s * s;
    }
    loudness_.resize(count);
    const auto half = std::int64_t(0.025 * sound.sample_rate);
    for (std::size_t i = 0; i < count; ++i) {
        const auto centre = std::int64_t((double(i) / kTrackRate - kMargin) * sound.sample_rate);
        const auto from = std::clamp<std::int64_t>(centre - half, 0, sound.length());
        const auto to = std::clamp<std::int64_t>(centre + half, 0, sound.length());
        loudness_[i] = to > from ? float(std::sqrt((energy[std::size_t(to)] - energy[std::size_t(from)]) / double(to - from))) : 0;
    }
    std::vector<float> sorted = loudness_;
    std::sort(sorted.begin(), sorted.end());
    const float loud = sorted[sorted.size() * 85 / 100];
    for (float& l : loudness_) l = loud > 0 ? std::min(l / loud, 1.5f) : 0;

    // Louder syllables open wider. The loudness is smoothed far more slowly than the mouth moves.
    const auto slow = spread_in_time(loudness_, kRound);
    const auto ones = spread_in_time(std::vector<float>(count, 1), kRound);
    for (std::size_t i = 0; i < count; ++i) {
        const float emphasis = std::clamp(0.74f + 0.36f * slow[i] / ones[i], 0.74f, 1.22f);
        for (int a : {kJaw, kSpread, kUpper, kLower}) samples_[i][std::size_t(a)] *= emphasis;
    }
}

Articulation MouthTrack::at(double time) const {
    return interpolate(samples_, time);
}

float MouthTrack::loudness(double time) const {
    return interpolate(loudness_, time);
}

void add_mouth(const Articulation& mouth, std::array<float, kArkitCount>& weights) {
    static const auto index = [](std::string_view name) { return std::size_t(arkit_index(name)); };
    static const std::size_t jaw = index("JawOpen"), close = index("MouthClose"), funnel = index("MouthFunnel"),
                             pucker = index("MouthPucker"), smile = index("MouthSmileLeft"),
                             stretch = index("MouthStretchLeft"), dimple = index("MouthDimpleLeft"),
                             roll_lower = index("MouthRollLower"), roll_upper = index("MouthRollUpper"),
                             shrug_lower = index("MouthShrugLower"), press = index("MouthPressLeft"),
                             lower = index("MouthLowerDownLeft"), upper = index("MouthUpperUpLeft");
    // Closing takes the last stretch to full contact: lips are soft and press together.
    const float closed = std::clamp(1.12f * mouth[kClose] - 0.06f, 0.f, 1.f);
    const float tucked = std::clamp(1.10f * mouth[kTuck] - 0.05f, 0.f, 1.f);
    const float open = 1 - closed;
    weights[jaw] += mouth[kJaw];
    weights[close] += closed * mouth[kJaw];
    weights[pucker] += mouth[kRound];
    weights[funnel] += mouth[kFunnel] * (0.4f + 0.6f * open);
    weights[roll_lower] += 0.42f * tucked + 0.12f * closed;
    weights[roll_upper] += 0.10f * closed;
    weights[shrug_lower] += 0.18f * tucked;
    for (std::size_t side : {0, 1}) {
        weights[stretch + side] += 0.42f * mouth[kSpread];
        weights[smile + side] += 0.22f * mouth[kSpread];
        weights[dimple + side] += 0.12f * mouth[kSpread];
        weights[press + side] += 0.22f * closed;
        weights[lower + side] += mouth[kLower] * open * (1 - tucked);
        weights[upper + side] += mouth[kUpper] * open;
    }
}

}  // namespace mien::samples
