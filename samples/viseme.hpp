#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "samples/actor.hpp"
#include "samples/speech.hpp"

namespace mien::samples {

/// What can be seen of the speech organs, each 0 .. 1.
enum Articulator : int {
    kJaw,     ///< lowered
    kClose,   ///< lips meet whatever the jaw does (p, b, m)
    kTuck,    ///< lower lip against the upper teeth (f, v)
    kRound,   ///< small round opening (u, w)
    kFunnel,  ///< lips forward and open (sh, o)
    kSpread,  ///< corners apart (i, s)
    kUpper,   ///< upper lip raised off the teeth
    kLower,   ///< lower lip lowered off the teeth
    kArticulatorCount
};
using Articulation = std::array<float, kArticulatorCount>;

/// What one sound asks of each articulator, and how strongly it insists: the target and dominance of Cohen & Massaro,
/// "Modeling coarticulation in synthetic visual speech", 1993.
struct Viseme {
    Articulation target{};
    Articulation dominance{};
};

/// The viseme of one IPA letter; letters nobody can see on the lips (h, length marks) have next to no dominance.
Viseme viseme_of(char32_t letter);

/// The motion of the mouth through an utterance. Targets last as long as their sounds and are blended by normalised
/// convolution, sum(G * D T) / sum(G * D): G is a Gaussian of each articulator's own width, wider before the sound than
/// after it (rounding anticipates; the jaw is slower than the lips), D the dominance.
class MouthTrack {
public:
    explicit MouthTrack(const Utterance& utterance);
    /// At `time` seconds of the utterance; at rest outside it.
    Articulation at(double time) const;
    /// How loud the voice is, 0 in silence, about 1 in full vowels.
    float loudness(double time) const;

private:
    std::vector<Articulation> samples_;
    std::vector<float> loudness_;
};

/// Adds the mouth to ARKit weights. MouthClose equals JawOpen where the lips meet.
void add_mouth(const Articulation& mouth, std::array<float, kArkitCount>& weights);

}  // namespace mien::samples
