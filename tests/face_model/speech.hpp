#pragma once

#include <string>
#include <vector>

#include "samples/performance.hpp"

namespace mien::samples {

/// Speech that no weight was tuned on, without a synthesiser: vowels, closures, rounding and spreading in turn.
inline Performance some_speech() {
    Utterance said;
    const std::vector<std::string> sounds = {"h", "ə", "l", "əʊ", "m", "aɪ", "f", "eɪ", "s", "p", "uː", "t", "iː", "w", "ɒ", "tʃ", "b", "ɑː", "v", "ʃ"};
    for (std::size_t i = 0; i < sounds.size(); ++i) said.phonemes.push_back({sounds[i], double(i) * 0.09, double(i + 1) * 0.09});
    said.sound.samples.assign(std::size_t(double(sounds.size()) * 0.09 * 48000), 0.1f);
    said.words = {{0, double(sounds.size()) * 0.09, 0}};
    return perform_speech(said, {30, 1}, 0, 3);
}

}  // namespace mien::samples
