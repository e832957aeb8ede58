#include "io/surface_names.hpp"

#include <array>
#include <string>
#include <utility>

#include "io/text.hpp"

namespace mien::io {
namespace {

constexpr const char* kNames[] = {"skin", "eye", "cornea", "teeth", "mouth", "lashes", "hair", "other"};

// The first match counts, so what is said more precisely comes first: "eyelash" and "eyebrow" before "eye", "mouth inside"
// before "face". The clear films over the eyes (tears, occlusion) are drawn as the cornea is: see-through.
constexpr std::pair<std::string_view, Surface> kWords[] = {
    {"lash", Surface::lashes},     {"brow", Surface::hair},       {"hair", Surface::hair},      {"beard", Surface::hair},
    {"cornea", Surface::cornea},   {"lacrimal", Surface::cornea}, {"tear", Surface::cornea},    {"fluid", Surface::cornea},
    {"occlu", Surface::cornea},    {"eyeblend", Surface::cornea}, {"caruncle", Surface::skin},  {"eyelid", Surface::skin},
    {"teeth", Surface::teeth},     {"tooth", Surface::teeth},     {"dent", Surface::teeth},     {"gum", Surface::mouth},
    {"gingiva", Surface::mouth},   {"tongue", Surface::mouth},    {"mouth", Surface::mouth},    {"oral", Surface::mouth},
    {"sclera", Surface::eye},      {"iris", Surface::eye},        {"pupil", Surface::eye},      {"eye", Surface::eye},
    {"skin", Surface::skin},       {"face", Surface::skin},       {"head", Surface::skin},      {"neck", Surface::skin},
    {"lip", Surface::skin},        {"ear", Surface::skin},        {"cloth", Surface::other},    {"shirt", Surface::other},
    {"glass", Surface::other},     {"helmet", Surface::other},    {"scalp", Surface::skin},     {"body", Surface::skin},
};

}  // namespace

std::optional<Surface> surface_from_name(std::string_view name) {
    const std::string lower = lower_case(name);
    for (std::size_t s = 0; s < std::size(kNames); ++s)
        if (lower == kNames[s]) return static_cast<Surface>(s);
    for (const auto& [word, surface] : kWords)
        if (lower.find(word) != std::string::npos) return surface;
    return std::nullopt;
}

const char* name_of(Surface surface) { return kNames[static_cast<std::size_t>(surface) % std::size(kNames)]; }

}  // namespace mien::io
