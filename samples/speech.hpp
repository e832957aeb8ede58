#pragma once

#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"

namespace mien::samples {

/// One sound of speech: from `start` to `end` seconds. A pause has an empty name.
struct Phoneme {
    std::string ipa;  ///< UTF-8, such as "m", "aɪ" or "tʃ"
    double start = 0;
    double end = 0;
};

/// One spoken word, in seconds.
struct Word {
    double start = 0;
    double end = 0;
    int sentence = 0;
};

/// Speech with the times of everything in it.
struct Utterance {
    Sound sound;                    ///< 48 kHz mono
    std::vector<Phoneme> phonemes;  ///< in order, without gaps
    std::vector<Word> words;
};

/// Whether this build can speak.
bool can_speak();

/// Synthesises `text` (UTF-8, at most 10 000 bytes) with libespeak-ng. `voice` is one of its voice names, such as "en-gb"
/// or "en-us"; `words_per_minute` 80 to 450. Errors: unavailable (built without libespeak-ng, or its voices are not
/// installed), invalid (no such voice, empty or too long text, nothing to pronounce).
Result<Utterance> speak(const std::string& text, const std::string& voice = "en-gb", int words_per_minute = 158);

/// What the stage says when nobody tells it what to say: about ten seconds.
extern const char* const kDefaultText;

}  // namespace mien::samples
